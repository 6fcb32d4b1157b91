// Boxes around charts → positions without overlap (stb_rect_pack), with texel densities brought near each other, at the largest
// scale that fits.
#include "mesh/layout.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#define STBRP_STATIC
#include <stb/stb_rect_pack.h>

// Sorts stably: the order in which qsort() leaves boxes of one size depends on the C library.
static void sort_boxes(stbrp_rect *boxes, int count, size_t, int (*compare)(const void *, const void *)) {
  const std::span all(boxes, static_cast<size_t>(count));
  std::stable_sort(all.begin(), all.end(), [&](const stbrp_rect &a, const stbrp_rect &b) { return compare(&a, &b) < 0; });
}
#define STBRP_SORT sort_boxes
#define STB_RECT_PACK_IMPLEMENTATION
#include <stb/stb_rect_pack.h>

#include "support/error.h"
#include "support/logarithm.h"
#include "support/parallel.h"

namespace paradesc {

namespace {

constexpr int grid = 4096; // units along a side of the layout

constexpr double evenness = 2.0; // limit on how far a chart's texel density may be from the others'. A face keeps more texels
                                 // than a foot; with equal densities, the small triangles of faces would fall between texels

// The least distances between charts, in units; the narrower ones are for maps with very many charts.
struct Spacing {
  int gutter;      // around each chart
  double smallest; // a chart's longer side: it must not fall between texels
};
constexpr Spacing spacings[] = {{6, 16.0}, {3, 8.0}, {2, 4.0}}; // three texels of a 1024 buffer between charts, or less

// A chart counts as stretched if the UV map gives a length on the surface this many doublings more texels in one direction than
// in the other. It is widened in the direction with the fewest texels, at most until it is `longest` times as long there as
// across: a longer chart would fill the square with one direction alone.
constexpr int least_doublings = 2;
constexpr double longest = 4.0;

// The move of one chart: it is turned by an angle, the corner of its box is moved to 0, then it is scaled and moved to `origin`.
struct Move {
  double cosine = 1.0, sine = 0.0;
  dvec2 low{0.0}, size{0.0};
  double evening = 1.0; // scale that brings the chart's texel density near the others'
  double scale = 1.0;
  dvec2 origin{0.0};
  dvec2 turn(vec2 uv) const { return {cosine * uv.x - sine * uv.y, sine * uv.x + cosine * uv.y}; }
  vec2 operator()(vec2 uv) const { return vec2(origin + (turn(uv) - low) * scale); }
};

// A chart's length in the UV map per length on its surface, and the surface area that it carries.
struct Density {
  double density = 0.0, area = 0.0;
};

} // namespace

static std::vector<std::vector<int32_t>> corners_by_chart(const Triangles &triangles, const Charts &charts) {
  std::vector<std::vector<int32_t>> corners(static_cast<size_t>(charts.chart_count));
  for (int32_t corner = 0; corner < 3 * triangles.triangle_count; ++corner) {
    const int32_t chart = charts.triangle_chart[corner / 3];
    if (chart >= 0) corners[chart].push_back(corner);
  }
  return corners;
}

// Rotates by stored cosines and sines instead of calling a C library, whose results may differ in the last bit.
static dvec2 further(dvec2 turn, dvec2 by) { return {turn.x * by.x - turn.y * by.y, turn.x * by.y + turn.y * by.x}; }
static constexpr dvec2 quarter_turn(0.0, 1.0);

static Move turned(const Charts &charts, const std::vector<int32_t> &corners, dvec2 turn) {
  Move move;
  move.cosine = turn.x;
  move.sine = turn.y;
  Bounds<dvec2> box;
  for (const int32_t corner : corners) box.add(move.turn(charts.corner_uv[corner]));
  move.low = box.low;
  move.size = box.size();
  return move;
}

// The turn with the smallest box out of a dozen, made upright because upright boxes fill the square best.
static Move best_turn(const Charts &charts, const std::vector<int32_t> &corners) {
  constexpr dvec2 step(0.99144486137381041, 0.13052619222005159); // a twelfth of a quarter turn
  double smallest_area = std::numeric_limits<double>::infinity();
  dvec2 best(1.0, 0.0), turn = best;
  for (int i = 0; i < 12; ++i, turn = further(turn, step)) {
    const Move move = turned(charts, corners, turn);
    const double area = move.size.x * move.size.y;
    if (area >= smallest_area) continue;
    smallest_area = area;
    best = move.size.x > move.size.y ? further(turn, quarter_turn) : turn;
  }
  return turned(charts, corners, best);
}

// Moves corners and wedges to moved(chart, uv).
template <class Moved>
static void move_charts(const std::vector<std::vector<int32_t>> &corners, const Moved &moved, Charts &charts) {
  std::vector<vec2> uvs = charts.corner_uv.copy();
  for (size_t chart = 0; chart < corners.size(); ++chart)
    for (const int32_t corner : corners[chart]) uvs[corner] = moved(chart, uvs[corner]);
  charts.corner_uv = std::move(uvs);
  for (Wedge &wedge : charts.wedges) {
    wedge.uv = moved(static_cast<size_t>(wedge.chart), wedge.uv);
    wedge.inside = moved(static_cast<size_t>(wedge.chart), wedge.inside);
  }
}

// The mean, over a chart's surface, of the logarithm of its metric scaled to determinant 1. The vector's length is the logarithm
// of how many times more texels one direction has than the other; half its angle is the direction with fewer. A few needles with
// next to no area in the map do not sway this mean.
static dvec2 mean_stretch(const Triangles &triangles, const Charts &charts, const std::vector<int32_t> &corners) {
  dvec2 sum(0.0);
  double weight = 0.0;
  for (const int32_t corner : corners) {
    if (corner % 3 != 0) continue;
    const auto position = [&](int i) { return dvec3(triangles.positions[triangles.corner_vertex[corner + i]]); };
    const dvec3 e1 = position(1) - position(0), e2 = position(2) - position(0);
    const dvec2 uv(charts.corner_uv[corner]), d1 = dvec2(charts.corner_uv[corner + 1]) - uv,
                                              d2 = dvec2(charts.corner_uv[corner + 2]) - uv;
    const dvec3 along_u = e1 * d2.y - e2 * d1.y, along_v = e2 * d1.x - e1 * d2.x;
    const double area = length(cross(along_u, along_v));
    const dvec2 shape = dvec2(0.5 * (dot(along_u, along_u) - dot(along_v, along_v)), dot(along_u, along_v)) / area;
    const double size = length(shape);
    if (!(size > 0.0 && size < 1e30)) continue; // false for NaN, too
    const double surface = length(cross(e1, e2));
    sum += surface * logarithm_of(size + std::sqrt(1.0 + size * size)) / size * shape;
    weight += surface;
  }
  return weight > 0.0 ? sum / weight : sum;
}

// Scales charts that the UV map stretches strongly back along that direction. Returns the factors, (charts).
static std::vector<double> unstretch(const Triangles &triangles, const std::vector<std::vector<int32_t>> &corners, int threads,
                                     Charts &charts) {
  std::vector<double> factors(corners.size(), 1.0);
  std::vector<Move> turns(corners.size());
  parallel_blocks(static_cast<int>(corners.size()), threads, 1, [&](int begin, int) {
    const auto chart = static_cast<size_t>(begin);
    const dvec2 stretch = mean_stretch(triangles, charts, corners[chart]);
    const double size = length(stretch);
    int doublings = static_cast<int>(std::lround(size / logarithm_of(2.0)));
    if (doublings < least_doublings) return;
    const double cosine = std::sqrt(std::max(0.0, 0.5 + 0.5 * stretch.x / size));
    const double sine = std::copysign(std::sqrt(std::max(0.0, 0.5 - 0.5 * stretch.x / size)), stretch.y);
    turns[chart] = turned(charts, corners[chart], {cosine, -sine});
    const dvec2 box = turns[chart].size;
    while (doublings > 0 && std::ldexp(box.x, doublings) > longest * box.y) --doublings;
    if (doublings >= least_doublings) factors[chart] = std::ldexp(1.0, doublings);
  });
  if (std::ranges::count(factors, 1.0) == std::ssize(factors)) return factors;
  const auto widened = [&](size_t chart, vec2 uv) {
    return factors[chart] == 1.0 ? uv : vec2(turns[chart].turn(uv) * dvec2(factors[chart], 1.0));
  };
  move_charts(corners, widened, charts);
  return factors;
}

static std::vector<Density> chart_densities(const Triangles &triangles, const Charts &charts) {
  std::vector<Density> result(static_cast<size_t>(charts.chart_count));
  for (int32_t triangle = 0; triangle < triangles.triangle_count; ++triangle) {
    const int32_t chart = charts.triangle_chart[triangle];
    if (chart < 0) continue;
    const auto corner = 3 * static_cast<size_t>(triangle);
    auto uv = [&](size_t i) { return dvec2(charts.corner_uv[corner + i]); };
    auto position = [&](size_t i) { return dvec3(triangles.positions[triangles.corner_vertex[corner + i]]); };
    Density &density = result[chart];
    density.density += std::abs(cross(uv(1) - uv(0), uv(2) - uv(0)));
    density.area += length(cross(position(1) - position(0), position(2) - position(0)));
  }
  for (Density &density : result) density.density = std::sqrt(density.density / std::max(density.area, 1e-300));
  return result;
}

// The density that half of the surface exceeds.
static double median_density(std::vector<Density> densities) {
  std::sort(densities.begin(), densities.end(),
            [](Density a, Density b) { return a.density != b.density ? a.density < b.density : a.area < b.area; });
  double rest = 0.0;
  for (const Density &density : densities) rest += 0.5 * density.area;
  for (const Density &density : densities)
    if ((rest -= density.area) <= 0.0) return density.density;
  return 1.0;
}

// Packs all charts at this many units per uv; returns false if they do not fit.
static bool pack(std::vector<Move> &moves, double units, Spacing spacing) {
  std::vector<stbrp_rect> rects;
  for (size_t i = 0; i < moves.size(); ++i) {
    Move &move = moves[i];
    const double longer = std::max({move.size.x, move.size.y, 1e-12});
    move.scale = std::max(units * move.evening, spacing.smallest / longer);
    const dvec2 box = move.size * move.scale + 2.0 * spacing.gutter;
    if (!(box.x <= grid) || !(box.y <= grid)) return false; // true for NaN, too
    rects.push_back(
        {static_cast<int>(i), static_cast<stbrp_coord>(std::ceil(box.x)), static_cast<stbrp_coord>(std::ceil(box.y)), 0, 0, 0});
  }
  std::vector<stbrp_node> nodes(grid);
  stbrp_context context;
  stbrp_init_target(&context, grid, grid, nodes.data(), grid);
  if (!stbrp_pack_rects(&context, rects.data(), static_cast<int>(rects.size()))) return false;
  for (const stbrp_rect &rect : rects) moves[rect.id].origin = dvec2(rect.x + spacing.gutter, rect.y + spacing.gutter);
  return true;
}

// Packs at the largest scale that fits; returns an empty array if none does.
static std::vector<Move> pack_largest(std::vector<Move> moves, Spacing spacing) {
  double area = 0.0;
  for (const Move &move : moves) area += move.size.x * move.size.y * move.evening * move.evening;
  double fits = 0.0, too_large = area > 0.0 ? grid / std::sqrt(area) : 1.0, units = too_large;
  std::vector<Move> best;
  for (int step = 0; step < 24 && (best.empty() || too_large > 1.02 * fits); ++step) {
    if (pack(moves, units, spacing)) {
      fits = units;
      best = moves;
    } else if (!best.empty()) {
      too_large = units;
    }
    units = best.empty() ? 0.85 * units : 0.5 * (fits + too_large);
  }
  return best;
}

static std::vector<Move> plan(const Charts &charts, const std::vector<std::vector<int32_t>> &corners,
                              const std::vector<Density> &densities, int threads) {
  std::vector<Move> moves(corners.size());
  const double median = median_density(densities);
  parallel_blocks(static_cast<int>(corners.size()), threads, 1, [&](int begin, int) {
    const auto chart = static_cast<size_t>(begin);
    const double density = densities[chart].density;
    moves[chart] = best_turn(charts, corners[chart]);
    moves[chart].evening = std::clamp(density, median / evenness, median * evenness) / density;
  });
  for (const Spacing spacing : spacings)
    if (std::vector<Move> best = pack_largest(moves, spacing); !best.empty()) return best;
  return {};
}

std::optional<Charts> repack_charts(const Triangles &triangles, const Charts &charts, double least_gain, int threads) {
  const auto corners = corners_by_chart(triangles, charts);
  if (corners.empty()) return std::nullopt;
  Charts repacked = charts;
  const std::vector<double> factors = unstretch(triangles, corners, threads, repacked);
  std::vector<Density> densities = chart_densities(triangles, repacked), given = densities;
  for (size_t chart = 0; chart < given.size(); ++chart) given[chart].density /= factors[chart];
  std::vector<Move> moves = plan(repacked, corners, densities, threads);
  if (moves.empty() && least_gain > 0.0) return std::nullopt;
  if (moves.empty())
    throw Error(PDESC_ERROR_UNSUPPORTED,
                "The UV map overlaps itself and its " + std::to_string(corners.size()) +
                    " charts are too many to lay out afresh; unwrap the mesh with fewer islands, or use the "
                    "reference backend.");
  for (size_t chart = 0; chart < moves.size(); ++chart) {
    moves[chart].scale /= grid;
    moves[chart].origin /= static_cast<double>(grid);
    densities[chart].density *= moves[chart].scale;
  }
  if (median_density(densities) < least_gain * median_density(given)) return std::nullopt;
  move_charts(
      corners, [&](size_t chart, vec2 uv) { return moves[chart](uv); }, repacked);
  return repacked;
}

} // namespace paradesc
