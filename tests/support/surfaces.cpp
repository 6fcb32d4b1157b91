// Parameters → points with exact normals and curvatures: the closed forms of each surface.
#include "support/surfaces.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "support/triangulation.h"

namespace paradesc::test {
namespace {

constexpr double pi = 3.14159265358979323846;

struct SurfacePoint {
  Vec3 point, normal;
  double H, K;
};

// Fills the exact values. at(parameter) is a surface's closed form.
template <class At> void evaluate(TestMesh &mesh, const At &at) {
  const size_t count = mesh.parameters.size();
  mesh.vertex_count = static_cast<int32_t>(count);
  for (size_t v = 0; v < count; ++v) {
    const SurfacePoint s = at(mesh.parameters[v]);
    mesh.points.push_back(s.point);
    mesh.normals.push_back(normalized(s.normal));
    mesh.H.push_back(s.H);
    mesh.K.push_back(s.K);
    const double half_difference = std::sqrt(std::max(s.H * s.H - s.K, 0.0));
    mesh.k1.push_back(s.H + half_difference);
    mesh.k2.push_back(s.H - half_difference);
  }
}

double distance_to_segment(Vec3 p, Vec3 a, Vec3 b) {
  const Vec3 along = b - a;
  const double t = std::clamp(dot(p - a, along) / dot(along, along), 0.0, 1.0);
  return length(p - a - t * along);
}

void measure_boundary_distance(TestMesh &mesh) {
  mesh.boundary_distance.assign(mesh.points.size(), std::numeric_limits<double>::infinity());
  for (const MeshEdge &edge : mesh_edges(mesh)) {
    if (edge.triangle_b >= 0) continue;
    const Vec3 a = mesh.points[static_cast<size_t>(edge.low)], b = mesh.points[static_cast<size_t>(edge.high)];
    for (size_t v = 0; v < mesh.points.size(); ++v)
      mesh.boundary_distance[v] = std::min(mesh.boundary_distance[v], distance_to_segment(mesh.points[v], a, b));
  }
}

void finish(TestMesh &mesh, const Triangulation &triangulation) {
  if (triangulation.irregular) flip_towards_delaunay(mesh);
  measure_boundary_distance(mesh);
  mesh.triangle_corners.resize(mesh.corner_vertices.size());
  for (size_t i = 0; i < mesh.triangle_corners.size(); ++i) mesh.triangle_corners[i] = static_cast<int32_t>(i);
  round_to_float(mesh);
}

// The level set F = 0 with gradient g and a diagonal Hessian h: positive where convex, since outward is where F grows.
SurfacePoint level_set_point(Vec3 point, Vec3 g, Vec3 h) {
  const double g2 = dot(g, g);
  const double bent = g.x * g.x * h.x + g.y * g.y * h.y + g.z * g.z * h.z;
  const double H = (g2 * (h.x + h.y + h.z) - bent) / (2 * g2 * std::sqrt(g2));
  const double K = (g.x * g.x * h.y * h.z + g.y * g.y * h.x * h.z + g.z * g.z * h.x * h.y) / (g2 * g2);
  return {point, g, H, K};
}

} // namespace

double Random::normal() {
  const double radius = std::sqrt(-2 * std::log(1 - uniform())); // Box and Muller
  return radius * std::cos(2 * pi * uniform());
}

Rotation rotation_about(Vec3 axis, double angle) {
  const Vec3 a = normalized(axis);
  const double c = std::cos(angle), s = std::sin(angle), t = 1 - c;
  return {{t * a.x * a.x + c, t * a.x * a.y - s * a.z, t * a.x * a.z + s * a.y},
          {t * a.x * a.y + s * a.z, t * a.y * a.y + c, t * a.y * a.z - s * a.x},
          {t * a.x * a.z - s * a.y, t * a.y * a.z + s * a.x, t * a.z * a.z + c}};
}

double TestMesh::diagonal() const {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  float low[3] = {infinity, infinity, infinity}, high[3] = {-infinity, -infinity, -infinity};
  for (size_t i = 0; i < positions.size(); ++i) {
    low[i % 3] = std::min(low[i % 3], positions[i]);
    high[i % 3] = std::max(high[i % 3], positions[i]);
  }
  return length(Vec3{high[0], high[1], high[2]} - Vec3{low[0], low[1], low[2]});
}

TestMesh sphere(double radius, const Triangulation &triangulation) {
  TestMesh mesh = triangulate_sphere(triangulation);
  mesh.lengths = {radius, radius, radius};
  evaluate(mesh, [&](Vec3 d) { return SurfacePoint{radius * d, d, 1 / radius, 1 / (radius * radius)}; });
  finish(mesh, triangulation);
  return mesh;
}

TestMesh ellipsoid(double a, double b, double c, const Triangulation &triangulation) {
  TestMesh mesh = triangulate_sphere(triangulation);
  mesh.lengths = {a, b, c};
  evaluate(mesh, [&](Vec3 d) {
    const Vec3 gradient{2 * d.x / a, 2 * d.y / b, 2 * d.z / c};
    return level_set_point({a * d.x, b * d.y, c * d.z}, gradient, {2 / (a * a), 2 / (b * b), 2 / (c * c)});
  });
  finish(mesh, triangulation);
  return mesh;
}

TestMesh goursat(double b, const Triangulation &triangulation) {
  TestMesh mesh = triangulate_sphere(triangulation);
  evaluate(mesh, [&](Vec3 d) {
    const double fourth = std::pow(d.x, 4) + std::pow(d.y, 4) + std::pow(d.z, 4);
    const double t = std::sqrt((std::sqrt(b * b + 4 * fourth) - b) / (2 * fourth));
    const Vec3 p = t * d;
    const Vec3 gradient{4 * p.x * p.x * p.x + 2 * b * p.x, 4 * p.y * p.y * p.y + 2 * b * p.y, 4 * p.z * p.z * p.z + 2 * b * p.z};
    return level_set_point(p, gradient, {12 * p.x * p.x + 2 * b, 12 * p.y * p.y + 2 * b, 12 * p.z * p.z + 2 * b});
  });
  finish(mesh, triangulation);
  return mesh;
}

// Returns the surface of all points within fillet of a smaller cube. A direction d meets the unit cube's surface at c; an equal
// share of each edge of the grid on its faces goes to the rounding and to the flat.
TestMesh rounded_cube(double half, double fillet, const Triangulation &triangulation) {
  TestMesh mesh = triangulate_sphere(triangulation);
  mesh.lengths = {half, half, half};
  const double inner = half - fillet, arc = fillet * pi / 4, side = inner + arc; // along a face, from its middle
  const auto along = [&](double angle) { // place on the inner cube's side, and the turn of the normal
    const double s = std::abs(angle) * side, turn = s > inner ? (s - inner) / fillet : 0;
    return Vec3{std::copysign(std::min(s, inner), angle), std::copysign(std::tan(turn), angle), turn};
  };
  evaluate(mesh, [&](Vec3 d) {
    const double largest = std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
    std::array<double, 3> at{}, n{};
    int turning = 0;
    for (int i = 0; i < 3; ++i) {
      const bool own = std::abs(d[i]) == largest;
      const Vec3 along_face = along(own ? std::copysign(1, d[i]) : 4 / pi * std::atan(d[i] / largest));
      at[static_cast<size_t>(i)] = own ? std::copysign(inner, d[i]) : along_face.x;
      n[static_cast<size_t>(i)] = own ? std::copysign(1, d[i]) : along_face.y;
      turning += !own && along_face.z > 0;
    }
    const Vec3 normal = normalized({n[0], n[1], n[2]});
    return SurfacePoint{Vec3{at[0], at[1], at[2]} + fillet * normal, normal, turning / (2 * fillet),
                        turning == 2 ? 1 / (fillet * fillet) : 0};
  });
  finish(mesh, triangulation);
  return mesh;
}

TestMesh torus(double major, double minor, const Triangulation &triangulation) {
  const Vec3 lengths{2 * pi * major, 2 * pi * minor, 1};
  TestMesh mesh = triangulate_rectangle(lengths, true, true, triangulation);
  evaluate(mesh, [&](Vec3 parameter) {
    const double u = 2 * pi * parameter.x, v = 2 * pi * parameter.y;
    const Vec3 normal{std::cos(v) * std::cos(u), std::cos(v) * std::sin(u), std::sin(v)};
    const double k1 = 1 / minor, k2 = std::cos(v) / (major + minor * std::cos(v));
    return SurfacePoint{Vec3{major * std::cos(u), major * std::sin(u), 0} + minor * normal, normal, (k1 + k2) / 2, k1 * k2};
  });
  finish(mesh, triangulation);
  return mesh;
}

TestMesh plane(double width, double depth, const Triangulation &triangulation) {
  TestMesh mesh = triangulate_rectangle({width, depth, 1}, false, false, triangulation);
  evaluate(mesh, [&](Vec3 p) { return SurfacePoint{{width * (p.x - 0.5), depth * (p.y - 0.5), 0}, {0, 0, 1}, 0, 0}; });
  finish(mesh, triangulation);
  return mesh;
}

TestMesh cylinder(double radius, double height, const Triangulation &triangulation) {
  TestMesh mesh = triangulate_rectangle({2 * pi * radius, height, 1}, true, false, triangulation);
  evaluate(mesh, [&](Vec3 p) {
    const Vec3 normal{std::cos(2 * pi * p.x), std::sin(2 * pi * p.x), 0};
    return SurfacePoint{radius * normal + Vec3{0, 0, height * (p.y - 0.5)}, normal, 1 / (2 * radius), 0};
  });
  finish(mesh, triangulation);
  return mesh;
}

TestMesh saddle(double half_width, const Triangulation &triangulation) {
  TestMesh mesh = triangulate_rectangle({2 * half_width, 2 * half_width, 1}, false, false, triangulation);
  evaluate(mesh, [&](Vec3 p) {
    const double x = half_width * (2 * p.x - 1), y = half_width * (2 * p.y - 1), w2 = 1 + x * x + y * y;
    return SurfacePoint{{x, y, x * y}, {-y, -x, 1}, x * y / (w2 * std::sqrt(w2)), -1 / (w2 * w2)};
  });
  finish(mesh, triangulation);
  return mesh;
}

TestMesh catenoid(double neck, double half_height, const Triangulation &triangulation) {
  const double widest = std::cosh(half_height / neck), arc = 2 * neck * std::sinh(half_height / neck);
  TestMesh mesh = triangulate_rectangle({pi * neck * (1 + widest), arc, 1}, true, false, triangulation);
  evaluate(mesh, [&](Vec3 p) {
    // By arc length s = neck sinh(z/neck), so that cells are as high at the neck as at the rims.
    const double s = arc * (p.y - 0.5) / neck, z = neck * std::asinh(s), wide = std::sqrt(1 + s * s), u = 2 * pi * p.x;
    const double k = 1 / (neck * wide * wide);
    return SurfacePoint{{neck * wide * std::cos(u), neck * wide * std::sin(u), z}, {std::cos(u), std::sin(u), -s}, 0, -k * k};
  });
  finish(mesh, triangulation);
  return mesh;
}

pdesc_mesh_input input_of(const TestMesh &mesh) {
  pdesc_mesh_input input;
  pdesc_mesh_input_init(&input);
  input.vertex_count = mesh.vertex_count;
  input.corner_count = static_cast<int32_t>(mesh.corner_vertices.size());
  input.triangle_count = mesh.triangle_count();
  input.positions = mesh.positions.data();
  input.corner_vertices = mesh.corner_vertices.data();
  input.triangle_corners = mesh.triangle_corners.data();
  input.corner_uvs = mesh.corner_uvs.empty() ? nullptr : mesh.corner_uvs.data();
  input.corner_normals = mesh.corner_normals.empty() ? nullptr : mesh.corner_normals.data();
  return input;
}

std::vector<uint8_t> interior(const TestMesh &mesh, double r) {
  std::vector<uint8_t> flags;
  for (const double distance : mesh.boundary_distance) flags.push_back(distance > r);
  return flags;
}

double longest_edge(const TestMesh &mesh) {
  double longest = 0;
  for (const MeshEdge &edge : mesh_edges(mesh))
    longest = std::max(longest, length(mesh.points[static_cast<size_t>(edge.low)] - mesh.points[static_cast<size_t>(edge.high)]));
  return longest;
}

void rotate(TestMesh &mesh, const Rotation &rotation) {
  for (Vec3 &point : mesh.points) point = rotation(point);
  for (Vec3 &normal : mesh.normals) normal = rotation(normal);
  round_to_float(mesh);
}

void scale(TestMesh &mesh, double factor) {
  for (Vec3 &point : mesh.points) point = factor * point;
  for (auto *curvature : {&mesh.H, &mesh.k1, &mesh.k2})
    for (double &value : *curvature) value /= factor;
  for (double &value : mesh.K) value /= factor * factor;
  for (double &distance : mesh.boundary_distance) distance *= factor;
  mesh.lengths = factor * mesh.lengths;
  round_to_float(mesh);
}

void turn_inside_out(TestMesh &mesh) {
  for (size_t t = 0; t < mesh.corner_vertices.size(); t += 3) std::swap(mesh.corner_vertices[t + 1], mesh.corner_vertices[t + 2]);
  for (Vec3 &normal : mesh.normals) normal = -1 * normal;
  for (double &value : mesh.H) value = -value;
  for (size_t v = 0; v < mesh.k1.size(); ++v) {
    std::swap(mesh.k1[v], mesh.k2[v]);
    mesh.k1[v] = -mesh.k1[v];
    mesh.k2[v] = -mesh.k2[v];
  }
  round_to_float(mesh);
}

void add_noise(TestMesh &mesh, double fraction, uint32_t seed) {
  Random random(seed);
  const double deviation = fraction * mesh.diagonal();
  for (Vec3 &point : mesh.points) {
    const double x = random.normal(), y = random.normal(), z = random.normal();
    point = point + deviation * Vec3{x, y, z};
  }
  round_to_float(mesh);
}

void round_to_float(TestMesh &mesh) {
  mesh.positions.clear();
  mesh.corner_normals.clear();
  for (const Vec3 p : mesh.points)
    for (int i = 0; i < 3; ++i) mesh.positions.push_back(static_cast<float>(p[i]));
  for (const int32_t v : mesh.corner_vertices)
    for (int i = 0; i < 3; ++i) mesh.corner_normals.push_back(static_cast<float>(mesh.normals[static_cast<size_t>(v)][i]));
}

} // namespace paradesc::test
