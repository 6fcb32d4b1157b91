// The files between the benchmarks' scripts and their programs, as programs.py writes and reads them. A mesh: int32 vertex count
// and corner count (three a triangle), then float positions, int32 vertices of the corners, float (u, v) of the corners. Values:
// int32 count, then int32 vertices, float values.
#pragma once

#include <fstream>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include "support/surfaces.h"

namespace paradesc::bench {

template <class Value> std::vector<Value> read_values(std::ifstream &file, size_t count) {
  std::vector<Value> values(count);
  file.read(reinterpret_cast<char *>(values.data()), static_cast<std::streamsize>(count * sizeof(Value)));
  if (!file) throw std::runtime_error("The mesh's file is not there, or too short.");
  return values;
}

inline test::TestMesh read_mesh(const std::string &path) {
  std::ifstream file(path, std::ios::binary);
  const std::vector<int32_t> counts = read_values<int32_t>(file, 2);
  const auto corners = static_cast<size_t>(counts[1]);
  test::TestMesh mesh;
  mesh.vertex_count = counts[0];
  mesh.positions = read_values<float>(file, 3 * static_cast<size_t>(counts[0]));
  mesh.corner_vertices = read_values<int32_t>(file, corners);
  mesh.corner_uvs = read_values<float>(file, 2 * corners);
  mesh.triangle_corners.resize(corners);
  std::iota(mesh.triangle_corners.begin(), mesh.triangle_corners.end(), 0);
  return mesh;
}

inline void write_values(const std::string &path, const std::vector<int32_t> &vertices, const std::vector<float> &values) {
  std::ofstream file(path, std::ios::binary);
  const auto count = static_cast<int32_t>(vertices.size());
  file.write(reinterpret_cast<const char *>(&count), sizeof(count));
  file.write(reinterpret_cast<const char *>(vertices.data()), static_cast<std::streamsize>(vertices.size() * sizeof(int32_t)));
  file.write(reinterpret_cast<const char *>(values.data()), static_cast<std::streamsize>(values.size() * sizeof(float)));
  if (!file) throw std::runtime_error("The values cannot be written to " + path + ".");
}

} // namespace paradesc::bench
