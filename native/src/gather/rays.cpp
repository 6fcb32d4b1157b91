#include "gather/rays.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>

#include "gather/blend.h"
#include "mesh/ray_tree.h"
#include "support/cancel.h"
#include "support/parallel.h"
#include "support/progress.h"

namespace paradesc {
namespace {

constexpr int rays_in_block = 1024;
constexpr int32_t none = -1;

RayHit met_by(const RayTree &tree, const float *ray, double reach) {
  const dvec3 point(ray[0], ray[1], ray[2]), direction(ray[3], ray[4], ray[5]);
  if (!std::all_of(ray, ray + 6, [](float x) { return std::isfinite(x); }) || direction == dvec3(0)) return {};
  return tree.nearest(Ray(point, direction), reach);
}

} // namespace

void cast_rays(const pdesc_rays_input &input, std::span<int32_t> triangles, std::span<float> weights) {
  std::atomic<int> done{0};
  const auto ask = [&, progress = progress_of(input.progress, input.user)] {
    check_cancel(progress, "rays", static_cast<double>(done) / std::max(input.ray_count, 1));
  };
  ask();
  const CancelScope scope(ask);
  const RayTree tree({input.positions, size_t{3} * static_cast<size_t>(input.vertex_count)},
                     {input.triangle_vertices, size_t{3} * static_cast<size_t>(input.triangle_count)}, input.threads);
  parallel_blocks(input.ray_count, input.threads, rays_in_block, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const RayHit hit = met_by(tree, input.rays + size_t{6} * static_cast<size_t>(i), input.reach);
      triangles[i] = hit.triangle;
      for (size_t corner = 0; corner < 3; ++corner)
        weights[size_t{3} * static_cast<size_t>(i) + corner] = static_cast<float>(hit.weights[corner]);
    }
    done += end - begin;
  });
}

void values_met(const pdesc_rays_input &input, const int32_t *triangles, const float *weights, const float *values,
                int components, float *met) {
  const auto width = static_cast<size_t>(components);
  parallel_blocks(input.ray_count, input.threads, rays_in_block, [&](int begin, int end) {
    for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
      float *out = met + i * width;
      if (triangles[i] == none) {
        std::fill_n(out, width, std::numeric_limits<float>::quiet_NaN());
        continue;
      }
      std::array<const float *, 3> corners;
      std::array<double, 3> shares;
      for (size_t corner = 0; corner < 3; ++corner) {
        const int32_t vertex = input.triangle_vertices[size_t{3} * static_cast<size_t>(triangles[i]) + corner];
        corners[corner] = values + static_cast<size_t>(vertex) * width;
        shares[corner] = static_cast<double>(weights[3 * i + corner]);
      }
      const Value<3> value = blended<3>(corners, shares, components, components == 3);
      for (size_t c = 0; c < width; ++c) out[c] = static_cast<float>(value[c]);
    }
  });
}

} // namespace paradesc
