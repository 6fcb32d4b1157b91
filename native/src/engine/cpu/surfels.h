// Triangles, normals and a radius → surfels. These are pieces of the surface that are small against the radius, and sums over
// neighborhoods use them. A cluster of small triangles is one surfel. Large triangles are divided into samples.
//
// Surfels are grouped into cells, which are connected pieces of the surface with some dozens of samples. Links between cells lead
// to the cells of a neighborhood.
#pragma once

#include <cstdint>
#include <vector>

#include "bake/distortion.h"
#include "engine/cpu/pieces.h"
#include "mesh/cluster_tree.h"
#include "mesh/halfedge.h"
#include "mesh/normals.h"
#include "mesh/triangles.h"
#include "support/unset.h"

namespace paradesc {

// A surface at one time.
struct SurfelSource {
  const Triangles &triangles;
  const HalfEdges &half_edges;
  const Normals &normals;
  const ClusterTree &tree;
  UnsetVector<vec3> positions;  // (vertex_count) in the units of all derived lengths
  const std::vector<vec4> *map; // (point_count) gradient and value of the map for operators, or null
  int threads;
  float scale; // units of positions per unit of the normals' mesh

  vec3 position(int32_t corner) const { return positions[triangles.corner_vertex[corner]]; }
  float noise_of(int32_t triangle) const { return scale * scale * normals.noise_of(triangle); }
};
float squared_turn(vec3 a, vec3 b, vec3 c); // the largest squared distance between the normals, if they had length 1; approximate

// Returns the positions for SurfelSource.
UnsetVector<vec3> positions_in(const BakeSpace &space, const Triangles &triangles, int threads);

struct Surfel {
  vec3 position;   // mean
  float reach;     // bound on the distance of its points from position
  float samples;   // approximate number of samples; above 1 for a triangle that is divided
  int32_t cluster; // index into Surfels::cluster; -1: a triangle
};

struct Surfels {
  float radius = 0;
  float largest_spread = 0;            // of triangles and of their parts, where normals hardly turn
  UnsetVector<Surfel> surfel;          // in the order of the tree
  UnsetVector<int32_t> first;          // (surfels + 1) into ClusterTree::item
  std::vector<Cluster> cluster;        // of the surfels with several triangles
  UnsetVector<int32_t> neighbor_begin; // (surfels + 1) into neighbor
  UnsetVector<int32_t> neighbor;       // surfels that share an edge
  UnsetVector<int32_t> edge_begin;     // (neighbors + 1) into edge
  UnsetVector<int32_t> edge;           // half-edges that lead to each neighbor

  UnsetVector<int32_t> cell_begin;     // (cells + 1) into surfel
  UnsetVector<vec4> cell_sphere;       // (cells) middle, radius
  UnsetVector<int32_t> link_begin;     // (cells + 1) into link
  UnsetVector<int32_t> link;           // neighboring cells
  UnsetVector<int32_t> boundary_begin; // (cells + 1) into boundary
  UnsetVector<int32_t> boundary;       // half-edges on the mesh's boundary

  UnsetVector<vec3> face; // (triangle_count) unit normals; 0 if left out or without area

  UnsetVector<int32_t> triangle_cell;   // (triangle_count) -1: left out
  UnsetVector<int32_t> triangle_surfel; // (triangle_count) -1: left out

  int32_t cells() const { return static_cast<int32_t>(cell_sphere.size()); }
  // Returns the limit for a triangle with this squared turn of its normals; see squared_turn(). The limit falls as they turn,
  // since a sample cannot represent normals that vary nonlinearly.
  float largest_spread_at(float turn) const;
};

// Returns a bound on the distance, on the unit sphere, of the normals of triangles in and around a surfel from the face normal.
float lean_of(const SurfelSource &source, const Surfels &surfels, int32_t surfel, vec3 face);
// Returns the sample of a whole triangle. lean: see sample_of_triangle().
Sample sample_of(const SurfelSource &source, int32_t triangle, float lean);

// The resolution of a surface. A disk of the radius has about `samples` samples. The rim cuts triangles exactly, so these may be
// larger than clusters. They may be much larger for values that do not depend on the last percent of an area, or on the center's
// immediate surroundings.
struct Fineness {
  int samples;
  float triangles = 1.5f;   // largest spread of a triangle, relative to that of a cluster
  float coherence = 0.995f; // least squared length of a cluster's mean normal, so that it hides no detail
  friend bool operator==(const Fineness &, const Fineness &) = default;
};
Surfels build_surfels(const SurfelSource &source, float radius, Fineness fineness);

} // namespace paradesc
