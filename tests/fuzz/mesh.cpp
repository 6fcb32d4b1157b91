// Surfaces of a few dozen triangles, then edits. Nothing here is random: the bytes say all.
#include "mesh.h"

#include <cmath>
#include <cstddef>
#include <numbers>

namespace paradesc::fuzz {
namespace {

void add_vertex(Arrays &arrays, float x, float y, float z) { arrays.positions.insert(arrays.positions.end(), {x, y, z}); }

int vertex_count(const Arrays &arrays) { return static_cast<int>(arrays.positions.size() / 3); }

// Three corners of its own for each triangle, with the (u, v) given.
void add_triangle(Arrays &arrays, const int32_t (&vertices)[3], const float (&uvs)[6]) {
  for (int k = 0; k < 3; ++k) {
    arrays.triangle_corners.push_back(static_cast<int32_t>(arrays.corner_vertices.size()));
    arrays.corner_vertices.push_back(vertices[k]);
    arrays.uvs.insert(arrays.uvs.end(), {uvs[2 * k], uvs[2 * k + 1]});
  }
}

// Vertices, corners and triangles that have nothing to do with each other.
void soup(Bytes &bytes, Arrays &arrays) {
  const int vertices = 1 + bytes.below(24), triangles = 1 + bytes.below(32);
  for (int i = 0; i < 3 * vertices; ++i) arrays.positions.push_back(bytes.number());
  for (int i = 0; i < triangles; ++i) {
    const int32_t corners[] = {bytes.below(vertices), bytes.below(vertices), bytes.below(vertices)};
    const float uvs[] = {bytes.number(), bytes.number(), bytes.number(), bytes.number(), bytes.number(), bytes.number()};
    add_triangle(arrays, corners, uvs);
  }
}

enum class Shape { plane, bowl, tube, ring, count };

// (s, t) in the unit square → a point; tube and ring close, so that vertices coincide along a seam.
void place(Shape shape, float s, float t, Arrays &arrays) {
  constexpr float turn = 2.0f * std::numbers::pi_v<float>;
  switch (shape) {
  case Shape::bowl:
    return add_vertex(arrays, s, t, s * s + t * t - s * t);
  case Shape::tube:
    return add_vertex(arrays, std::cos(turn * s), std::sin(turn * s), 3.0f * t);
  case Shape::ring: {
    const float r = 2.0f + std::cos(turn * t);
    return add_vertex(arrays, r * std::cos(turn * s), r * std::sin(turn * s), std::sin(turn * t));
  }
  default:
    return add_vertex(arrays, s, t, 0.0f);
  }
}

// columns × rows quads over the unit square; the UV map is that square, or has a chart for each column.
void surface(Bytes &bytes, Arrays &arrays) {
  const auto shape = static_cast<Shape>(bytes.below(static_cast<int>(Shape::count)));
  const int columns = 1 + bytes.below(3), rows = 1 + bytes.below(3);
  const bool welded = bytes.one_in(2), torn = bytes.one_in(2);
  for (int row = 0; row <= rows; ++row)
    for (int column = 0; column <= columns; ++column)
      place(shape, static_cast<float>(column) / static_cast<float>(columns), static_cast<float>(row) / static_cast<float>(rows),
            arrays);
  const auto vertex = [&](int column, int row) {
    return welded ? row % rows * (columns + 1) + column % columns : row * (columns + 1) + column;
  };
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const float w = 1.0f / static_cast<float>(columns), h = 1.0f / static_cast<float>(rows), gap = torn ? 0.1f * w : 0.0f;
      const float u = w * static_cast<float>(column) + gap, v = h * static_cast<float>(row), r = u + w - 2.0f * gap, top = v + h;
      const int32_t a = vertex(column, row), b = vertex(column + 1, row), c = vertex(column + 1, row + 1),
                    d = vertex(column, row + 1);
      add_triangle(arrays, {a, b, c}, {u, v, r, v, r, top});
      add_triangle(arrays, {a, c, d}, {u, v, r, top, u, top});
    }
}

// Three faces and more around one edge, and several fans at one vertex.
void fan(Bytes &bytes, Arrays &arrays) {
  const int blades = 1 + bytes.below(12);
  add_vertex(arrays, 0, 0, 0);
  add_vertex(arrays, 0, 0, 1);
  for (int i = 0; i < blades; ++i) {
    const float angle = static_cast<float>(i);
    add_vertex(arrays, std::cos(angle), std::sin(angle), 0.5f);
    const float u = static_cast<float>(i) / static_cast<float>(blades), w = 0.9f / static_cast<float>(blades);
    if (bytes.one_in(2))
      add_triangle(arrays, {0, 1, 2 + i}, {u, 0, u, 1, u + w, 0.5f});
    else
      add_triangle(arrays, {0, 1 + i, 2 + i}, {0.5f, 0.5f, u, 0, u + w, 1});
  }
}

template <class Value, class Draw> void edit(Bytes &bytes, std::vector<Value> &values, const Draw &draw) {
  if (values.empty()) return;
  const size_t at = (static_cast<size_t>(bytes.byte()) << 8 | bytes.byte()) % values.size();
  values[at] = draw();
}

void edit(Bytes &bytes, Arrays &arrays) {
  const int vertices = vertex_count(arrays), corners = static_cast<int>(arrays.corner_vertices.size());
  switch (bytes.below(8)) {
  case 0:
  case 1:
    return edit(bytes, arrays.positions, [&] { return bytes.number(); });
  case 2:
  case 3:
    return edit(bytes, arrays.uvs, [&] { return bytes.number(); });
  case 4:
    return edit(bytes, arrays.corner_vertices, [&] { return bytes.one_in(8) ? bytes.whole() : bytes.byte() % vertices; });
  case 5:
    return edit(bytes, arrays.triangle_corners, [&] { return bytes.one_in(8) ? bytes.whole() : bytes.byte() % corners; });
  case 6: { // all at another scale, and far away
    const float scale = bytes.number(), shift = bytes.one_in(2) ? bytes.number() : 0.0f;
    for (float &x : arrays.positions) x = x * scale + shift;
    return;
  }
  default: {
    const float scale = bytes.number(), shift = bytes.one_in(2) ? bytes.number() : 0.0f;
    for (float &x : arrays.uvs) x = x * scale + shift;
  }
  }
}

void add_optional(Bytes &bytes, Arrays &arrays) {
  const size_t corners = arrays.corner_vertices.size(), triangles = arrays.triangle_corners.size() / 3;
  if (bytes.one_in(4))
    for (size_t i = 0; i < 3 * corners; ++i) arrays.normals.push_back(bytes.number());
  if (bytes.one_in(4))
    for (size_t i = 0; i < triangles; ++i) arrays.smooth.push_back(bytes.byte());
  if (!bytes.one_in(4)) return;
  for (int i = 2 * bytes.below(16); i > 0; --i)
    arrays.sharp_edges.push_back(bytes.one_in(16) ? bytes.whole() : bytes.byte() % vertex_count(arrays));
}

// A count that is too small reads less than there is; one that is too large would be the caller's fault, so its array is not
// there.
void break_count(Bytes &bytes, pdesc_mesh_input &input) {
  const int32_t wrong = bytes.whole();
  switch (bytes.below(4)) {
  case 0:
    if (wrong > input.vertex_count) input.positions = nullptr;
    input.vertex_count = wrong;
    return;
  case 1:
    if (wrong > input.corner_count) input.corner_vertices = nullptr;
    input.corner_count = wrong;
    return;
  case 2:
    if (wrong > input.triangle_count) input.triangle_corners = nullptr;
    input.triangle_count = wrong;
    return;
  default:
    if (wrong > input.sharp_edge_count) input.sharp_edges = nullptr;
    input.sharp_edge_count = wrong;
  }
}

template <class Value> const Value *pointer(const std::vector<Value> &values) { return values.empty() ? nullptr : values.data(); }

} // namespace

std::unique_ptr<Arrays> make_arrays(Bytes &bytes) {
  auto arrays = std::make_unique<Arrays>();
  const int kind = bytes.below(8);
  kind == 0 ? soup(bytes, *arrays) : kind == 1 ? fan(bytes, *arrays) : surface(bytes, *arrays);
  for (int edits = bytes.below(8); edits > 0; --edits) edit(bytes, *arrays);
  add_optional(bytes, *arrays);
  if (bytes.one_in(16)) arrays->uvs.clear();
  for (auto *values : {&arrays->positions, &arrays->uvs, &arrays->normals}) values->shrink_to_fit();
  for (auto *values : {&arrays->corner_vertices, &arrays->triangle_corners, &arrays->sharp_edges}) values->shrink_to_fit();
  arrays->smooth.shrink_to_fit();

  pdesc_mesh_input &input = arrays->input;
  pdesc_mesh_input_init(&input);
  input.vertex_count = vertex_count(*arrays);
  input.corner_count = static_cast<int32_t>(arrays->corner_vertices.size());
  input.triangle_count = static_cast<int32_t>(arrays->triangle_corners.size() / 3);
  input.sharp_edge_count = static_cast<int32_t>(arrays->sharp_edges.size() / 2);
  input.positions = pointer(arrays->positions);
  input.corner_vertices = pointer(arrays->corner_vertices);
  input.triangle_corners = pointer(arrays->triangle_corners);
  input.corner_uvs = pointer(arrays->uvs);
  input.corner_normals = pointer(arrays->normals);
  input.triangle_smooth = pointer(arrays->smooth);
  input.sharp_edges = pointer(arrays->sharp_edges);
  if (bytes.one_in(16)) break_count(bytes, input);
  return arrays;
}

} // namespace paradesc::fuzz
