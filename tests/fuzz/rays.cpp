// Rays through the C interface: what they meet is a place on a triangle, or nothing.
#include "rays.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "claims.h"
#include "paradesc/paradesc.h"
#include "passed.h"

namespace paradesc::fuzz {
namespace {

constexpr int32_t untouched = -77;

void check_places(const std::vector<int32_t> &triangles, const std::vector<float> &weights, int32_t count) {
  for (size_t ray = 0; ray < triangles.size(); ++ray) {
    claim(triangles[ray] >= -1 && triangles[ray] < count, "a ray met a triangle that there is not");
    float sum = 0;
    for (size_t corner = 0; corner < 3; ++corner) {
      const float weight = weights[3 * ray + corner];
      claim(weight >= 0 && weight <= 1, "a place lies beside its triangle");
      sum += weight;
    }
    claim(std::abs(sum - (triangles[ray] < 0 ? 0.0f : 1.0f)) < 1e-5f, "the weights of a place are no shares");
  }
}

} // namespace

void cast_rays(Bytes &bytes) {
  const int32_t vertices = 1 + bytes.below(12), triangles = bytes.below(10), rays = 1 + bytes.below(10);
  const int32_t components = bytes.one_in(3) ? 3 : 1;
  std::vector<float> positions(3 * vertices), lines(6 * rays), values(components * vertices), weights(3 * rays, sentinel);
  std::vector<int32_t> corners(3 * triangles), met(rays, untouched);
  for (std::vector<float> *numbers : {&positions, &lines, &values})
    for (float &x : *numbers) x = bytes.number();
  for (int32_t &corner : corners) corner = bytes.one_in(64) ? bytes.whole() : bytes.below(vertices);
  pdesc_rays_input ours;
  pdesc_rays_input_init(&ours);
  ours.vertex_count = bytes.one_in(32) ? std::min(vertices, bytes.whole()) : vertices;
  ours.triangle_count = bytes.one_in(32) ? std::min(triangles, bytes.whole()) : triangles;
  ours.ray_count = bytes.one_in(32) ? std::min(rays, bytes.whole()) : rays;
  ours.threads = bytes.one_in(32) ? std::min(3, bytes.whole()) : 1;
  ours.positions = bytes.one_in(32) ? nullptr : positions.data();
  ours.triangle_vertices = bytes.one_in(32) ? nullptr : corners.data();
  ours.rays = bytes.one_in(32) ? nullptr : lines.data();
  ours.reach = bytes.one_in(4) ? static_cast<double>(bytes.number()) : 2.0;
  if (bytes.one_in(8)) ours.progress = [](void *, const char *, double) -> int32_t { return 0; };
  Passed<pdesc_rays_input> passed(bytes, ours);
  if (!done(pdesc_rays_cast(passed.get(), met.data(), weights.data(), rays))) {
    claim(std::count(met.begin(), met.end(), untouched) == rays, "triangles were touched on failure");
    claim(std::count(weights.begin(), weights.end(), sentinel) == 3 * rays, "weights were touched on failure");
    return;
  }
  check_places(met, weights, passed.read().triangle_count);
  if (bytes.one_in(16)) met[0] = bytes.whole();
  std::vector<float> found(components * rays, sentinel);
  const bool given = done(
      pdesc_rays_values(passed.get(), met.data(), weights.data(), values.data(), components, found.data(), components * rays));
  if (!given) claim(std::count(found.begin(), found.end(), sentinel) == components * rays, "values were touched on failure");
}

} // namespace paradesc::fuzz
