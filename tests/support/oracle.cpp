#include "support/oracle.h"

#include <algorithm>
#include <limits>

#include "descriptor/registry.h"
#include "engine/reference/reference.h"

namespace paradesc::test {

Oracle ask_oracle(const TestMesh &mesh, double radius, const Settings &settings, std::span<const int32_t> vertices,
                  std::span<const std::string> descriptors) {
  const Triangles triangles = read_triangles(input_of(mesh));
  const HalfEdges half_edges = build_half_edges(triangles);
  const NormalRings rings = build_normal_rings(triangles, half_edges);
  const Normals normals = compute_normals(triangles, half_edges, rings, settings.normals, 0);
  std::vector<int> rows;
  for (const std::string &name : descriptors) rows.push_back(find_descriptor(name.c_str()));
  std::vector<int32_t> points; // of the vertices that have one
  for (const int32_t vertex : vertices)
    if (const int32_t point = half_edges.vertex_point[static_cast<size_t>(vertex)]; point >= 0) points.push_back(point);
  ReferenceSettings asked{radius, settings.estimator, settings.distance == PDESC_DISTANCE_GEODESIC};
  asked.points = points;
  const ReferenceField field = compute_reference(triangles, half_edges, normals, asked, rows, 0, [](double) { return true; });
  Oracle oracle;
  for (const int32_t vertex : vertices) {
    const int32_t point = half_edges.vertex_point[static_cast<size_t>(vertex)];
    oracle.boundary.push_back(point >= 0 && field.boundary[static_cast<size_t>(point)]);
    for (size_t k = 0; k < rows.size(); ++k)
      for (size_t i = 0, width = components_of(descriptors[k]); i < width; ++i)
        oracle.values[descriptors[k]].push_back(point >= 0
                                                    ? static_cast<double>(field.values[k][static_cast<size_t>(point) * width + i])
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

std::vector<int32_t> some_of(std::span<const int32_t> vertices, size_t most) {
  if (vertices.size() <= most) return {vertices.begin(), vertices.end()};
  std::vector<int32_t> some;
  for (size_t i = 0; i < most; ++i) some.push_back(vertices[i * vertices.size() / most]);
  return some;
}

} // namespace paradesc::test
