// Points and texels → positions, normals and triangles.
#include "compute/centers.h"

#include <limits>

#include "support/parallel.h"

namespace paradesc {

static constexpr int block = 4096; // of centers

CenterPoints centers_at_points(const Surface &surface, const BakeSpace &space, int32_t count, int threads) {
  CenterPoints centers(static_cast<size_t>(count));
  const Normals &normals = surface.normals();
  parallel_blocks(count, threads, block, [&](int begin, int end) {
    for (int i = begin; i < end; ++i)
      centers[i] = {space.to_buffer(surface.triangles.positions[surface.half_edges.point_vertex[i]]), normals.point[i],
                    surface.half_edges.point_half_edge[i] / 3, i};
  });
  return centers;
}

TexelMap lay_out_texels(const Surface &surface, int size, int threads) {
  const Triangles &triangles = surface.divided ? surface.divided->triangles : surface.triangles;
  const HalfEdges &half_edges = surface.divided ? surface.divided->half_edges : surface.half_edges;
  surface.atlases.repack_if_overfull(triangles, half_edges, threads);
  TexelMap texels = build_texel_map(surface.atlases.current().charts, size);
  // A map that leaves much of its square empty is used unchanged, since nothing is sampled by it.
  const TexelCounts counts{size * size, texels.overlapping};
  if (surface.atlases.repack_if_needed(triangles, half_edges, counts, size, std::numeric_limits<double>::infinity(), threads))
    texels = build_texel_map(surface.atlases.current().charts, size);
  return texels;
}

static vec3 weights_of(const TrianglePlace &place) { return vec3(1.0f - place.weights.x - place.weights.y, place.weights); }

// Interpolates the position in 64 bits and the normal in 32 bits.
static CenterPoint center_at(const Surface &surface, const Normals &normals, const BakeSpace &space, const TrianglePlace &place) {
  const vec3 weights = weights_of(place);
  dvec3 position(0.0);
  vec3 sum(0.0f);
  for (int k = 0; k < 3; ++k) {
    position += dvec3(surface.triangles.position(3 * place.triangle + k)) * static_cast<double>(weights[k]);
    sum += normals.corner(static_cast<size_t>(3 * place.triangle + k)) * weights[k];
  }
  const float span = length(sum);
  return {vec3((position - space.center) * space.scale),
          span > 0.0f ? sum / span : normals.corner(static_cast<size_t>(3 * place.triangle)), place.triangle, -1};
}

CenterPoints centers_at_texels(const Surface &surface, const BakeSpace &space, const TexelMap &texels, size_t first, size_t last,
                               int threads) {
  CenterPoints centers(last - first);
  const Normals &normals = surface.normals();
  parallel_blocks(static_cast<int>(centers.size()), threads, block, [&](int begin, int end) {
    for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
      const TexelCenter &texel = texels.centers[first + i];
      centers[i] = center_at(surface, normals, space, surface.place({texel.triangle, texel.weights}));
    }
  });
  return centers;
}

MapValues map_at_texels(const Surface &surface, const TexelMap &texels, const MapValues &points, size_t first, size_t last,
                        int threads) {
  MapValues values(last - first);
  parallel_blocks(static_cast<int>(values.size()), threads, block, [&](int begin, int end) {
    for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
      const TexelCenter &texel = texels.centers[first + i];
      const TrianglePlace place = surface.place({texel.triangle, texel.weights});
      const auto at = [&](int32_t k) { return points[surface.half_edges.corner_point[3 * place.triangle + k]]; };
      const vec3 weights = weights_of(place);
      values[i] = at(0) * weights.x + at(1) * weights.y + at(2) * weights.z;
    }
  });
  return values;
}

} // namespace paradesc
