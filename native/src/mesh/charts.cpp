// Half-edges + corner UVs → charts, the wedges of each point, and the border half-edges with their twins.
#include "mesh/charts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "support/angle.h"
#include "support/parallel.h"

namespace paradesc {
namespace {

constexpr double no_uv_area = 1e-14;         // twice the area; a texel of the largest buffer has 1.5e-8
constexpr double no_relative_uv_area = 1e-7; // twice the area against the square of the longest side: the digits of a float
constexpr double needle = 1e-2;              // the same ratio for a triangle that texel centers hit only by chance ...
constexpr double needle_part = 1e-7;         // ... if its share of the map is at most this: a tenth of a texel of 1024²
constexpr double same_uv = 1e-6;
constexpr int block = 4096; // for one thread at a time

dvec2 uv_at(const Triangles &triangles, int corner) { return dvec2(triangles.corner_uv[corner]); }

// Twice the signed area of a triangle in the UV map; 0 if it is too small to carry texels. Needles up to largest_needle count as
// too small: a texel that hits one would stand for thousands of times the needle's surface.
double uv_area(const Triangles &triangles, int triangle, double largest_needle) {
  const dvec2 a = uv_at(triangles, 3 * triangle);
  const dvec2 ab = uv_at(triangles, 3 * triangle + 1) - a;
  const dvec2 ac = uv_at(triangles, 3 * triangle + 2) - a;
  const double area = cross(ab, ac);
  const double longest = std::max({glm::dot(ab, ab), glm::dot(ac, ac), glm::dot(ac - ab, ac - ab)});
  const double least = std::max({no_uv_area, no_relative_uv_area * longest, std::min(largest_needle, needle * longest)});
  return std::abs(area) <= least ? 0.0 : area;
}

double uv_angle(const Triangles &triangles, int corner) {
  const dvec2 a = uv_at(triangles, next_corner(corner)) - uv_at(triangles, corner);
  const dvec2 b = uv_at(triangles, previous_corner(corner)) - uv_at(triangles, corner);
  return angle_of(std::abs(cross(a, b)), glm::dot(a, b));
}

bool agree(const Triangles &triangles, int corner, int other) {
  const dvec2 difference = glm::abs(uv_at(triangles, corner) - uv_at(triangles, other));
  return std::max(difference.x, difference.y) <= same_uv;
}

struct UvAreas {
  std::vector<double> area;      // (triangle_count) twice and signed; 0: carries no texel
  std::vector<uint8_t> left_out; // (triangle_count) 1: not on the surface, or no area in the UV map
};

// (triangle_count) twice the signed UV area; 0: the triangle is left out, or too small to carry texels.
std::vector<double> uv_areas(const Triangles &triangles, const HalfEdges &half_edges, double largest_needle, int threads) {
  std::vector<double> area(triangles.triangle_count, 0.0);
  parallel_blocks(triangles.triangle_count, threads, block, [&](int begin, int end) {
    for (int triangle = begin; triangle < end; ++triangle)
      if (half_edges.corner_point[3 * triangle] >= 0) area[triangle] = uv_area(triangles, triangle, largest_needle);
  });
  return area;
}

UvAreas measure(const Triangles &triangles, const HalfEdges &half_edges, int threads, Charts &charts) {
  UvAreas areas;
  areas.left_out.assign(triangles.triangle_count, 1);
  double whole = 0.0;
  for (const double area : uv_areas(triangles, half_edges, 0.0, threads)) whole += std::abs(area);
  areas.area = uv_areas(triangles, half_edges, needle_part * whole, threads);
  std::array<double, 2> total = {0.0, 0.0};
  std::array<int, 2> count = {0, 0};
  for (int triangle = 0; triangle < triangles.triangle_count; ++triangle) {
    checkpoint_at(triangle);
    if (half_edges.corner_point[3 * triangle] < 0) continue;
    const double area = areas.area[triangle];
    if (area == 0.0) {
      ++charts.zero_uv_area_triangles;
      continue;
    }
    areas.left_out[triangle] = 0;
    total[area < 0] += std::abs(area);
    ++count[area < 0];
  }
  charts.flipped_triangles = total[1] <= total[0] ? count[1] : count[0];
  return areas;
}

// Finds the half-edges across which a chart continues: both triangles have area, lie on the same side of the fold and meet in UV.
std::vector<int32_t> link_within_charts(const Triangles &triangles, const HalfEdges &half_edges, const UvAreas &areas,
                                        std::span<const int32_t> triangle_piece, int threads) {
  std::vector<int32_t> link(half_edges.twin.size(), -1);
  parallel_blocks(3 * triangles.triangle_count, threads, 3 * block, [&](int begin, int end) {
    for (int h = begin; h < end; ++h) {
      const int32_t twin = half_edges.twin[h];
      if (twin < 0 || areas.area[h / 3] * areas.area[twin / 3] <= 0.0) continue;
      if (!triangle_piece.empty() && triangle_piece[h / 3] != triangle_piece[twin / 3]) continue;
      if (agree(triangles, h, next_corner(twin)) && agree(triangles, next_corner(h), twin)) link[h] = twin;
    }
  });
  return link;
}

vec2 uv_centroid(const Triangles &triangles, int triangle) {
  const dvec2 sum = uv_at(triangles, 3 * triangle) + uv_at(triangles, 3 * triangle + 1) + uv_at(triangles, 3 * triangle + 2);
  return vec2(sum / 3.0);
}

// Calls visit(corner, angle) in order for every corner that has a wedge. All threads compute the angles, one run of corners at a
// time.
template <class Angle, class Visit>
void for_each_corner(const Triangles &triangles, const std::vector<int32_t> &corner_wedge, int threads, const Angle &angle_of,
                     const Visit &visit) {
  constexpr int run = 64 * block;
  const int count = 3 * triangles.triangle_count;
  std::vector<double> angles(std::min(run, count));
  for (int first = 0; first < count; first += std::min(run, count - first)) {
    const int length = std::min(run, count - first);
    parallel_blocks(length, threads, block, [&](int begin, int end) {
      for (int i = begin; i < end; ++i)
        if (corner_wedge[first + i] >= 0) angles[i] = angle_of(triangles, first + i);
    });
    for (int i = 0; i < length; ++i) {
      checkpoint_at(i);
      if (corner_wedge[first + i] >= 0) visit(first + i, angles[i]);
    }
  }
}

void make_wedges(const Triangles &triangles, const HalfEdges &half_edges, const Fans &fans, int threads, Charts &charts) {
  charts.corner_wedge = fans.corner_fan;
  charts.wedges.resize(fans.count);
  std::vector<double> widest(fans.count, -1.0);
  for_each_corner(triangles, fans.corner_fan, threads, uv_angle, [&](int corner, double angle) {
    const int32_t index = fans.corner_fan[corner];
    Wedge &wedge = charts.wedges[index];
    if (widest[index] < 0)
      wedge = {half_edges.corner_point[corner], charts.triangle_chart[corner / 3], triangles.corner_uv[corner], {}, 0.0};
    wedge.angle += angle;
    if (angle <= widest[index]) return;
    widest[index] = angle;
    wedge.inside = uv_centroid(triangles, corner / 3);
  });
  for (int32_t index = 0; index < fans.count; ++index) {
    checkpoint_at(index);
    int32_t &chosen = charts.point_wedge[charts.wedges[index].point];
    if (chosen < 0 || charts.wedges[index].angle > charts.wedges[chosen].angle) chosen = index;
  }
}

void find_borders(const HalfEdges &half_edges, const std::vector<int32_t> &link, Charts &charts) {
  for (int32_t h = 0; h < static_cast<int32_t>(link.size()); ++h) {
    checkpoint_at(h);
    const int32_t chart = charts.triangle_chart[h / 3];
    if (chart < 0 || link[h] >= 0) continue;
    const int32_t twin = half_edges.twin[h];
    const BorderKind kind = twin < 0                               ? BorderKind::boundary
                            : charts.triangle_chart[twin / 3] >= 0 ? BorderKind::seam
                                                                   : BorderKind::unlinked;
    charts.half_edge_border[h] = static_cast<int32_t>(charts.borders.size());
    charts.borders.push_back({h, -1, chart, kind});
  }
  for (Border &border : charts.borders) {
    if (border.kind == BorderKind::unlinked) ++charts.unlinked_edges;
    if (border.kind != BorderKind::seam) continue;
    const int32_t twin = half_edges.twin[border.half_edge];
    border.twin = charts.half_edge_border[twin];
    if (twin < border.half_edge) continue; // an edge counts once
    ++charts.seam_edges;
    charts.self_seam_edges += charts.triangle_chart[twin / 3] == border.chart;
  }
}

} // namespace

Charts build_charts(const Triangles &triangles, const HalfEdges &half_edges, std::span<const int32_t> triangle_piece,
                    int threads) {
  Charts charts;
  charts.triangle_chart.assign(triangles.triangle_count, -1);
  charts.corner_wedge.assign(half_edges.twin.size(), -1);
  checkpoint();
  charts.half_edge_border.assign(half_edges.twin.size(), -1);
  charts.point_wedge.assign(half_edges.point_count, -1);
  charts.corner_uv = triangles.corner_uv;
  if (charts.corner_uv.empty()) return charts;

  const UvAreas areas = measure(triangles, half_edges, threads, charts);
  const std::vector<int32_t> link = link_within_charts(triangles, half_edges, areas, triangle_piece, threads);
  checkpoint();
  Pieces pieces;
  Fans fans;
  parallel_blocks(2, threads, 1, [&](int part, int) {
    if (part == 0)
      pieces = trace_pieces(link, areas.left_out);
    else
      fans = trace_fans(link, areas.left_out);
  });
  checkpoint();
  charts.chart_count = pieces.count;
  charts.triangle_chart = std::move(pieces.triangle_piece);
  make_wedges(triangles, half_edges, fans, threads, charts);
  find_borders(half_edges, link, charts);
  return charts;
}

std::pair<int, int> border_ends(const Charts &charts, const Border &border) {
  const int a = border.half_edge, b = next_corner(a), c = next_corner(b);
  const dvec2 origin(charts.corner_uv[a]);
  const bool left = cross(dvec2(charts.corner_uv[b]) - origin, dvec2(charts.corner_uv[c]) - origin) > 0.0;
  return left ? std::pair(a, b) : std::pair(b, a);
}

} // namespace paradesc
