// Computes points first, then patches independently, then the bounding spheres of groups of patches.
#include "engine/cpu/patch_surface.h"

#include <algorithm>
#include <cmath>

#include "support/parallel.h"

namespace paradesc {

static constexpr int points_of_block = 4096, nodes_of_block = 4;

static int32_t spheres_above(int32_t count) { return (count + group_lanes - 1) / group_lanes; }

void PatchSurface::resize(const PointPatches &patches) {
  const auto points = static_cast<size_t>(patches.points()), of_patches = static_cast<size_t>(patches.patches()),
             triangles = patches.triangle.size();
  for (int axis = 0; axis < 3; ++axis)
    for (UnsetVector<float> *const column : {&position_[axis], &normal_[axis]}) {
      column->resize(points + group_lanes); // whole groups are read
      std::fill(column->begin() + static_cast<ptrdiff_t>(points), column->end(), 0.0f);
    }
  noise_.resize(triangles + 1);
  noise_.back() = 0.0f;
  rim_.resize(triangles + 1);
  rim_.back() = {};
  moment_.resize(triangles + 1 + of_patches);
  moment_[triangles] = {};
  own_reach_.resize(of_patches);
  for (UnsetVector<float> &column : origin_) column.resize(of_patches);
  apart_.resize(static_cast<size_t>(spheres_above(patches.patches())));
  arrays_ = {patches.patch_begin.data(),
             patches.triangle_begin.data(),
             patches.corner.data(),
             {position_[0].data(), position_[1].data(), position_[2].data()},
             noise_.data(),
             rim_.data(),
             moment_.data(),
             {},
             own_reach_.data(),
             {origin_[0].data(), origin_[1].data(), origin_[2].data()},
             apart_.data(),
             {},
             patches.patches(),
             static_cast<int32_t>(triangles)};
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

void PatchSurface::place_points(const PointPatches &patches, const Triangles &triangles, const HalfEdges &half_edges,
                                const Normals &normals, const BakeSpace &space, int threads) {
  parallel_blocks(patches.points(), threads, points_of_block, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const int32_t point = patches.point[i];
      const vec3 position = space.to_buffer(triangles.positions[half_edges.point_vertex[point]]), normal = normals.point[point];
      for (int axis = 0; axis < 3; ++axis) {
        position_[axis][i] = position[axis];
        normal_[axis][i] = normal[axis];
      }
    }
  });
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

void PatchSurface::refit(const PointPatches &patches, const Triangles &triangles, const HalfEdges &half_edges,
                         const Normals &normals, const BakeSpace &space, const BallTarget &target, bool with_noise, int threads) {
  resize(patches);
  place_points(patches, triangles, half_edges, normals, space, threads);
  const auto square_of_scale = static_cast<float>(space.scale * space.scale);
  parallel_blocks(spheres_above(patches.patches()), threads, nodes_of_block, [&](int begin, int end) {
    std::vector<float> of_corners;
    for (int32_t node = begin; node < end; ++node) {
      const int32_t last = std::min((node + 1) * group_lanes, patches.patches());
      of_corners.clear();
      for (int32_t i = patches.triangle_begin[node * group_lanes]; i < patches.triangle_begin[last]; ++i) {
        const int32_t triangle = patches.triangle[i];
        noise_[i] = with_noise ? square_of_scale * normals.noise_of(triangle) : 0.0f;
        for (int32_t corner = 3 * triangle; corner < 3 * triangle + 3; ++corner) {
          const vec3 normal = normals.corner(static_cast<size_t>(corner));
          of_corners.insert(of_corners.end(), {normal.x, normal.y, normal.z});
        }
      }
      target.refit(arrays_, node, of_corners.data());
    }
  });
  for (int level = 0; level < 2; ++level) join_spheres(level, threads);
}

} // namespace paradesc
