// The reference at some vertices of a mesh: where all would take minutes, some hundred take a second.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "support/run.h"
#include "support/surfaces.h"

namespace paradesc::test {

// All lists are in the order of the list of vertices.
struct Oracle {
  std::map<std::string, std::vector<double>> values; // by descriptor: (vertices, components)
  std::vector<uint8_t> boundary;                     // (vertices) 1: the mesh's boundary lies within the radius
  const std::vector<double> &operator[](const std::string &name) const { return values.at(name); }
};

// radius: in units of the positions. Operators want their map around each of the vertices: ask for these where some lie together.
Oracle ask_oracle(const TestMesh &mesh, double radius, const Settings &settings, std::span<const int32_t> vertices,
                  std::span<const std::string> descriptors);

// The values of these vertices, (vertices, components), of those of all.
std::vector<float> pick(std::span<const float> values, std::span<const int32_t> vertices, size_t components = 1);

// At most max_vertices of the vertices, evenly spread over their numbers.
std::vector<int32_t> some_of(std::span<const int32_t> vertices, size_t max_vertices);

// `size` vertices in each of `count` regions of the mesh.
std::vector<int32_t> clusters_of(const TestMesh &mesh, size_t count, size_t size);

} // namespace paradesc::test
