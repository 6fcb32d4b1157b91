#include "support/real_mesh.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <numeric>
#include <sstream>

namespace paradesc::test {
namespace {

// The contents of the file, polygons as fans.
struct Wavefront {
  std::vector<Vec3> points;
  std::vector<std::array<float, 2>> uvs;
  std::vector<int32_t> corner_points, corner_uvs; // the latter -1 where a corner has none
};

// Numbers count from 1, or backwards from the last.
int32_t index_of(const std::string &word, size_t count) {
  const int number = std::atoi(word.c_str());
  return number < 0 ? static_cast<int32_t>(count) + number : number - 1;
}

void read_face(std::istringstream &line, Wavefront &file) {
  std::vector<std::array<int32_t, 2>> corners;
  for (std::string word; line >> word;) {
    const size_t slash = word.find('/');
    const bool has_uv = slash != std::string::npos && slash + 1 < word.size() && word[slash + 1] != '/';
    corners.push_back({index_of(word, file.points.size()), has_uv ? index_of(word.substr(slash + 1), file.uvs.size()) : -1});
  }
  for (size_t i = 1; i + 1 < corners.size(); ++i)
    for (const auto &[point, uv] : {corners[0], corners[i], corners[i + 1]}) {
      file.corner_points.push_back(point);
      file.corner_uvs.push_back(uv);
    }
}

Wavefront read_wavefront(std::ifstream &stream) {
  Wavefront file;
  for (std::string text; std::getline(stream, text);) {
    std::istringstream line(text);
    std::string key;
    line >> key;
    if (key == "v") {
      Vec3 point;
      line >> point.x >> point.y >> point.z;
      file.points.push_back(point);
    } else if (key == "vt") {
      std::array<float, 2> uv{};
      line >> uv[0] >> uv[1];
      file.uvs.push_back(uv);
    } else if (key == "f") {
      read_face(line, file);
    }
  }
  return file;
}

// Each side of the cube has a cell of three by two.
void project(TestMesh &mesh) {
  Vec3 low{1e30, 1e30, 1e30}, high{-1e30, -1e30, -1e30};
  for (const Vec3 &p : mesh.points) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  const Vec3 size = high - low;
  const double scale = 0.3 / std::max({size.x, size.y, size.z});
  for (size_t c = 0; c < mesh.corner_vertices.size(); c += 3) {
    const auto corner = [&](size_t i) { return mesh.points[static_cast<size_t>(mesh.corner_vertices[c + i])]; };
    const Vec3 n = cross(corner(1) - corner(0), corner(2) - corner(0));
    const double x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
    const int axis = x >= y && x >= z ? 0 : y >= z ? 1 : 2;
    const int column = axis, row = n[axis] < 0 ? 1 : 0;
    for (size_t i = 0; i < 3; ++i) {
      const Vec3 p = corner(i) - low;
      mesh.corner_uvs.push_back(static_cast<float>(0.02 + column / 3.0 + scale * p[(axis + 1) % 3]));
      mesh.corner_uvs.push_back(static_cast<float>(0.02 + row / 2.0 + scale * p[(axis + 2) % 3]));
    }
  }
}

} // namespace

std::optional<TestMesh> read_real_mesh(const std::string &name) {
  std::ifstream stream(std::string(PARADESC_REAL_MESHES) + "/" + name + ".obj");
  if (!stream) return std::nullopt;
  const Wavefront file = read_wavefront(stream);
  TestMesh mesh;
  std::vector<int32_t> number(file.points.size(), -1);
  for (const int32_t point : file.corner_points) {
    int32_t &vertex = number.at(static_cast<size_t>(point));
    if (vertex < 0) {
      vertex = mesh.vertex_count++;
      mesh.points.push_back(file.points[static_cast<size_t>(point)]);
      for (int i = 0; i < 3; ++i) mesh.positions.push_back(static_cast<float>(mesh.points.back()[i]));
    }
    mesh.corner_vertices.push_back(vertex);
  }
  mesh.triangle_corners.resize(mesh.corner_vertices.size());
  std::iota(mesh.triangle_corners.begin(), mesh.triangle_corners.end(), 0);
  if (std::count(file.corner_uvs.begin(), file.corner_uvs.end(), -1) > 0) {
    project(mesh);
    return mesh;
  }
  for (const int32_t uv : file.corner_uvs)
    for (const float coordinate : file.uvs.at(static_cast<size_t>(uv))) mesh.corner_uvs.push_back(coordinate);
  return mesh;
}

} // namespace paradesc::test
