// Triangles, normals and a radius → surfels, pieces of the surface that are small against the radius: what sums over
// neighborhoods run over. Clusters of small triangles are one surfel; large triangles are divided when a neighborhood asks for
// them.
//
// Surfels are collected in cells, connected pieces of surface of some dozens of samples, by whose links a neighborhood is found.
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

// A surface at one moment.
struct SurfelSource {
  const Triangles &triangles;
  const HalfEdges &half_edges;
  const Normals &normals;
  const ClusterTree &tree;
  UnsetVector<vec3> positions;  // (vertex_count) in the units of all that follows
  const std::vector<vec4> *map; // (point_count) gradient and value of what operators work on, or null
  int threads;
  float scale; // of positions, against those of the normals' mesh

  vec3 position(int32_t corner) const { return positions[triangles.corner_vertex[corner]]; }
  float noise_of(int32_t triangle) const { return scale * scale * normals.noise_of(triangle); }
};
float squared_turn(vec3 a, vec3 b, vec3 c); // of normals: the largest squared distance between them, were they of length 1; about

// As SurfelSource has them.
UnsetVector<vec3> positions_in(const BakeSpace &space, const Triangles &triangles, int threads);

struct Surfel {
  vec3 position;   // mean
  float reach;     // no point of it is farther from there
  float samples;   // about as many; above 1: a triangle that is divided
  int32_t cluster; // -1: a triangle
};

struct Surfels {
  float radius = 0;
  float largest_spread = 0;            // of triangles and of their parts, where normals hardly turn
  UnsetVector<Surfel> surfel;          // in the order of the tree
  UnsetVector<int32_t> first;          // (surfels + 1) into ClusterTree::item
  std::vector<Cluster> cluster;        // of surfels with several triangles
  UnsetVector<int32_t> neighbor_begin; // (surfels + 1) into neighbor
  UnsetVector<int32_t> neighbor;       // surfels that share edges with each
  UnsetVector<int32_t> edge_begin;     // (neighbors + 1) into edge
  UnsetVector<int32_t> edge;           // half-edges that each of them is met over

  UnsetVector<int32_t> cell_begin;     // (cells + 1) into surfel
  UnsetVector<vec4> cell_sphere;       // (cells) middle, radius
  UnsetVector<int32_t> link_begin;     // (cells + 1) into link
  UnsetVector<int32_t> link;           // neighboring cells
  UnsetVector<int32_t> boundary_begin; // (cells + 1) into boundary
  UnsetVector<int32_t> boundary;       // half-edges on the mesh's boundary

  UnsetVector<vec3> face; // (triangle_count) unit normals; 0 without area, or left out

  UnsetVector<int32_t> triangle_cell;   // (triangle_count) -1: left out
  UnsetVector<int32_t> triangle_surfel; // (triangle_count) likewise

  int32_t cells() const { return static_cast<int32_t>(cell_sphere.size()); }
  // Where the farthest two of the normals at the corners have this squared distance: a sample does not know how far they are from
  // varying linearly.
  float largest_spread_at(float turn) const;
};

// How far no normal of a surfel's triangles, and of those around them, is from the face, as points of the unit sphere.
float lean_of(const SurfelSource &source, const Surfels &surfels, int32_t surfel, vec3 face);
// Of a whole triangle. lean: as sample_of_triangle() takes it.
Sample sample_of(const SurfelSource &source, int32_t triangle, float lean);

// How fine a surface is divided: into how many samples a disk of the radius, about. The rim cuts triangles exactly, so that they
// may be larger than clusters; and far larger for what does not depend on the last per cent of an area, or on what lies near.
struct Fineness {
  int samples;
  float triangles = 1.5f;   // how much wider they may spread than clusters
  float coherence = 0.995f; // of a cluster's normals: the square of their mean's length, at least. So it hides no detail
  friend bool operator==(const Fineness &, const Fineness &) = default;
};
Surfels build_surfels(const SurfelSource &source, float radius, Fineness fineness);

} // namespace paradesc
