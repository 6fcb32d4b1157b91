// The tensor of the solid → values of descriptors by the kernels' own code → values blended with the engine's.
#include "engine/creases/blend.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "descriptor/registry.h"
#include "engine/memory.h"
#include "support/cancel.h"
#include "support/parallel.h"
#include "support/pool.h"

#define KERNEL_TARGET creases
#define KERNEL SolidKernel
#define INTEGRAL 0
#define EXTRAPOLATED 0
#define GEODESIC_BALL 0
#define FACES 0
#define VARIATE 0
#define MAP 0
#define TERMS_JET 0
#define TERMS_GAUSSIANS 0
#define TERMS_TENSOR 0
#include "engine/kernels/kernels.h"

namespace paradesc {

using Kernel = kernels::SolidKernel<float, bool>;

namespace {

struct Solid {
  Kernel kernel;
  Kernel::Sums sums;
  Kernel::Neighborhood neighborhood;
};

using Value = std::array<float, 3>;
Value value_of(float value) { return {value}; }
Value value_of(const Kernel::vec3 &v) { return {v.x, v.y, v.z}; }

} // namespace

// The functions that compute the descriptors' values for a solid, by row of descriptors.def.
using RowOfSolid = Value (*)(const Solid &);
static constexpr RowOfSolid rows_of_solid[] = {
#define DESCRIPTOR(name, label, description, power, is_signed, neutral, low, high, components, needed)                           \
  [](const Solid &of) { return value_of(Kernel(of.kernel).name(of.sums.terms, of.sums.center, of.neighborhood)); },
#include "descriptor/descriptors.def"
#undef DESCRIPTOR
};

// Operators need a map, and areas do not depend on curvature.
static bool is_of_solid(int row) { return row < static_cast<int>(std::size(rows_of_solid)) && !uses_terms(row, "area"); }

// Returns the curvatures of a shape operator, the limit of its bending energy for radius 0, and the volume that belongs to H
// (paper eq. 8).
static Solid solid_of(const Kernel &kernel, const Kernel::Sums &sums, const Kernel::vec3 &shape) {
  Solid solid{kernel, sums, {}};
  const float radius = kernel.params.radius;
  solid.neighborhood = solid.kernel.unfitted_neighborhood(1.0f, 1.0f);
  solid.neighborhood.standard_error = 0.0f;
  solid.neighborhood.shape = shape;
  solid.kernel.find_directions(solid.sums.center, solid.neighborhood);
  solid.kernel.find_curvatures(solid.sums, solid.neighborhood);
  const Kernel::Neighborhood &found = solid.neighborhood;
  solid.sums.terms.bending.energy = 0.5f * (found.k1 * found.k1 + found.k2 * found.k2);
  solid.sums.terms.bending.weight = 1.0f;
  solid.sums.terms.ball.rho = 1.0f;
  solid.sums.terms.ball.height = -0.375f * radius * found.mean;
  return solid;
}

// Returns the value with a share of the solid's; if only one of them exists, it stands for both.
static float mixed(float value, float solid, float share) {
  if (share >= 1.0f || std::isnan(value)) return share > 0.5f ? solid : value;
  return std::isnan(solid) ? value : value + share * (solid - value);
}

// The rows from which the shape operator of an engine follows.
static std::array<int, 3> shape_rows() {
  return {find_descriptor("principal_curvature_max"), find_descriptor("principal_curvature_min"),
          find_descriptor("principal_direction_max")};
}

// Returns the shape operator with these eigenvalues in the center's tangents. direction: of k1, in space.
static Kernel::vec3 shape_of(float k1, float k2, const float *direction, const Kernel::Center &center) {
  const Kernel::vec3 d{direction[0], direction[1], direction[2]};
  const float x = dot(d, center.t1), y = dot(d, center.t2), gap = (k1 - k2) / (x * x + y * y);
  return {k2 + gap * x * x, gap * x * y, k2 + gap * y * y};
}

CreaseBlend::CreaseBlend(const Surface &surface, std::span<const int> rows, double radius, int32_t estimator,
                         const Resources &resources)
    : surface_(surface), radius_(radius), blends_curvatures_(estimator != PDESC_ESTIMATOR_INTEGRAL), threads_(resources.threads) {
  if (!surface.creases || surface.creases->edges.empty() || surface.maps.any() || std::ranges::none_of(rows, is_of_solid)) return;
  const int64_t triangles = surface.triangles.triangle_count;
  check_memory(resources.memory_limit, "The curvature beside creases on a surface of " + std::to_string(triangles) + " triangles",
               "use fewer triangles", triangles * bytes_of_creased_triangle(thread_count(threads_)), resources.memory_held);
  solid_.emplace(CreasedSurface{surface.triangles, surface.half_edges, surface.normals(), *surface.creases, surface.facets()},
                 radius);
}

namespace {

struct SolidPlace {
  dvec3 position;
  vec3 normal;
  int32_t triangle, point;
};

} // namespace

// Returns whether a row follows from the blended shape operator.
bool CreaseBlend::is_of_shape(int row) const {
  if (!is_of_solid(row)) return false;
  const DescriptorRow &of = descriptor_row(row);
  return of.components == 3 || (blends_curvatures_ && *of.terms == 0 && row != find_descriptor("standard_error"));
}

bool CreaseBlend::changes(std::span<const int> rows) const { return solid_ && std::ranges::any_of(rows, is_of_solid); }

std::vector<int> CreaseBlend::needed(std::span<const int> rows) const {
  std::vector<int> needed(rows.begin(), rows.end());
  if (!solid_ || std::ranges::none_of(rows, [&](int row) { return is_of_shape(row); })) return needed;
  for (const int row : shape_rows())
    if (std::ranges::find(needed, row) == needed.end()) needed.push_back(row);
  return needed;
}

static constexpr double share_before = 0.5;

Part CreaseBlend::before(const Part &whole) const {
  if (!solid_) return whole;
  return [whole](double done) { whole(share_before * done); };
}

template <class FindPlace>
void CreaseBlend::blend(std::span<const int> rows, size_t count, const FindPlace &find_place, CenterResults &results,
                        const Part &whole) const {
  EvaluateParams params{};
  params.radius = static_cast<float>(radius_);
  std::vector<size_t> of_shape, of_values; // indices in `rows`
  for (size_t k = 0; k < rows.size(); ++k)
    if (is_of_solid(rows[k])) (is_of_shape(rows[k]) ? of_shape : of_values).push_back(k);
  const float *k1 = nullptr, *k2 = nullptr, *direction = nullptr;
  if (!of_shape.empty()) {
    const auto values_of = [&](int row) { return results.values[std::ranges::find(rows, row) - rows.begin()].data(); };
    const std::array<int, 3> shape = shape_rows();
    k1 = values_of(shape[0]), k2 = values_of(shape[1]), direction = values_of(shape[2]);
  }
  const auto blend_one = [&](size_t i, SolidMeasure &measure) {
    const SolidPlace place = find_place(i);
    if (!measure.is_near_crease(place.position, place.triangle)) return;
    Kernel kernel{params};
    Kernel::Sums sums;
    kernel.sums_init(sums, {}, {place.normal.x, place.normal.y, place.normal.z}, 0.0f);
    const auto exact = [](const Kernel::vec3 &v) { return dvec3(v.x, v.y, v.z); };
    const SolidTensor tensor = measure.at(
        {place.position, exact(sums.center.normal), exact(sums.center.t1), exact(sums.center.t2), place.triangle, place.point});
    if (!(tensor.weight > 0)) return;
    const auto share = static_cast<float>(tensor.weight);
    const Kernel::vec3 of_solid{static_cast<float>(tensor.xx), static_cast<float>(tensor.xy), static_cast<float>(tensor.yy)};
    const Solid solid = solid_of(kernel, sums, of_solid);
    for (const size_t k : of_values) {
      float &value = results.values[k][i];
      value = mixed(value, rows_of_solid[rows[k]](solid)[0], share);
    }
    if (of_shape.empty()) return;
    const bool is_known = share < 1.0f && !std::isnan(k1[i]);
    if (!is_known && share <= 0.5f) return;
    const Kernel::vec3 smooth = is_known ? shape_of(k1[i], k2[i], direction + 3 * i, sums.center) : of_solid;
    const Solid blended = solid_of(kernel, sums, smooth + share * (of_solid - smooth));
    for (const size_t k : of_shape) {
      const auto components = static_cast<size_t>(descriptor_row(rows[k]).components);
      std::copy_n(rows_of_solid[rows[k]](blended).begin(), components, &results.values[k][i * components]);
    }
  };
  std::atomic<size_t> done{0};
  std::optional<CancelScope> cancel;
  if (whole)
    cancel.emplace([&] {
      whole(share_before + (1 - share_before) * static_cast<double>(done) / static_cast<double>(std::max<size_t>(count, 1)));
    });
  Pool<SolidMeasure> measures;
  parallel_blocks(static_cast<int>(count), threads_, 64, [&](int begin, int end) {
    measures.with_one([&] { return SolidMeasure(*solid_); },
                      [&](SolidMeasure &measure) {
                        for (int i = begin; i < end; ++i) {
                          checkpoint(); // one place alone may take a millisecond
                          blend_one(static_cast<size_t>(i), measure);
                        }
                      });
    done += static_cast<size_t>(end - begin);
  });
}

void CreaseBlend::at_points(std::span<const int> rows, CenterResults &results, const Part &whole) const {
  if (!changes(rows)) return;
  const Normals &normals = surface_.normals();
  const auto find_place = [&](size_t i) {
    const auto point = static_cast<int32_t>(i);
    return SolidPlace{dvec3(surface_.triangles.positions[surface_.half_edges.point_vertex[point]]), normals.point[point],
                      surface_.half_edges.point_half_edge[point] / 3, point};
  };
  blend(rows, results.boundary.size(), find_place, results, whole);
}

void CreaseBlend::at_texels(std::span<const int> rows, const TexelMap &texels, size_t first, CenterResults &results,
                            const Part &whole) const {
  if (!changes(rows)) return;
  const Normals &normals = surface_.normals();
  const auto find_place = [&](size_t i) {
    const TexelCenter &center = texels.centers[first + i];
    constexpr double inside = 1e-4; // a place on an edge would be in neither of two triangles
    const dvec3 given(1.0 - static_cast<double>(center.weights.x) - static_cast<double>(center.weights.y), center.weights.x,
                      center.weights.y);
    const dvec3 kept = glm::max(given, inside), weights = kept / (kept.x + kept.y + kept.z);
    dvec3 position(0.0);
    vec3 normal(0.0f);
    for (int k = 0; k < 3; ++k) {
      position += weights[k] * dvec3(surface_.triangles.position(3 * center.triangle + k));
      normal += static_cast<float>(weights[k]) * normals.corner(static_cast<size_t>(3 * center.triangle + k));
    }
    const float size = length(normal);
    return SolidPlace{position, size > 0.0f ? normal / size : vec3(0.0f, 0.0f, 1.0f), center.triangle, -1};
  };
  blend(rows, results.boundary.size(), find_place, results, whole);
}

} // namespace paradesc
