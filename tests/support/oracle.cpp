#include "support/oracle.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "descriptor/passes.h"
#include "descriptor/registry.h"
#include "engine/reference/reference.h"

namespace paradesc::test {
namespace {

struct Surface {
  Triangles triangles;
  HalfEdges half_edges;
  Normals normals;
  double longest = 0; // edge
  dvec3 position(int32_t point) const {
    return dvec3(triangles.positions[static_cast<size_t>(half_edges.point_vertex[static_cast<size_t>(point)])]);
  }
};

Surface surface_of(const TestMesh &mesh, int32_t normals) {
  Surface surface{read_triangles(input_of(mesh)), {}, {}, 0};
  surface.half_edges = build_half_edges(surface.triangles);
  const NormalRings rings = build_normal_rings(surface.triangles, surface.half_edges);
  surface.normals = compute_normals(surface.triangles, surface.half_edges, rings, normals, 0);
  for (int corner = 0; corner < 3 * surface.triangles.triangle_count; ++corner) {
    const auto at = [&](int c) {
      return dvec3(surface.triangles.positions[static_cast<size_t>(surface.triangles.corner_vertex[static_cast<size_t>(c)])]);
    };
    surface.longest = std::max(surface.longest, length(at(next_corner(corner)) - at(corner)));
  }
  return surface;
}

// The points whose values computations at `points` read: the corners of all triangles that balls of this radius around them meet.
std::vector<int32_t> needed_by(const Surface &surface, std::span<const int32_t> points, double reach) {
  const double limit = reach + surface.longest;
  std::vector<int32_t> needed;
  for (int32_t point = 0; point < surface.half_edges.point_count; ++point) {
    const dvec3 position = surface.position(point);
    if (std::ranges::any_of(points, [&](int32_t other) {
          const dvec3 gap = surface.position(other) - position;
          return dot(gap, gap) <= limit * limit;
        }))
      needed.push_back(point);
  }
  return needed;
}

} // namespace

Oracle ask_oracle(const TestMesh &mesh, double radius, const Settings &settings, std::span<const int32_t> vertices,
                  std::span<const std::string> descriptors) {
  const Surface surface = surface_of(mesh, settings.normals);
  const HalfEdges &half_edges = surface.half_edges;
  std::vector<int> rows;
  for (const std::string &name : descriptors) rows.push_back(find_descriptor(name.c_str()));
  std::vector<int32_t> points; // of the vertices that have one
  for (const int32_t vertex : vertices)
    if (const int32_t point = half_edges.vertex_point[static_cast<size_t>(vertex)]; point >= 0) points.push_back(point);
  const bool of_map = std::ranges::any_of(descriptors, [](const std::string &name) { return map_degree_of(name) > 0; });
  const pdesc_options options = options_of(settings);
  const double window = radius_of({Stage::windows, {}}, options, radius);
  const std::vector<int32_t> with_gradient = of_map ? needed_by(surface, points, window) : points;
  const std::vector<int32_t> with_value = of_map ? needed_by(surface, with_gradient, radius) : points;
  ReferenceSettings requested{radius, settings.estimator, settings.distance == PDESC_DISTANCE_GEODESIC};
  requested.map_radius = radius;
  requested.harris_k = settings.harris_k;
  const auto compute_pass = [&](const Pass &pass, const MapValues *map, int, int) {
    requested.map = map;
    requested.radius = radius_of(pass, options, radius);
    requested.map_sigma = pass.stage == Stage::windows ? settings.map_sigma * radius : 0.0;
    requested.points = pass.stage == Stage::source ? with_value : pass.stage == Stage::map ? with_gradient : points;
    ReferenceField field = compute_reference(surface.triangles, half_edges, surface.normals, requested, pass.rows, 0, nullptr);
    CenterResults results;
    results.values = std::move(field.values);
    results.boundary = std::move(field.boundary);
    return results;
  };
  const CenterResults results = run_passes(rows, find_map(settings.map_descriptor), compute_pass);
  Oracle oracle;
  for (const int32_t vertex : vertices) {
    const int32_t point = half_edges.vertex_point[static_cast<size_t>(vertex)];
    oracle.boundary.push_back(point >= 0 && results.boundary[static_cast<size_t>(point)]);
    for (size_t k = 0; k < rows.size(); ++k)
      for (size_t i = 0, width = components_of(descriptors[k]); i < width; ++i)
        oracle.values[descriptors[k]].push_back(
            point >= 0 ? static_cast<double>(results.values[k][static_cast<size_t>(point) * width + i])
                       : std::numeric_limits<double>::quiet_NaN());
  }
  return oracle;
}

std::vector<float> pick(std::span<const float> values, std::span<const int32_t> vertices, size_t components) {
  std::vector<float> picked;
  for (const int32_t vertex : vertices)
    for (size_t i = 0; i < components; ++i) picked.push_back(values[static_cast<size_t>(vertex) * components + i]);
  return picked;
}

std::vector<int32_t> some_of(std::span<const int32_t> vertices, size_t max_vertices) {
  if (vertices.size() <= max_vertices) return {vertices.begin(), vertices.end()};
  std::vector<int32_t> some;
  for (size_t i = 0; i < max_vertices; ++i) some.push_back(vertices[i * vertices.size() / max_vertices]);
  return some;
}

std::vector<int32_t> clusters_of(const TestMesh &mesh, size_t count, size_t size) {
  std::vector<int32_t> vertices;
  for (size_t i = 0; i < count; ++i) {
    const Vec3 middle = mesh.points[(2 * i + 1) * mesh.points.size() / (2 * count)];
    std::vector<int32_t> nearest(mesh.points.size());
    std::iota(nearest.begin(), nearest.end(), 0);
    const auto away = [&](int32_t vertex) { return length(mesh.points[static_cast<size_t>(vertex)] - middle); };
    std::ranges::nth_element(nearest, nearest.begin() + static_cast<ptrdiff_t>(size), {}, away);
    vertices.insert(vertices.end(), nearest.begin(), nearest.begin() + static_cast<ptrdiff_t>(size));
  }
  std::ranges::sort(vertices);
  vertices.erase(std::unique(vertices.begin(), vertices.end()),
                 vertices.end()); // Clang 14 does not compile GCC 12's std::ranges::unique
  return vertices;
}

} // namespace paradesc::test
