// Triangulations of the parameter domains of surfaces.h, and what follows from their edges.
#pragma once

#include <cstdint>
#include <vector>

#include "support/surfaces.h"

namespace paradesc::test {

// Parameters, corner_vertices and triangle_patch of a mesh without points yet. Winding is counter-clockwise in (u, v).
TestMesh triangulate_rectangle(Vec3 lengths, bool periodic_u, bool periodic_v, const Triangulation &triangulation);
// A cube, divided by equal angles and thrown onto the sphere: no poles. Winding is outward.
TestMesh triangulate_sphere(const Triangulation &triangulation);

struct MeshEdge {
  int32_t low, high;              // vertices
  int32_t triangle_a, triangle_b; // -1: a boundary
};
std::vector<MeshEdge> mesh_edges(const TestMesh &mesh);

// Turns edges whose two opposite angles sum to more than half a turn, within each patch, for a few rounds.
void flip_towards_delaunay(TestMesh &mesh);

} // namespace paradesc::test
