// Places of a division → displaced places, for each fan by itself → points and their normals.
#include "bake/refined_surface.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string>

#include "support/error.h"
#include "support/parallel.h"

namespace paradesc {

static constexpr float pixels_of_piece = 1.0f;
static constexpr double radii_of_piece = 1.0 / 8.0;
static constexpr int block = 256; // of triangles

ivec2 largest_image(const SurfaceMaps &maps) {
  ivec2 pixels(0);
  if (maps.displacement) pixels = {maps.displacement->heights.width, maps.displacement->heights.height};
  if (maps.normal_map) pixels = glm::max(pixels, ivec2(maps.normal_map->colors.width, maps.normal_map->colors.height));
  return pixels;
}

MeasureTriangle measure_of_maps(const SurfaceMaps &maps, const Triangles &triangles, double radius) {
  const vec2 in_image = vec2(largest_image(maps)) / pixels_of_piece;
  const auto in_space = static_cast<float>(1.0 / (radii_of_piece * radius));
  return [&triangles, in_image, in_space](int32_t triangle) {
    const auto c = 3 * static_cast<size_t>(triangle);
    const auto uv = [&](size_t k) { return triangles.input_uv[c + k] * in_image; };
    const auto position = [&](size_t k) { return triangles.positions[triangles.corner_vertex[c + k]] * in_space; };
    return TriangleMeasure{uv(1) - uv(0), uv(2) - uv(0), position(1) - position(0), position(2) - position(0)};
  };
}

namespace {

// Positions and normals of fans as each triangle displaces them.
struct MovedFans {
  std::vector<vec3> normal;   // (fans)
  std::vector<vec3> position; // (fans) buffer units; not set at corners of triangles
};

} // namespace

static MovedFans displace_fans(const DisplacedSurface &surface, const HalfEdges &half_edges, const Division &division,
                               int threads) {
  const DivisionPlan &plan = division.plan;
  const size_t fans = division.fan_weights.size();
  MovedFans result{std::vector<vec3>(fans, vec3(0.0f)), std::vector<vec3>(fans)};
  const auto displace = [&](int32_t triangle, size_t first, size_t count) {
    for (size_t fan = first; fan < first + count; ++fan) {
      const SurfacePoint point = surface.at(triangle, division.fan_weights[fan].x, division.fan_weights[fan].y);
      result.normal[fan] = point.normal;
      result.position[fan] = point.position;
    }
    checkpoint();
  };
  parallel_blocks(static_cast<int>(plan.halvings.size() / 3), threads, block, [&](int begin, int end) {
    for (int32_t triangle = begin; triangle < end; ++triangle) {
      const auto h = 3 * static_cast<size_t>(triangle);
      if (half_edges.corner_point[h] < 0) continue;
      displace(triangle, h, 3);
      const auto sides = static_cast<size_t>(plan.side_begin[h]), inner = static_cast<size_t>(plan.inner_begin[triangle]);
      displace(triangle, division.first_side_fan() + sides, static_cast<size_t>(plan.side_begin[h + 3]) - sides);
      displace(triangle, division.first_inner_fan() + inner, static_cast<size_t>(plan.inner_begin[triangle + 1]) - inner);
    }
  });
  return result;
}

namespace {

// Points of the surface under construction.
struct Points {
  std::vector<vec3> position; // buffer units
  std::vector<vec3> normal;
};

} // namespace

// Places points on an edge: the mean of its two triangles, each of which has half of the angle around the point.
static void place_points_of_edges(const HalfEdges &half_edges, const Division &division, const MovedFans &fans, Points &points) {
  const DivisionPlan &plan = division.plan;
  for (int32_t h = 0; h < static_cast<int32_t>(plan.halvings.size()); ++h) {
    checkpoint_at(h);
    const int32_t twin = half_edges.twin[h], count = plan.edge_begin[h + 1] - plan.edge_begin[h];
    for (int32_t k = 0; k < count; ++k) {
      const auto point = static_cast<size_t>(half_edges.point_count + plan.edge_begin[h] + k);
      const size_t fan = division.first_side_fan() + static_cast<size_t>(plan.side_begin[h] + k);
      points.position[point] = fans.position[fan];
      points.normal[point] = fans.normal[fan];
      if (twin < 0) continue;
      const size_t other = division.first_side_fan() + static_cast<size_t>(plan.side_begin[twin] + count - 1 - k);
      points.position[point] = 0.5f * (fans.position[fan] + fans.position[other]);
      points.normal[point] = unit_or(fans.normal[fan] + fans.normal[other], fans.normal[fan]);
    }
  }
}

static void check_bounds(const std::vector<vec3> &positions, const std::vector<vec3> &normals) {
  constexpr float largest = 1e18f;      // limit of input positions
  const auto lies_within = [](vec3 v) { // false for NaN
    return std::abs(v.x) <= largest && std::abs(v.y) <= largest && std::abs(v.z) <= largest;
  };
  const auto is_unit = [](vec3 v) { return std::abs(dot(v, v) - 1.0f) < 0.01f || v == vec3(0.0f); };
  if (!std::ranges::all_of(positions, lies_within))
    throw Error(PDESC_ERROR_INVALID_OPERATION,
                "The displacement moves the surface to where no descriptor can be computed, beyond "
                "1e18 or to no number at all; use a smaller scale.");
  if (!std::ranges::all_of(normals, is_unit))
    throw Error(PDESC_ERROR_INVALID_OPERATION,
                "The surface maps give normals that are no numbers, since squares of their slopes or "
                "colors are more than a float holds; use smaller values.");
}

RefinedSurface refine_surface(const SurfaceMaps &maps, const Triangles &triangles, const HalfEdges &half_edges,
                              const Normals &normals, const BakeSpace &bake_space, const Division &division, int threads) {
  MovedFans fans = displace_fans(DisplacedSurface(maps, triangles, normals, bake_space), half_edges, division, threads);
  Points points;
  {
    DisplacedPoints of_mesh = displace_points(maps, triangles, half_edges, normals, bake_space, threads);
    points = {std::move(of_mesh.position), std::move(of_mesh.normal)};
  }
  const auto count = static_cast<size_t>(division.half_edges.point_count);
  const auto first_inner = count - static_cast<size_t>(division.plan.inner_begin.back());
  points.position.resize(count);
  points.normal.resize(count);
  checkpoint();
  place_points_of_edges(half_edges, division, fans, points);
  const auto inner = static_cast<ptrdiff_t>(division.first_inner_fan());
  std::copy(fans.position.begin() + inner, fans.position.end(), points.position.begin() + static_cast<ptrdiff_t>(first_inner));
  std::copy(fans.normal.begin() + inner, fans.normal.end(), points.normal.begin() + static_cast<ptrdiff_t>(first_inner));
  fans.position = {};
  for (size_t i = 0; i < count; ++i) {
    checkpoint_at(i);
    points.position[i] = vec3(dvec3(points.position[i]) / bake_space.scale + bake_space.center);
  }
  check_bounds(points.position, fans.normal);
  checkpoint();
  RefinedSurface refined;
  refined.triangles.vertex_count = division.half_edges.point_count;
  refined.triangles.triangle_count = division.plan.pieces();
  refined.triangles.positions = std::move(points.position);
  refined.triangles.corner_vertex = division.half_edges.corner_point;
  refined.normals.group = std::move(fans.normal);
  refined.normals.corner_fan = division.corner_fan;
  refined.normals.point = std::move(points.normal);
  refined.box = bounding_box(refined.triangles, division.half_edges, threads);
  return refined;
}

} // namespace paradesc
