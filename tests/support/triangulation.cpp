// A grid over a rectangle or over a cube's faces → jittered vertices, random diagonals, edges turned towards Delaunay.
#include "support/triangulation.h"

#include <algorithm>
#include <array>
#include <map>

namespace paradesc::test {
namespace {

constexpr double pi = 3.14159265358979323846;
constexpr int flip_rounds = 12;

// Twice the area of (a, b, c) in the parameter plane.
double area(Vec3 a, Vec3 b, Vec3 c) { return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x); }

// Counter-clockwise a b c d → two triangles. Only one diagonal of a quadrilateral that is not convex lies inside.
void add_cell(TestMesh &mesh, const std::array<int32_t, 4> &v, const std::array<Vec3, 4> &p, int32_t patch, bool other_diagonal) {
  const bool diagonal_ac = area(p[0], p[1], p[2]) > 0 && area(p[0], p[2], p[3]) > 0;
  const bool diagonal_bd = area(p[0], p[1], p[3]) > 0 && area(p[1], p[2], p[3]) > 0;
  const bool use_bd = diagonal_bd && (other_diagonal || !diagonal_ac);
  const std::array<int32_t, 6> corners = use_bd ? std::array<int32_t, 6>{v[0], v[1], v[3], v[1], v[2], v[3]}
                                                : std::array<int32_t, 6>{v[0], v[1], v[2], v[0], v[2], v[3]};
  mesh.corner_vertices.insert(mesh.corner_vertices.end(), corners.begin(), corners.end());
  mesh.triangle_patch.insert(mesh.triangle_patch.end(), 2, patch);
}

struct Apex {
  int32_t vertex;
  double angle;
};

// The corner of the triangle that is on neither end of the edge, and its angle.
Apex apex_of(const TestMesh &mesh, int32_t triangle, const MeshEdge &edge) {
  for (int i = 0; i < 3; ++i) {
    const int32_t v = mesh.corner_vertices[static_cast<size_t>(3 * triangle + i)];
    if (v == edge.low || v == edge.high) continue;
    const Vec3 to_low = mesh.points[static_cast<size_t>(edge.low)] - mesh.points[static_cast<size_t>(v)];
    const Vec3 to_high = mesh.points[static_cast<size_t>(edge.high)] - mesh.points[static_cast<size_t>(v)];
    return {v, std::atan2(length(cross(to_low, to_high)), dot(to_low, to_high))};
  }
  return {-1, 0};
}

Vec3 area_vector(const TestMesh &mesh, int32_t a, int32_t b, int32_t c) {
  const Vec3 &p = mesh.points[static_cast<size_t>(a)];
  return cross(mesh.points[static_cast<size_t>(b)] - p, mesh.points[static_cast<size_t>(c)] - p);
}

bool runs_from_to(const TestMesh &mesh, int32_t triangle, int32_t from, int32_t to) {
  for (int i = 0; i < 3; ++i)
    if (mesh.corner_vertices[static_cast<size_t>(3 * triangle + i)] == from &&
        mesh.corner_vertices[static_cast<size_t>(3 * triangle + (i + 1) % 3)] == to)
      return true;
  return false;
}

void set_triangle(TestMesh &mesh, int32_t triangle, int32_t a, int32_t b, int32_t c) {
  const size_t first = static_cast<size_t>(3 * triangle);
  mesh.corner_vertices[first] = a;
  mesh.corner_vertices[first + 1] = b;
  mesh.corner_vertices[first + 2] = c;
}

bool flip(TestMesh &mesh, const MeshEdge &edge) {
  const Apex a = apex_of(mesh, edge.triangle_a, edge), b = apex_of(mesh, edge.triangle_b, edge);
  if (a.angle + b.angle < pi + 1e-9) return false;
  const bool forward = runs_from_to(mesh, edge.triangle_a, edge.low, edge.high);
  const int32_t from = forward ? edge.low : edge.high, to = forward ? edge.high : edge.low;
  const Vec3 before = area_vector(mesh, from, to, a.vertex) + area_vector(mesh, to, from, b.vertex);
  const Vec3 first = area_vector(mesh, a.vertex, from, b.vertex), second = area_vector(mesh, b.vertex, to, a.vertex);
  if (dot(first, before) <= 0 || dot(second, before) <= 0) return false;
  set_triangle(mesh, edge.triangle_a, a.vertex, from, b.vertex);
  set_triangle(mesh, edge.triangle_b, b.vertex, to, a.vertex);
  return true;
}

} // namespace

TestMesh triangulate_rectangle(Vec3 lengths, bool periodic_u, bool periodic_v, const Triangulation &triangulation) {
  TestMesh mesh;
  mesh.lengths = lengths;
  mesh.periodic_u = periodic_u;
  mesh.periodic_v = periodic_v;
  const int nu = std::max(3, static_cast<int>(std::lround(std::sqrt(triangulation.vertices * lengths.x / lengths.y))));
  const int nv = std::max(3, static_cast<int>(std::lround(static_cast<double>(triangulation.vertices) / nu)));
  const int columns = periodic_u ? nu : nu + 1, rows = periodic_v ? nv : nv + 1;
  Random random(triangulation.seed);
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const double amount = triangulation.irregular ? triangulation.jitter : 0;
      const double du = random.uniform(-amount, amount), dv = random.uniform(-amount, amount);
      const bool fixed_u = !periodic_u && (i == 0 || i == nu), fixed_v = !periodic_v && (j == 0 || j == nv);
      mesh.parameters.push_back({(i + (fixed_u ? 0 : du)) / nu, (j + (fixed_v ? 0 : dv)) / nv, 0});
    }
  const auto vertex = [&](int i, int j) { return static_cast<int32_t>((j % rows) * columns + i % columns); };
  const auto parameter = [&](int i, int j) {
    const Vec3 p = mesh.parameters[static_cast<size_t>(vertex(i, j))];
    return Vec3{p.x + (i >= columns ? 1 : 0), p.y + (j >= rows ? 1 : 0), 0};
  };
  for (int j = 0; j < nv; ++j)
    for (int i = 0; i < nu; ++i)
      add_cell(mesh, {vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)},
               {parameter(i, j), parameter(i + 1, j), parameter(i + 1, j + 1), parameter(i, j + 1)}, 0,
               triangulation.irregular && random.uniform() < 0.5);
  return mesh;
}

TestMesh triangulate_sphere(const Triangulation &triangulation) {
  TestMesh mesh;
  mesh.domain = Domain::sphere;
  const int n = std::max(2, static_cast<int>(std::lround(std::sqrt(triangulation.vertices / 6.0))));
  Random random(triangulation.seed);
  std::map<std::array<int, 3>, int32_t> vertex_at; // lattice points of the cube [0, n]³
  std::vector<Vec3> lattice;                       // the same, jittered
  const auto vertex = [&](const std::array<int, 3> &p) {
    const auto [found, is_new] = vertex_at.try_emplace(p, static_cast<int32_t>(lattice.size()));
    if (!is_new) return found->second;
    const double amount = triangulation.irregular ? triangulation.jitter : 0;
    std::array<double, 3> q{};
    for (size_t i = 0; i < 3; ++i) {
      const double d = random.uniform(-amount, amount);
      q[i] = p[i] + (p[i] == 0 || p[i] == n ? 0 : d); // stays on its face, its edge, its corner
    }
    lattice.push_back({q[0], q[1], q[2]});
    const auto cube = [&](double x) { return x == n ? 1.0 : x == 0 ? -1.0 : std::tan(pi / 4 * (2 * x / n - 1)); };
    mesh.parameters.push_back(normalized({cube(q[0]), cube(q[1]), cube(q[2])}));
    return found->second;
  };
  for (int face = 0; face < 6; ++face) {
    const size_t axis = static_cast<size_t>(face / 2), u = (axis + 1) % 3, v = (axis + 2) % 3;
    const bool negative = face % 2 == 1;
    const auto at = [&](int i, int j) {
      std::array<int, 3> p{};
      p[axis] = negative ? 0 : n;
      p[u] = negative ? n - i : i;
      p[v] = j;
      return vertex(p);
    };
    const auto flat = [&](int32_t id) {
      const Vec3 q = lattice[static_cast<size_t>(id)];
      return Vec3{negative ? n - q[static_cast<int>(u)] : q[static_cast<int>(u)], q[static_cast<int>(v)], 0};
    };
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const std::array<int32_t, 4> c{at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)};
        add_cell(mesh, c, {flat(c[0]), flat(c[1]), flat(c[2]), flat(c[3])}, face,
                 triangulation.irregular && random.uniform() < 0.5);
      }
  }
  return mesh;
}

std::vector<MeshEdge> mesh_edges(const TestMesh &mesh) {
  std::vector<MeshEdge> edges;
  edges.reserve(mesh.corner_vertices.size());
  for (int32_t t = 0; t < mesh.triangle_count(); ++t)
    for (int i = 0; i < 3; ++i) {
      const int32_t a = mesh.corner_vertices[static_cast<size_t>(3 * t + i)];
      const int32_t b = mesh.corner_vertices[static_cast<size_t>(3 * t + (i + 1) % 3)];
      edges.push_back({std::min(a, b), std::max(a, b), t, -1});
    }
  std::sort(edges.begin(), edges.end(), [](const MeshEdge &a, const MeshEdge &b) {
    return std::array{a.low, a.high, a.triangle_a} < std::array{b.low, b.high, b.triangle_a};
  });
  size_t count = 0;
  for (const MeshEdge &edge : edges) {
    if (count > 0 && edges[count - 1].low == edge.low && edges[count - 1].high == edge.high)
      edges[count - 1].triangle_b = edge.triangle_a;
    else
      edges[count++] = edge;
  }
  edges.resize(count);
  return edges;
}

void flip_towards_delaunay(TestMesh &mesh) {
  for (int round = 0, flips = 1; round < flip_rounds && flips > 0; ++round) {
    flips = 0;
    std::vector<uint8_t> touched(mesh.triangle_patch.size(), 0); // a triangle that was changed has other edges than the list says
    for (const MeshEdge &edge : mesh_edges(mesh)) {
      if (edge.triangle_b < 0) continue;
      const size_t a = static_cast<size_t>(edge.triangle_a), b = static_cast<size_t>(edge.triangle_b);
      if (touched[a] || touched[b] || mesh.triangle_patch[a] != mesh.triangle_patch[b]) continue;
      if (!flip(mesh, edge)) continue;
      touched[a] = touched[b] = 1;
      ++flips;
    }
  }
}

} // namespace paradesc::test
