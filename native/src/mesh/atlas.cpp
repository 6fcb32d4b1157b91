// Decides whether charts need another layout, and makes it.
#include "mesh/atlas.h"

#include <cmath>

#include "mesh/cut.h"
#include "mesh/layout.h"

namespace paradesc {

// The area of all charts in (u, v). An area above 1, that of the square, implies overlap.
static double area_in_map(const Charts &charts) {
  double area = 0.0;
  for (size_t triangle = 0; triangle < charts.triangle_chart.size(); ++triangle) {
    if (charts.triangle_chart[triangle] < 0) continue;
    const vec2 *uv = &charts.corner_uv[3 * triangle];
    area += 0.5 * std::abs(cross(dvec2(uv[1]) - dvec2(uv[0]), dvec2(uv[2]) - dvec2(uv[0])));
  }
  return area;
}

void Atlases::replace(Charts charts, int32_t layout, int32_t cut_charts) {
  atlas_ = {std::move(charts), layout, cut_charts, atlas_.version + 1};
}

// Cuts charts that overlap themselves into pieces. Returns false if nothing overlaps.
bool Atlases::separate_overlaps(const Triangles &triangles, const HalfEdges &half_edges, int threads) {
  const Cuts cuts = cut_charts(half_edges, atlas_.charts, threads);
  if (cuts.overlapping) {
    const Charts charts = cuts.cut_charts > 0 ? build_charts(triangles, half_edges, cuts.triangle_piece, threads) : atlas_.charts;
    replace(*repack_charts(triangles, charts, 0.0, threads), PDESC_LAYOUT_OVERLAPS, cuts.cut_charts);
  }
  known_free_of_overlaps_ = true;
  return cuts.overlapping;
}

void Atlases::repack_if_overfull(const Triangles &triangles, const HalfEdges &half_edges, int threads) {
  constexpr double square = 1.001; // allows for rounding of the sum
  if (area_was_compared_ || atlas_.layout != PDESC_LAYOUT_GIVEN || known_free_of_overlaps_) return;
  if (area_in_map(atlas_.charts) > square) separate_overlaps(triangles, half_edges, threads);
  area_was_compared_ = true;
}

bool Atlases::repack_if_needed(const Triangles &triangles, const HalfEdges &half_edges, const TexelCounts &counts,
                               int buffer_size, double radius_in_texels, int threads) {
  if (atlas_.layout != PDESC_LAYOUT_GIVEN) return false;
  const double size = buffer_size;
  const bool sparse = counts.covered < 0.15 * size * size || radius_in_texels < 4.0;
  if (!known_free_of_overlaps_ && (counts.overlapping > 0 || sparse) && separate_overlaps(triangles, half_edges, threads))
    return true;
  if (!sparse || filling_was_tried_) return false;
  std::optional<Charts> filled = repack_charts(triangles, atlas_.charts, 1.5, threads);
  filling_was_tried_ = true;
  if (!filled) return false;
  replace(std::move(*filled), PDESC_LAYOUT_SPARSE, 0);
  return true;
}

} // namespace paradesc
