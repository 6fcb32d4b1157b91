// Points and texels → positions, normals and triangles.
#include "engine/cpu/centers.h"

#include <limits>

#include "support/parallel.h"

namespace paradesc {

static constexpr int block = 4096; // of centers

TreeCenters centers_at_points(const Surface &surface, const BakeSpace &space, int threads) {
  TreeCenters centers(static_cast<size_t>(surface.half_edges.point_count));
  parallel_blocks(surface.half_edges.point_count, threads, block, [&](int begin, int end) {
    for (int i = begin; i < end; ++i)
      centers[i] = {space.to_buffer(surface.triangles.positions[surface.half_edges.point_vertex[i]]), surface.normals.point[i],
                    surface.half_edges.point_half_edge[i] / 3};
  });
  return centers;
}

TexelMap lay_out_texels(const Surface &surface, int size, int threads) {
  surface.atlases.repack_if_overfull(surface.triangles, surface.half_edges, threads);
  TexelMap texels = build_texel_map(surface.atlases.current().charts, size);
  // A map that leaves much of its square empty is used as it is: nothing is sampled by it.
  const TexelCounts counts{size * size, texels.overlapping};
  if (surface.atlases.repack_if_needed(surface.triangles, surface.half_edges, counts, size,
                                       std::numeric_limits<double>::infinity(), threads))
    texels = build_texel_map(surface.atlases.current().charts, size);
  return texels;
}

TreeCenters centers_at_texels(const Surface &surface, const BakeSpace &space, const TexelMap &texels, size_t first, size_t last,
                              int threads) {
  TreeCenters centers(last - first);
  parallel_blocks(static_cast<int>(centers.size()), threads, block, [&](int begin, int end) {
    const auto places = texel_centers(texels, surface.triangles, surface.atlases.current().charts, surface.normals, space, {},
                                      0.0f, 0, first + static_cast<size_t>(begin), first + static_cast<size_t>(end));
    for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
      const CenterData &place = places[i - static_cast<size_t>(begin)];
      centers[i] = {place.position, place.normal, texels.centers[first + i].triangle};
    }
  });
  return centers;
}

MapValues map_at_texels(const Surface &surface, const TexelMap &texels, const MapValues &points, size_t first, size_t last,
                        int threads) {
  MapValues values(last - first);
  parallel_blocks(static_cast<int>(values.size()), threads, block, [&](int begin, int end) {
    for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
      const TexelCenter &center = texels.centers[first + i];
      const auto at = [&](int32_t k) { return points[surface.half_edges.corner_point[3 * center.triangle + k]]; };
      values[i] = at(0) * (1.0f - center.weights.x - center.weights.y) + at(1) * center.weights.x + at(2) * center.weights.y;
    }
  });
  return values;
}

} // namespace paradesc
