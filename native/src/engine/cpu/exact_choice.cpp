// Measures triangles block by block in the order of the mesh, in which nearby triangles are mostly near in memory, too.
#include "engine/cpu/exact_choice.h"

#include <algorithm>
#include <cmath>

#include "engine/cpu/finish.h"
#include "support/parallel.h"

namespace paradesc {

namespace {

struct BlockSize {
  double longest_square = 0, perimeters = 0, areas = 0;
  int32_t triangles = 0;
};

} // namespace

static BlockSize measure_block(const Triangles &triangles, const HalfEdges &half_edges, int begin, int end) {
  BlockSize size;
  for (int32_t t = begin; t < end; ++t) {
    if (half_edges.corner_point[3 * t] < 0) continue;
    const vec3 a = triangles.position(3 * t), ab = triangles.position(3 * t + 1) - a, ac = triangles.position(3 * t + 2) - a;
    const vec3 bc = ac - ab;
    const float squares[3] = {dot(ab, ab), dot(bc, bc), dot(ac, ac)};
    size.longest_square = std::max(size.longest_square, static_cast<double>(std::max({squares[0], squares[1], squares[2]})));
    for (const float square : squares) size.perimeters += static_cast<double>(std::sqrt(square));
    size.areas += static_cast<double>(0.5f * length(cross(ab, ac)));
    ++size.triangles;
  }
  return size;
}

// The number of edges that a curve crosses is about 2/pi times its length times the length of edges per area. Each edge is shared
// by two triangles.
TriangleSizes measure_triangles(const Triangles &triangles, const HalfEdges &half_edges, int threads) {
  constexpr int block_size = 256;
  const Blocks blocks{triangles.triangle_count, block_size};
  std::vector<BlockSize> sizes(static_cast<size_t>(blocks.number()));
  parallel_blocks(blocks.number(), threads, 16, [&](int begin, int end) {
    for (int block = begin; block < end; ++block)
      sizes[static_cast<size_t>(block)] = measure_block(triangles, half_edges, blocks.begin(block), blocks.end(block));
  });
  TriangleSizes whole;
  double triangles_in_all = 0;
  for (const BlockSize &size : sizes) {
    whole.longest_edge = std::max(whole.longest_edge, std::sqrt(size.longest_square));
    if (!(size.areas > 0)) continue;
    whole.rim_per_radius += 2 * size.perimeters / size.areas * size.triangles;
    triangles_in_all += size.triangles;
  }
  if (triangles_in_all > 0) whole.rim_per_radius /= triangles_in_all;
  return whole;
}

bool has_exact_sums(const Surface &surface, const Request &request, const Pass &pass) {
  constexpr int32_t most_triangles = 1 << 26; // The rows of RimTriangles must have 32-bit offsets.
  return !surface.divided && request.options.evaluate != PDESC_EVALUATE_TEXEL &&
         surface.triangles.triangle_count < most_triangles &&
         plan_sums(pass.rows, request.options, pass.stage == Stage::windows).kind == SumKind::fit;
}

bool suits_exact_sums(const TriangleSizes &sizes, double radius) {
  constexpr double longest_edge = 1.25; // of the radius; an edge with both ends outside the ball does not reach its middle
  constexpr double most_at_rim = 180.0; // beyond this, clusters of triangles are faster
  return sizes.longest_edge <= longest_edge * radius && sizes.rim_per_radius * radius <= most_at_rim;
}

} // namespace paradesc
