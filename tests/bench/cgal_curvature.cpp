// A mesh's file → mean curvature by CGAL's interpolated corrected curvature measures in a ball, and the seconds it took.
//
//   paradesc_cgal_curvature MESH RADIUS VALUES [gaussian]        # Gaussian curvature instead
//
// RADIUS is in units of the positions. VALUES gets int32 n, n int32 vertices, n float values, in the order of the vertices.
// Reading and making the mesh do not count.
#include <chrono>
#include <cstdio>
#include <exception>
#include <string>

#include <CGAL/Polygon_mesh_processing/interpolated_corrected_curvatures.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>

#include "bench/mesh_file.h"

namespace paradesc::bench {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;

Mesh build(const test::TestMesh &read) {
  Mesh mesh;
  for (size_t i = 0; i < read.positions.size(); i += 3)
    mesh.add_vertex({read.positions[i], read.positions[i + 1], read.positions[i + 2]});
  const auto vertex = [&](size_t corner) { return Mesh::Vertex_index(static_cast<uint32_t>(read.corner_vertices[corner])); };
  for (size_t i = 0; i < read.corner_vertices.size(); i += 3) // a face that CGAL cannot link is left out
    mesh.add_face(vertex(i), vertex(i + 1), vertex(i + 2));
  return mesh;
}

void run(const std::string &path, double radius, const std::string &values_path, bool gaussian) {
  const Mesh mesh = build(read_mesh(path));
  std::vector<double> curvature(mesh.number_of_vertices());
  const auto map = boost::make_iterator_property_map(curvature.begin(), get(boost::vertex_index, mesh));
  const auto start = std::chrono::steady_clock::now();
  if (gaussian)
    CGAL::Polygon_mesh_processing::interpolated_corrected_curvatures(
        mesh, CGAL::parameters::vertex_Gaussian_curvature_map(map).ball_radius(radius));
  else
    CGAL::Polygon_mesh_processing::interpolated_corrected_curvatures(
        mesh, CGAL::parameters::vertex_mean_curvature_map(map).ball_radius(radius));
  std::printf("%.6f\n", std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());

  std::vector<int32_t> vertices(curvature.size());
  std::iota(vertices.begin(), vertices.end(), 0);
  write_values(values_path, vertices, {curvature.begin(), curvature.end()});
}

} // namespace
} // namespace paradesc::bench

int main(int count, char **arguments) {
  try {
    const bool gaussian = count == 5 && std::string(arguments[4]) == "gaussian";
    if (count != 4 + gaussian) throw std::runtime_error("Give a mesh's file, the radius, and a file for the values.");
    paradesc::bench::run(arguments[1], std::stod(arguments[2]), arguments[3], gaussian);
    return 0;
  } catch (const std::exception &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
