// Large triangles are halved at their longest edges until the pieces are small.
#include "engine/cpu/surface_samples.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "support/parallel.h"

namespace paradesc {

namespace {

// Part of a triangle.
struct Piece {
  vec3 corner[3];
  vec2 weights[3]; // of the triangle's corners 1 and 2, at each
  float area;
};

// Pieces are halved at their longest edge: then they are hardly longer than wide.
class Divider {
public:
  Divider(const SurfelSource &source, const Surfels &surfels, int32_t triangle, vec3 face, vec3 middle, float limit,
          Samples &samples)
      : face_(face), middle_(middle), limit_(limit), largest_spread_(surfels.largest_spread), samples_(samples) {
    for (int k = 0; k < 3; ++k) {
      const int32_t corner = 3 * triangle + k;
      normal_[k] = source.normals.corner(static_cast<size_t>(corner));
      map_[k] = source.map ? (*source.map)[source.half_edges.corner_point[corner]] : vec4(0.0f);
    }
  }

  void divide(const Piece &piece) {
    const auto &p = piece.corner;
    const float edges[3] = {square(p[1] - p[0]), square(p[2] - p[1]), square(p[0] - p[2])};
    const float spread = (edges[0] + edges[1] + edges[2]) * (1.0f / 36.0f);
    const vec3 middle = (p[0] + p[1] + p[2]) * (1.0f / 3.0f);
    if (!(spread > largest_spread_)) return add(piece, middle);
    const float beyond = limit_ + 3.5f * std::sqrt(spread); // no corner is farther from the middle
    if (square(middle - middle_) > beyond * beyond) return;
    const int longest = edges[0] >= edges[1] && edges[0] >= edges[2] ? 0 : edges[1] >= edges[2] ? 1 : 2;
    const int from = longest, to = (longest + 1) % 3;
    Piece half = piece;
    half.area *= 0.5f;
    half.corner[to] = 0.5f * (p[from] + p[to]);
    half.weights[to] = 0.5f * (piece.weights[from] + piece.weights[to]);
    divide(half);
    half.corner[from] = half.corner[to];
    half.weights[from] = half.weights[to];
    half.corner[to] = p[to];
    half.weights[to] = piece.weights[to];
    divide(half);
  }

private:
  static float square(vec3 v) { return dot(v, v); }

  void add(const Piece &piece, vec3 middle) {
    const vec2 weights = (piece.weights[0] + piece.weights[1] + piece.weights[2]) * (1.0f / 3.0f);
    const auto mean = [&](const auto &of) { return of[0] + (of[1] - of[0]) * weights.x + (of[2] - of[0]) * weights.y; };
    const vec3 normal = mean(normal_);
    const float size = length(normal);
    samples_.add({middle, size > 0.0f ? normal / size : normal_[0], face_, piece.area, mean(map_)});
  }

  vec3 face_, middle_;
  float limit_, largest_spread_;
  Samples &samples_;
  vec3 normal_[3];
  vec4 map_[3];
};

} // namespace

void divide_triangle(const SurfelSource &source, const Surfels &surfels, int32_t index, vec3 middle, float limit,
                     Samples &samples) {
  const Surfel &surfel = surfels.surfel[index];
  const int32_t triangle = source.tree.triangle[surfels.first[index]];
  const auto corner = [&](int k) { return source.position(3 * triangle + k); };
  Divider(source, surfels, triangle, surfel.face, middle, limit, samples)
      .divide({{corner(0), corner(1), corner(2)}, {{0.0f, 0.0f}, {1.0f, 0.0f}, {0.0f, 1.0f}}, surfel.area});
}

static void add_surfel(const SurfelSource &source, const Surfels &surfels, int32_t index, Samples &samples) {
  const Surfel &surfel = surfels.surfel[index];
  if (!(surfel.area > 0.0f) || surfel.samples > max_stored_samples) return;
  if (surfel.samples > 1.0f)
    divide_triangle(source, surfels, index, vec3(0.0f), std::numeric_limits<float>::max(), samples);
  else
    samples.add(
        {surfel.position, surfel.normal, surfel.face, surfel.area, surfels.map.empty() ? vec4(0.0f) : surfels.map[index]});
}

SurfaceSamples list_samples(const SurfelSource &source, const Surfels &surfels) {
  constexpr int surfels_of_part = 4096;
  const auto count = static_cast<int>(surfels.surfel.size());
  const bool with_map = source.map != nullptr;
  std::vector<Samples> parts(static_cast<size_t>((count + surfels_of_part - 1) / surfels_of_part));
  SurfaceSamples result;
  result.first.resize(static_cast<size_t>(count) + 1);
  parallel_blocks(count, source.threads, surfels_of_part, [&](int begin, int end) {
    Samples &part = parts[begin / surfels_of_part];
    part.clear(with_map);
    for (int k = begin; k < end; ++k) {
      add_surfel(source, surfels, k, part);
      result.first[k + 1] = part.count();
    }
  });
  std::vector<int32_t> offsets{0};
  for (const Samples &part : parts) offsets.push_back(offsets.back() + part.count());
  for (int k = 0; k < count; ++k) result.first[k + 1] += offsets[k / surfels_of_part];
  result.samples.clear(with_map);
  for (Samples &part : parts) {
    result.samples.append(part, 0, part.count());
    part = Samples();
  }
  result.samples.fill_block();
  result.block_sphere.resize(static_cast<size_t>(result.samples.blocks()));
  parallel_blocks(result.samples.blocks(), source.threads, 1024, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) result.block_sphere[k] = result.samples.sphere(k);
  });
  return result;
}

} // namespace paradesc
