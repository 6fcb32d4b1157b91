// A mesh with the order of its points, its nodes and its patches, as the exact pass sums over it.
#pragma once

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include "engine/cpu/ball_sums.h"
#include "engine/cpu/patch_samples.h"
#include "engine/cpu/patch_surface.h"
#include "engine/cpu/point_clusters.h"
#include "engine/cpu/point_patches.h"
#include "mesh/halfedge.h"
#include "mesh/normals.h"
#include "mesh/triangles.h"

namespace paradesc::test {

struct PatchedMesh {
  explicit PatchedMesh(Triangles from, int32_t kind_of_normals = PDESC_NORMALS_FITTED)
      : triangles(std::move(from)), half_edges(build_half_edges(triangles)),
        normals(compute_normals(triangles, half_edges, build_normal_rings(triangles, half_edges), kind_of_normals, 1)),
        space(bake_space_of(bounding_box(triangles, half_edges, 1))), order(order_points(half_edges)) {}

  std::vector<vec3> positions() const { // of points, in the units of the space
    std::vector<vec3> found;
    for (const int32_t vertex : half_edges.point_vertex)
      found.push_back(space.to_buffer(triangles.positions[static_cast<size_t>(vertex)]));
    return found;
  }
  float scaled(double radius) const { return static_cast<float>(radius * space.scale); }
  PatchSurface::Mesh mesh() const { return {triangles, half_edges, normals, space}; }

  std::vector<int32_t> single_points() const {
    std::vector<int32_t> begin(static_cast<size_t>(order.points()) + 1);
    std::iota(begin.begin(), begin.end(), 0);
    return begin;
  }
  std::vector<int32_t> nodes(const ClusterLimit &limit, int threads = 2) const {
    const std::vector<vec3> at = positions();
    return plan_nodes(order, {at, normals.point, {}}, limit, threads);
  }
  PointPatches patches(const std::vector<int32_t> &node_begin, int threads = 2) const {
    return build_point_patches(order, half_edges, node_begin, threads);
  }

  Triangles triangles;
  HalfEdges half_edges;
  Normals normals;
  BakeSpace space;
  PointOrder order;
};

// The surface of one pass and its samples. It borrows the mesh.
struct ListedSurface {
  ListedSurface(const PatchedMesh &of, PointPatches patches_, const PatchSurface::Needs &needs, const SampleLimit &limit_,
                SampledTriangles which_, const BallTarget &target = ball_targets()[0], int threads = 2,
                const MapValues *map = nullptr)
      : patches(std::move(patches_)), limit(limit_), which(which_),
        mesh(of.mesh()), sampled{patches, surface, mesh, map, threads} {
    surface.refit(patches, mesh, target, needs, threads);
    samples = list_samples(sampled, limit, which);
  }
  ListedSurface(const ListedSurface &) = delete;

  // Calls use(block, k) for each item.
  template <class Use> void for_each_item(const Use &use) const {
    for (const SampleBlock &block : samples)
      for (int32_t k = 0; k < static_cast<int32_t>(block.item.size()); ++k) use(block, k);
  }
  size_t items() const {
    size_t count = 0;
    for_each_item([&](const SampleBlock &, int32_t) { ++count; });
    return count;
  }
  size_t stored_samples() const {
    size_t count = 0;
    for (const SampleBlock &block : samples) count += block.list.sample.size();
    return count;
  }
  // Adds the samples of triangles that are not stored, since they are too many.
  SampleList all_samples() const {
    SampleList all;
    for (const SampleBlock &block : samples) {
      all.sample.insert(all.sample.end(), block.list.sample.begin(), block.list.sample.end());
      all.map.insert(all.map.end(), block.list.map.begin(), block.list.map.end());
    }
    for_each_item([&](const SampleBlock &block, int32_t k) {
      if (block.is_divided(k)) divide_triangle(sampled.triangle(block.item[k]), limit, {}, sampled.map != nullptr, all);
    });
    return all;
  }

  PointPatches patches;
  SampleLimit limit;
  SampledTriangles which;
  PatchSurface::Mesh mesh;
  PatchSurface surface;
  SampledSurface sampled;
  PatchSamples samples;
};

} // namespace paradesc::test
