// The caller's arrays → our own triangle list, or one sentence that names the first index or coordinate that cannot be used.
#include "mesh/triangles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <sstream>
#include <string>

#include "support/cancel.h"
#include "support/error.h"

namespace paradesc {
namespace {

constexpr float largest_coordinate = 1e18f; // squares of differences stay finite in single precision
constexpr int32_t max_triangles = std::numeric_limits<int32_t>::max() / 3; // corners are counted in int32_t
constexpr std::array<char, 3> axis = {'x', 'y', 'z'};
constexpr std::array<char, 2> uv_axis = {'u', 'v'};

size_t at(int32_t index) { return static_cast<size_t>(index); }

template <class... Parts> [[noreturn]] void refuse(const Parts &...parts) {
  std::ostringstream sentence;
  (sentence << ... << parts);
  throw Error(PDESC_ERROR_INVALID_ARGUMENT, sentence.str());
}

void check_counts(const pdesc_mesh_input &input) {
  if (input.triangle_count < 0) refuse("The triangle count is ", input.triangle_count, "; give a positive count.");
  if (input.triangle_count == 0) refuse("The mesh has no faces; give at least one triangle.");
  if (input.triangle_count > max_triangles)
    refuse("The mesh has ", input.triangle_count, " triangles; at most ", max_triangles, " can be counted.");
  if (input.vertex_count <= 0) refuse("The vertex count is ", input.vertex_count, "; give a positive count.");
  if (input.corner_count <= 0) refuse("The corner count is ", input.corner_count, "; give a positive count.");
  if (input.sharp_edge_count < 0) refuse("The sharp edge count is ", input.sharp_edge_count, "; give zero or more.");
}

void check_pointers(const pdesc_mesh_input &input) {
  if (!input.positions) refuse("positions is NULL; give three floats for each of ", input.vertex_count, " vertices.");
  if (!input.corner_vertices) refuse("corner_vertices is NULL; give a vertex for each of ", input.corner_count, " corners.");
  if (!input.triangle_corners)
    refuse("triangle_corners is NULL; give three corners for each of ", input.triangle_count, " triangles.");
  if (input.sharp_edge_count > 0 && !input.sharp_edges)
    refuse("sharp_edges is NULL but sharp_edge_count is ", input.sharp_edge_count, "; give the vertex pairs or a count of zero.");
}

void check_indices(const pdesc_mesh_input &input) {
  for (int32_t corner = 0; corner < input.corner_count; ++corner) {
    checkpoint_at(at(corner));
    const int32_t vertex = input.corner_vertices[corner];
    if (vertex < 0 || vertex >= input.vertex_count)
      refuse("Corner ", corner, " refers to vertex ", vertex, "; give an index from 0 to ", input.vertex_count - 1, ".");
  }
  for (int32_t i = 0; i < 3 * input.triangle_count; ++i) {
    checkpoint_at(at(i));
    const int32_t corner = input.triangle_corners[i];
    if (corner < 0 || corner >= input.corner_count)
      refuse("Triangle ", i / 3, " refers to corner ", corner, "; give an index from 0 to ", input.corner_count - 1, ".");
  }
  for (int64_t i = 0; i < int64_t{2} * input.sharp_edge_count; ++i) {
    const int32_t vertex = input.sharp_edges[i];
    if (vertex < 0 || vertex >= input.vertex_count)
      refuse("Sharp edge ", i / 2, " refers to vertex ", vertex, "; give an index from 0 to ", input.vertex_count - 1, ".");
  }
}

void check_positions(const float *positions, int32_t vertex_count) {
  const auto count = 3 * at(vertex_count);
  bool usable = true;
  for (size_t i = 0; i < count; ++i) usable &= std::abs(positions[i]) <= largest_coordinate; // vectorized
  if (usable) return;
  for (int64_t i = 0; i < int64_t{3} * vertex_count; ++i) {
    const float value = positions[i];
    if (std::abs(value) <= largest_coordinate) continue; // false for NaN
    const auto name = axis[i % 3];
    if (!std::isfinite(value)) refuse("The ", name, " of vertex ", i / 3, " is ", value, "; give finite positions.");
    refuse("The ", name, " of vertex ", i / 3, " is ", value, "; scale the mesh so that no coordinate exceeds ",
           largest_coordinate, ".");
  }
}

void check_corner_values(const pdesc_mesh_input &input) {
  for (int64_t i = 0; input.corner_uvs && i < int64_t{2} * input.corner_count; ++i) {
    if (std::isfinite(input.corner_uvs[i])) continue;
    refuse("The ", uv_axis[i % 2], " of corner ", i / 2, " is ", input.corner_uvs[i], "; give finite UV coordinates.");
  }
  for (int64_t i = 0; input.corner_normals && i < int64_t{3} * input.corner_count; ++i) {
    if (std::isfinite(input.corner_normals[i])) continue;
    refuse("The ", axis[i % 3], " of the normal of corner ", i / 3, " is ", input.corner_normals[i],
           "; give finite normals, or none.");
  }
}

std::vector<vec3> copy_positions(const float *positions, int32_t vertex_count) {
  static_assert(sizeof(vec3) == 3 * sizeof(float));
  std::vector<vec3> result(at(vertex_count));
  std::memcpy(result.data(), positions, result.size() * sizeof(vec3));
  return result;
}

void copy_corners(const pdesc_mesh_input &input, Triangles &triangles) {
  const size_t count = 3 * at(input.triangle_count);
  triangles.corner_vertex.resize(count);
  triangles.corner_count = input.corner_count;
  checkpoint();
  triangles.input_corner.assign(input.triangle_corners, input.triangle_corners + count);
  checkpoint();
  std::vector<vec2> uvs(input.corner_uvs ? count : 0);
  if (input.corner_normals) triangles.corner_normal.resize(count);
  for (size_t i = 0; i < count; ++i) {
    checkpoint_at(i);
    const size_t corner = at(input.triangle_corners[i]);
    triangles.corner_vertex[i] = input.corner_vertices[corner];
    if (const float *uv = input.corner_uvs) uvs[i] = {uv[2 * corner], uv[2 * corner + 1]};
    if (const float *n = input.corner_normals) triangles.corner_normal[i] = {n[3 * corner], n[3 * corner + 1], n[3 * corner + 2]};
  }
  triangles.input_uv = std::move(uvs);
}

// One scale for both axes keeps the layout's aspect. A layout that fits is moved as little as possible and never enlarged.
void map_uvs_into_unit_square(Triangles &triangles) {
  triangles.corner_uv = triangles.input_uv;
  if (triangles.input_uv.empty()) return;
  checkpoint();
  Bounds<dvec2> bounds;
  for (const vec2 &uv : triangles.input_uv) bounds.add(dvec2(uv));
  const auto &[lowest, highest] = bounds;
  triangles.uv_remapped = lowest.x < 0 || lowest.y < 0 || highest.x > 1 || highest.y > 1;
  if (!triangles.uv_remapped) return;
  checkpoint();
  const double scale = 1.0 / std::max({1.0, highest.x - lowest.x, highest.y - lowest.y});
  // Subtracts the lowest corner first, so that a layout far from the origin keeps its digits.
  const dvec2 origin = glm::clamp(lowest * scale, dvec2(0), glm::max(dvec2(0), 1.0 - (highest - lowest) * scale));
  std::vector<vec2> inside = triangles.input_uv.copy();
  for (vec2 &uv : inside) uv = glm::clamp(vec2(origin + (dvec2(uv) - lowest) * scale), 0.0f, 1.0f);
  triangles.corner_uv = std::move(inside);
}

uint64_t edge_key(int32_t a, int32_t b) {
  return static_cast<uint64_t>(std::min(a, b)) << 32 | static_cast<uint64_t>(std::max(a, b));
}

void mark_sharp(const pdesc_mesh_input &input, Triangles &triangles) {
  triangles.half_edge_sharp.assign(triangles.corner_vertex.size(), 0);
  if (input.sharp_edge_count == 0) return;
  std::vector<uint64_t> sharp(at(input.sharp_edge_count));
  for (size_t i = 0; i < sharp.size(); ++i) sharp[i] = edge_key(input.sharp_edges[2 * i], input.sharp_edges[2 * i + 1]);
  std::sort(sharp.begin(), sharp.end());
  for (int corner = 0; corner < 3 * triangles.triangle_count; ++corner) {
    checkpoint_at(at(corner));
    if (input.triangle_smooth && !input.triangle_smooth[corner / 3]) continue;
    const uint64_t key = edge_key(triangles.corner_vertex[corner], triangles.corner_vertex[next_corner(corner)]);
    triangles.half_edge_sharp[corner] = std::binary_search(sharp.begin(), sharp.end(), key);
  }
}

} // namespace

Triangles read_triangles(const pdesc_mesh_input &input) {
  check_counts(input);
  check_pointers(input);
  check_indices(input);
  check_positions(input.positions, input.vertex_count);
  checkpoint();
  check_corner_values(input);
  checkpoint();

  Triangles triangles;
  triangles.vertex_count = input.vertex_count;
  triangles.triangle_count = input.triangle_count;
  triangles.positions = copy_positions(input.positions, input.vertex_count);
  checkpoint();
  copy_corners(input, triangles);
  map_uvs_into_unit_square(triangles);
  mark_sharp(input, triangles);
  return triangles;
}

void set_positions(Triangles &triangles, const float *positions, int32_t vertex_count) {
  if (vertex_count != triangles.vertex_count)
    refuse("Positions of ", vertex_count, " vertices were given; the mesh has ", triangles.vertex_count, ".");
  if (!positions) refuse("positions is NULL; give three floats for each of ", vertex_count, " vertices.");
  check_positions(positions, vertex_count);
  triangles.positions = copy_positions(positions, vertex_count);
}

} // namespace paradesc
