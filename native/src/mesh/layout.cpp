// Boxes around charts → places without overlap (stb_rect_pack), the largest scale that fits.
#include "mesh/layout.h"

#include <algorithm>
#include <cmath>
#include <limits>

#define STBRP_STATIC
#define STB_RECT_PACK_IMPLEMENTATION
#include <stb/stb_rect_pack.h>

#include "support/error.h"

namespace paradesc {

namespace {

constexpr int grid = 4096;      // units along a side of the layout
constexpr int gutter = 12;      // units around each chart: three texels of a 1024 buffer
constexpr double smallest = 16; // units of a chart's longer side: it must not fall between texels

// How one chart moves: turned by an angle, its box' corner to the origin, then scaled and placed.
struct Move {
  double cosine = 1.0, sine = 0.0;
  dvec2 low{0.0}, size{0.0};
  double scale = 1.0;
  dvec2 place{0.0};
  dvec2 turn(vec2 uv) const { return {cosine * uv.x - sine * uv.y, sine * uv.x + cosine * uv.y}; }
  vec2 operator()(vec2 uv) const { return vec2(place + (turn(uv) - low) * scale); }
};

} // namespace

static std::vector<std::vector<int32_t>> corners_by_chart(const Triangles &triangles, const Charts &charts) {
  std::vector<std::vector<int32_t>> corners(static_cast<size_t>(charts.chart_count));
  for (int32_t corner = 0; corner < 3 * triangles.triangle_count; ++corner) {
    const int32_t chart = charts.triangle_chart[static_cast<size_t>(corner / 3)];
    if (chart >= 0) corners[static_cast<size_t>(chart)].push_back(corner);
  }
  return corners;
}

// The turn, of a dozen tried, with the smallest box.
static Move best_turn(const Triangles &triangles, const std::vector<int32_t> &corners) {
  Move best;
  double smallest_area = std::numeric_limits<double>::infinity();
  for (int step = 0; step < 12; ++step) {
    Move move;
    move.cosine = std::cos(step * pi / 24.0);
    move.sine = std::sin(step * pi / 24.0);
    dvec2 low(std::numeric_limits<double>::infinity()), high(-std::numeric_limits<double>::infinity());
    for (const int32_t corner : corners) {
      const dvec2 place = move.turn(triangles.corner_uv[static_cast<size_t>(corner)]);
      low = glm::min(low, place);
      high = glm::max(high, place);
    }
    move.low = low;
    move.size = high - low;
    const double area = move.size.x * move.size.y;
    if (area >= smallest_area) continue;
    smallest_area = area;
    best = move;
  }
  return best;
}

// Places all charts at this many units per uv; false where they do not fit.
static bool pack(std::vector<Move> &moves, double units) {
  std::vector<stbrp_rect> rects;
  for (size_t i = 0; i < moves.size(); ++i) {
    Move &move = moves[i];
    const double longer = std::max({move.size.x, move.size.y, 1e-12});
    move.scale = std::max(units, smallest / longer);
    const dvec2 box = move.size * move.scale + 2.0 * gutter;
    if (box.x > grid || box.y > grid) return false;
    rects.push_back(
        {static_cast<int>(i), static_cast<stbrp_coord>(std::ceil(box.x)), static_cast<stbrp_coord>(std::ceil(box.y)), 0, 0, 0});
  }
  std::vector<stbrp_node> nodes(grid);
  stbrp_context context;
  stbrp_init_target(&context, grid, grid, nodes.data(), grid);
  if (!stbrp_pack_rects(&context, rects.data(), static_cast<int>(rects.size()))) return false;
  for (const stbrp_rect &rect : rects) moves[static_cast<size_t>(rect.id)].place = dvec2(rect.x + gutter, rect.y + gutter);
  return true;
}

void repack_charts(Triangles &triangles, Charts &charts) {
  const auto corners = corners_by_chart(triangles, charts);
  std::vector<Move> moves;
  double area = 0.0;
  for (const auto &chart : corners) {
    moves.push_back(best_turn(triangles, chart));
    area += moves.back().size.x * moves.back().size.y;
  }
  double fits = 0.0, too_large = area > 0.0 ? grid / std::sqrt(area) : 1.0;
  std::vector<Move> best;
  for (int step = 0; step < 24 && (best.empty() || too_large > 1.02 * fits); ++step) {
    const double units = best.empty() ? too_large * std::pow(0.85, step) : 0.5 * (fits + too_large);
    if (pack(moves, units)) {
      fits = units;
      best = moves;
    } else if (!best.empty()) {
      too_large = units;
    }
  }
  if (best.empty())
    throw Error(PDESC_ERROR_UNSUPPORTED,
                "The UV map overlaps itself and its " + std::to_string(moves.size()) +
                    " charts are too many to lay out afresh; unwrap the mesh with fewer islands, or use the "
                    "reference backend.");
  for (Move &move : best) {
    move.scale /= grid;
    move.place /= static_cast<double>(grid);
  }
  if (triangles.given_uv.empty()) triangles.given_uv = triangles.corner_uv;
  for (size_t chart = 0; chart < corners.size(); ++chart)
    for (const int32_t corner : corners[chart]) {
      vec2 &uv = triangles.corner_uv[static_cast<size_t>(corner)];
      uv = best[chart](uv);
    }
  for (Site &site : charts.sites) {
    const Move &move = best[static_cast<size_t>(site.chart)];
    site.uv = move(site.uv);
    site.inside = move(site.inside);
  }
}

} // namespace paradesc
