// Samples triangles at barycentric coordinates, by pieces that are small against the radius.
#include "sample/texelless.h"

#include <algorithm>
#include <cmath>

namespace paradesc {

// Divides triangles until pieces are small against the radius; the centroid of each piece is a sample.
TexellessSamples sample_texelless_triangles(const Cells &cells, const Triangles &triangles,
                                            const std::function<vec3(size_t corner)> &normal_of, const BakeSpace &bake_space,
                                            float radius, const DisplacedSurface *displaced) {
  TexellessSamples samples;
  samples.begin.push_back(0);
  for (size_t cell = 0; cell + 1 < cells.texelless_begin.size(); ++cell) {
    for (int32_t k = cells.texelless_begin[cell]; k < cells.texelless_begin[cell + 1]; ++k) {
      const auto corner = 3 * static_cast<size_t>(cells.texelless[k]);
      vec3 p[3], normal[3];
      for (size_t i = 0; i < 3; ++i) {
        p[i] = bake_space.to_buffer(triangles.positions[triangles.corner_vertex[corner + i]]);
        normal[i] = normal_of(corner + i);
      }
      const float longest = std::max({length(p[1] - p[0]), length(p[2] - p[1]), length(p[0] - p[2])});
      // Clamped before the conversion to an integer, because radii may be as small as floats are.
      const int side = static_cast<int>(std::fmax(1.0f, std::fmin(std::ceil(4.0f * longest / radius), 16.0f)));
      const float area = 0.5f * length(cross(p[1] - p[0], p[2] - p[0])) / static_cast<float>(side * side);
      auto add = [&](float a, float b) { // barycentric coordinates of corners 1 and 2
        if (displaced) {
          const SurfacePoint point = displaced->at(static_cast<int>(corner / 3), a, b);
          samples.samples.push_back({point.position, area * point.area_ratio, point.normal, 0});
          return;
        }
        const vec3 n = normal[0] * (1.0f - a - b) + normal[1] * a + normal[2] * b;
        const float span = length(n);
        samples.samples.push_back({p[0] + (p[1] - p[0]) * a + (p[2] - p[0]) * b, area, span > 0.0f ? n / span : normal[0],
                                   static_cast<int32_t>(corner / 3)});
        samples.weights.emplace_back(a, b);
      };
      for (int i = 0; i < side; ++i)
        for (int j = 0; i + j < side; ++j) {
          const auto step = 1.0f / static_cast<float>(side);
          add((static_cast<float>(i) + 1.0f / 3.0f) * step, (static_cast<float>(j) + 1.0f / 3.0f) * step);
          if (i + j + 1 < side) add((static_cast<float>(i) + 2.0f / 3.0f) * step, (static_cast<float>(j) + 2.0f / 3.0f) * step);
        }
    }
    samples.begin.push_back(static_cast<int32_t>(samples.samples.size()));
  }
  return samples;
}

} // namespace paradesc
