// Half-edges → the order in which sums visit a mesh: nodes, which are points or clusters of points, and patches of up to eight
// nodes with their triangles.
//
// The order depends on connectivity and on the clusters only.
#pragma once

#include <cstdint>
#include <vector>

#include "mesh/cluster_tree.h"
#include "mesh/halfedge.h"

namespace paradesc {

// The points of a mesh in the order of their tree.
struct PointOrder {
  ClusterTree tree;
  PointNeighbors neighbors;
  std::vector<std::vector<int32_t>> begin; // [level](clusters + 1) where the points of each cluster begin
  std::vector<int32_t> group_begin;        // as group_points() returns it for group_lanes

  int32_t points() const { return static_cast<int32_t>(tree.item.size()); }
};
PointOrder order_points(const HalfEdges &half_edges);

// Groups of up to `most` points, which are clusters of the tree: where each begins, and the end.
std::vector<int32_t> group_points(const PointOrder &order, int32_t most);

// Triangles with a corner in a cluster belong to the cluster. The other triangles have three points as corners, and are called
// single ones.
struct PointPatches {
  static constexpr int32_t most_nodes = 8; // per patch
  static constexpr int32_t near_neighbors = 8;

  std::vector<int32_t> node;           // a point of the mesh; or ~i: cluster i
  std::vector<int32_t> patch_begin;    // (patches + 1) into node
  std::vector<int32_t> patch_of;       // (nodes)
  std::vector<int32_t> piece;          // (patches) the connected component, as in HalfEdges::triangle_piece
  std::vector<int32_t> neighbor;       // (nodes, near_neighbors) adjacent nodes; nodes() marks an unused entry
  std::vector<int32_t> more_begin;     // (nodes + 1) into more
  std::vector<int32_t> more;           // further neighbors of nodes with more than near_neighbors
  std::vector<int32_t> link_begin;     // (patches + 1) into link
  std::vector<int32_t> link;           // adjacent patches
  std::vector<int32_t> triangle_begin; // (patches + 1) into triangle
  std::vector<int32_t> triangle;   // single triangles: index in the mesh; patch of two of its corners, or the middle one of three
  std::vector<int32_t> corner;     // (3 * triangles) nodes; then padding
  std::vector<int32_t> twin;       // (3 * triangles) the half-edge across, 3 * triangle + k; -1: boundary; -2: into a cluster
  std::vector<int32_t> edge_begin; // (patches + 1) into edge
  std::vector<int32_t> edge;       // boundary half-edges of the patch's single triangles
  std::vector<int32_t> cluster_begin;    // (patches + 1) into the clusters, which are in the order of their nodes
  std::vector<int32_t> cluster_node;     // (clusters)
  std::vector<int32_t> member_begin;     // (clusters + 1) into member
  std::vector<int32_t> member;           // triangles of the mesh
  std::vector<int32_t> rim_begin;        // (clusters + 1) into rim
  std::vector<int32_t> rim;              // boundary half-edges of the cluster's triangles, as in the mesh
  std::vector<int32_t> node_of_point;    // (points of the mesh)
  std::vector<int32_t> node_of_triangle; // (triangles of the mesh) its cluster's, or the middle one of its corners; -1: left out
  std::vector<int32_t> place;            // (triangles of the mesh) the place of single ones in `triangle`; -1: none

  int32_t nodes() const { return static_cast<int32_t>(node.size()); }
  int32_t patches() const { return static_cast<int32_t>(patch_begin.size()) - 1; }
  int32_t clusters() const { return static_cast<int32_t>(cluster_node.size()); }
};

// node_begin: where the points of each node begin in the order, and the end. Each node is a cluster of the tree.
PointPatches build_point_patches(const PointOrder &order, const HalfEdges &half_edges, const std::vector<int32_t> &node_begin,
                                 int threads);

} // namespace paradesc
