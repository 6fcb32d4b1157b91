// The part of the C edge that looks at one surface from another; it needs no handle.
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "api_edge.h"
#include "gather/rays.h"
#include "support/shown.h"

namespace {

using namespace paradesc::edge;

void check_index(const std::string &what, int64_t index, int64_t low, int64_t count) {
  if (index < low || index >= count)
    refuse(what + " refers to " + std::to_string(index) + ", but there are " + std::to_string(count) + ".");
}

void check_surface(const pdesc_rays_input &input) {
  check_range("vertex_count", input.vertex_count, 0, INT32_MAX);
  check_range("triangle_count", input.triangle_count, 0, INT32_MAX);
  check_range("ray_count", input.ray_count, 0, INT32_MAX);
  check_range("threads", input.threads, 0, 4096);
  if (input.triangle_count == 0) return;
  need(input.triangle_vertices, "triangle_vertices");
  for (int64_t i = 0; i < int64_t{3} * input.triangle_count; ++i)
    if (input.triangle_vertices[i] < 0 || input.triangle_vertices[i] >= input.vertex_count)
      check_index("Corner " + std::to_string(i % 3) + " of triangle " + std::to_string(i / 3), input.triangle_vertices[i], 0,
                  input.vertex_count);
}

void check_rays(const pdesc_rays_input &input) {
  check_surface(input);
  if (input.triangle_count > 0) need(input.positions, "positions");
  if (input.ray_count > 0) need(input.rays, "rays");
  if (!(input.reach > 0) || !std::isfinite(input.reach))
    refuse("The reach is " + paradesc::shown(input.reach) + "; it must be a number above 0.");
}

void check_count(int64_t room, int64_t needed) {
  if (room != needed)
    refuse("The array has room for " + std::to_string(room) + ", but there are " + std::to_string(needed) + ".");
}

} // namespace

void pdesc_rays_input_init(pdesc_rays_input *input) { zero_init(input); }

int32_t pdesc_rays_cast(const pdesc_rays_input *input, int32_t *triangles, float *weights, int32_t ray_count) {
  return guarded([&] {
    need(input, "input");
    need(triangles, "triangles");
    need(weights, "weights");
    const auto ours = read_struct(input, pdesc_rays_input_init, "pdesc_rays_input");
    check_rays(ours);
    check_count(ray_count, ours.ray_count);
    const auto count = static_cast<size_t>(ray_count);
    std::vector<int32_t> met(count); // keeps outputs untouched on failure
    std::vector<float> shares(3 * count);
    paradesc::cast_rays(ours, met, shares);
    std::copy(met.begin(), met.end(), triangles);
    std::copy(shares.begin(), shares.end(), weights);
  });
}

int32_t pdesc_rays_values(const pdesc_rays_input *input, const int32_t *triangles, const float *weights, const float *values,
                          int32_t components, float *met, int64_t count) {
  return guarded([&] {
    need(input, "input");
    need(triangles, "triangles");
    need(weights, "weights");
    need(met, "met");
    const auto ours = read_struct(input, pdesc_rays_input_init, "pdesc_rays_input");
    check_surface(ours);
    if (components != 1 && components != 3)
      refuse("The option components is " + std::to_string(components) + "; it must be 1, or 3 for directions.");
    check_count(count, int64_t{ours.ray_count} * components);
    if (ours.vertex_count > 0) need(values, "values");
    for (int32_t ray = 0; ray < ours.ray_count; ++ray)
      if (triangles[ray] < -1 || triangles[ray] >= ours.triangle_count)
        check_index("Ray " + std::to_string(ray), triangles[ray], -1, ours.triangle_count);
    paradesc::values_met(ours, triangles, weights, values, components, met);
  });
}
