// Computes points first, then patches independently, then the bounding spheres of groups of patches.
#include "engine/cpu/patch_surface.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "support/cancel.h"
#include "support/parallel.h"

namespace paradesc {

static constexpr int points_of_block = 4096, batches_of_block = 4;

static int32_t spheres_above(int32_t count) { return (count + group_lanes - 1) / group_lanes; }

void PatchSurface::resize(const PointPatches &patches, const Needs &needs) {
  const auto nodes = static_cast<size_t>(patches.nodes()), of_patches = static_cast<size_t>(patches.patches()),
             triangles = patches.triangle.size(), clusters = static_cast<size_t>(patches.clusters());
  for (UnsetVector<float> *const column : {&position_[0], &position_[1], &position_[2], &node_reach_}) column->resize(nodes);
  cluster_.resize(clusters);
  if (needs.sums) {
    noise_.resize(triangles + 1);
    noise_.back() = 0.0f;
    rim_.resize(triangles + 1);
    rim_.back() = {};
    turning_.resize(triangles);
    moment_.resize(triangles + 1 + of_patches + clusters);
    moment_[triangles] = {};
  }
  own_reach_.resize(of_patches);
  for (UnsetVector<float> &column : origin_) column.resize(of_patches);
  apart_.resize(static_cast<size_t>(spheres_above(patches.patches())));
  for (UnsetVector<uint8_t> *flags : {&has_long_edge_, &has_listed_}) flags->resize(of_patches);
  arrays_ = {patches.patch_begin.data(),
             patches.triangle_begin.data(),
             patches.corner.data(),
             patches.cluster_begin.data(),
             patches.cluster_node.data(),
             {position_[0].data(), position_[1].data(), position_[2].data()},
             node_reach_.data(),
             noise_.data(),
             rim_.data(),
             turning_.data(),
             moment_.data(),
             {},
             own_reach_.data(),
             {origin_[0].data(), origin_[1].data(), origin_[2].data()},
             apart_.data(),
             has_long_edge_.data(),
             has_listed_.data(),
             {},
             patches.patches(),
             static_cast<int32_t>(triangles),
             needs.large};
  constexpr float nowhere = 1e15f;
  for (int32_t level = 0, count = patches.patches(); level < 3; ++level, count = spheres_above(count)) {
    for (int k = 0; k < 4; ++k) {
      UnsetVector<float> &column = sphere_[level][k];
      column.resize(static_cast<size_t>(spheres_above(count) + 1) * group_lanes);
      std::fill(column.begin() + count, column.end(), k < 3 ? nowhere : 0.0f);
    }
    const auto &sphere = sphere_[level];
    arrays_.levels[level] = {{sphere[0].data(), sphere[1].data(), sphere[2].data()}, sphere[3].data(), count};
  }
  for (int k = 0; k < 4; ++k) arrays_.sphere[k] = sphere_[0][k].data();
}

// Returns a triangle in the units of the space.
static Sample sample_of(const PatchSurface::Mesh &mesh, int32_t triangle, bool with_noise) {
  vec3 corners[3], normals[3];
  for (int32_t k = 0; k < 3; ++k) {
    corners[k] = mesh.space.to_buffer(mesh.triangles.position(3 * triangle + k));
    normals[k] = mesh.normals.corner(static_cast<size_t>(3 * triangle + k));
  }
  Sample sample = sample_of_triangle(corners, normals);
  const auto square_of_scale = static_cast<float>(mesh.space.scale * mesh.space.scale);
  sample.noise = with_noise ? square_of_scale * mesh.normals.noise_of(triangle) : 0.0f;
  sample.facet = sample.area;
  return sample;
}

void PatchSurface::sum_clusters(const PointPatches &patches, const Mesh &mesh, const Needs &needs, int threads) {
  constexpr int clusters_of_block = 64;
  parallel_blocks(patches.clusters(), threads, clusters_of_block, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const auto members = std::span(patches.member)
                               .subspan(static_cast<size_t>(patches.member_begin[i]),
                                        static_cast<size_t>(patches.member_begin[i + 1] - patches.member_begin[i]));
      const auto place = [&](int32_t corner) { return mesh.space.to_buffer(mesh.triangles.position(corner)); };
      if (members.empty()) continue;
      ClusterSums sums(place(3 * members[0]));
      for (const int32_t triangle : members) sums.add(sample_of(mesh, triangle, needs.noise));
      cluster_[i] = sums.cluster();
      float square = 0.0f;
      for (const int32_t triangle : members)
        for (int32_t corner = 3 * triangle; corner < 3 * triangle + 3; ++corner) {
          const vec3 gap = place(corner) - cluster_[i].position;
          square = std::max(square, dot(gap, gap));
        }
      cluster_[i].reach = std::sqrt(square);
    }
  });
}

void PatchSurface::place_rims(const PointPatches &patches, const Mesh &mesh) {
  rim_edge_.resize(patches.rim.size());
  for (size_t i = 0; i < rim_edge_.size(); ++i) {
    checkpoint_at(i);
    const int32_t edge = patches.rim[i];
    const auto place = [&](int32_t corner) { return mesh.space.to_buffer(mesh.triangles.position(corner)); };
    rim_edge_[i] = {place(edge), place(next_corner(edge))};
  }
}

void PatchSurface::place_nodes(const PointPatches &patches, const Mesh &mesh, int threads) {
  parallel_blocks(patches.nodes(), threads, points_of_block, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const int32_t node = patches.node[i];
      const vec3 position = node >= 0 ? mesh.space.to_buffer(mesh.triangles.positions[mesh.half_edges.point_vertex[node]])
                                      : cluster_[~node].position;
      for (int axis = 0; axis < 3; ++axis) position_[axis][i] = position[axis];
      node_reach_[i] = node >= 0 ? 0.0f : cluster_[~node].reach;
    }
  });
}

// Writes the moments of a batch's clusters about the origins of their patches, and adds them to those of the patches.
void PatchSurface::add_cluster_rows(const PointPatches &patches, int32_t batch) {
  const int32_t last = std::min((batch + 1) * group_lanes, patches.patches());
  for (int32_t patch = batch * group_lanes; patch < last; ++patch)
    for (int32_t i = patches.cluster_begin[patch]; i < patches.cluster_begin[patch + 1]; ++i) {
      const Cluster &cluster = cluster_[i];
      const vec3 x = cluster.position - vec3(origin_[0][patch], origin_[1][patch], origin_[2][patch]);
      const mat3 xx = cluster.variance + glm::outerProduct(x, x),
                 nx = cluster.normal_variance + glm::outerProduct(cluster.normal, x);
      MomentRow row{};
      row.of[moment_area] = cluster.area;
      for (int axis = 0; axis < 3; ++axis) {
        const int k = axis == 2 ? 1 : 0, l = axis == 0 ? 1 : 2; // xy, xz, yz
        row.of[moment_x + axis] = cluster.area * x[axis];
        row.of[moment_n + axis] = cluster.area * cluster.normal[axis];
        row.of[moment_xx + axis] = cluster.area * xx[axis][axis];
        row.of[moment_xx + 3 + axis] = cluster.area * xx[k][l];
        row.of[moment_xn + axis] = cluster.area * nx[axis][axis];
        row.of[moment_xn + 3 + axis] = cluster.area * (nx[k][l] + nx[l][k]);
      }
      row.of[moment_facet] = cluster.area * cluster.facet;
      row.of[moment_noise] = cluster.area * cluster.noise;
      moment_[arrays_.row_of_cluster(i)] = row;
      for (int k = 0; k < moment_row; ++k) moment_[arrays_.row_of_patch(patch)].of[k] += row.of[k];
    }
}

// Bounds sixteen spheres of a level at a time. The middle is that of the spheres' bounding box.
void PatchSurface::join_spheres(int level, int threads) {
  const int32_t count = arrays_.levels[level].count;
  const auto &below = sphere_[level];
  auto &above = sphere_[level + 1];
  parallel_blocks(spheres_above(count), threads, points_of_block, [&](int begin, int end) {
    for (int32_t i = begin; i < end; ++i) {
      const int32_t first = i * group_lanes, last = std::min(first + group_lanes, count);
      float reach = 0.0f, middle[3];
      for (int axis = 0; axis < 3; ++axis) {
        float low = below[axis][first] - below[3][first], high = below[axis][first] + below[3][first];
        for (int32_t k = first + 1; k < last; ++k) {
          low = std::min(low, below[axis][k] - below[3][k]);
          high = std::max(high, below[axis][k] + below[3][k]);
        }
        above[axis][i] = middle[axis] = 0.5f * (low + high);
      }
      for (int32_t k = first; k < last; ++k) {
        const vec3 gap(below[0][k] - middle[0], below[1][k] - middle[1], below[2][k] - middle[2]);
        reach = std::max(reach, length(gap) + below[3][k]);
      }
      above[3][i] = 1.00001f * reach;
    }
  });
}

void PatchSurface::refit(const PointPatches &patches, const Mesh &mesh, const BallTarget &target, const Needs &needs,
                         int threads) {
  resize(patches, needs);
  sum_clusters(patches, mesh, needs, threads);
  place_rims(patches, mesh);
  place_nodes(patches, mesh, threads);
  const auto square_of_scale = static_cast<float>(mesh.space.scale * mesh.space.scale);
  parallel_blocks(spheres_above(patches.patches()), threads, batches_of_block, [&](int begin, int end) {
    std::vector<float> of_corners;
    for (int32_t batch = begin; batch < end; ++batch) {
      if (!needs.sums) {
        target.refit_spheres(arrays_, batch);
        continue;
      }
      const int32_t last = std::min((batch + 1) * group_lanes, patches.patches());
      of_corners.clear();
      for (int32_t i = patches.triangle_begin[batch * group_lanes]; i < patches.triangle_begin[last]; ++i) {
        const int32_t triangle = patches.triangle[i];
        noise_[i] = needs.noise ? square_of_scale * mesh.normals.noise_of(triangle) : 0.0f;
        for (int32_t corner = 3 * triangle; corner < 3 * triangle + 3; ++corner) {
          const vec3 normal = mesh.normals.corner(static_cast<size_t>(corner));
          of_corners.insert(of_corners.end(), {normal.x, normal.y, normal.z});
        }
      }
      target.refit(arrays_, batch, of_corners.data());
      add_cluster_rows(patches, batch);
    }
  });
  for (int level = 0; level < 2; ++level) join_spheres(level, threads);
}

} // namespace paradesc
