// Half-edges + corner UVs → charts, the places (sites) of each point in the UV map, and border half-edges with their twins.
#include "mesh/charts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace paradesc {
namespace {

constexpr double no_uv_area = 1e-14;         // twice the area; a texel of the largest buffer has 1.5e-8
constexpr double no_relative_uv_area = 1e-7; // twice the area against the square of the longest side: the digits of a float
constexpr double needle = 1e-2;              // the same of a triangle that no texel hits but by chance ...
constexpr double needle_part = 1e-7;         // ... if it is no larger than this part of the map: a tenth of a texel of 1024²
constexpr double same_uv = 1e-6;

size_t at(int32_t index) { return static_cast<size_t>(index); }

dvec2 uv_at(const Triangles &triangles, int corner) { return dvec2(triangles.corner_uv[at(corner)]); }

// Twice the signed area of a triangle in the UV map; 0 where it is too small to stand on. Needles count as too small up to
// largest_needle: a texel that one catches would stand for thousands of times the needle's surface.
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
  return std::atan2(std::abs(cross(a, b)), glm::dot(a, b));
}

bool agree(const Triangles &triangles, int corner, int other) {
  const dvec2 difference = glm::abs(uv_at(triangles, corner) - uv_at(triangles, other));
  return std::max(difference.x, difference.y) <= same_uv;
}

struct UvAreas {
  std::vector<double> area;      // (triangle_count) twice and signed; 0: carries no texel
  std::vector<uint8_t> left_out; // (triangle_count) 1: not on the surface, or no area in the UV map
};

UvAreas measure(const Triangles &triangles, const HalfEdges &half_edges, Charts &charts) {
  UvAreas areas;
  areas.area.assign(at(triangles.triangle_count), 0.0);
  areas.left_out.assign(at(triangles.triangle_count), 1);
  double whole = 0.0;
  for (int triangle = 0; triangle < triangles.triangle_count; ++triangle)
    if (half_edges.corner_point[3 * at(triangle)] >= 0) whole += std::abs(uv_area(triangles, triangle, 0.0));
  std::array<double, 2> total = {0.0, 0.0};
  std::array<int, 2> count = {0, 0};
  for (int triangle = 0; triangle < triangles.triangle_count; ++triangle) {
    if (half_edges.corner_point[3 * at(triangle)] < 0) continue;
    const double area = uv_area(triangles, triangle, needle_part * whole);
    if (area == 0.0) {
      ++charts.zero_uv_area_triangles;
      continue;
    }
    areas.area[at(triangle)] = area;
    areas.left_out[at(triangle)] = 0;
    total[area < 0] += std::abs(area);
    ++count[area < 0];
  }
  charts.flipped_triangles = total[1] <= total[0] ? count[1] : count[0];
  return areas;
}

// Half-edges over which a chart goes on: both sides have area, lie on the same side of the fold and meet in the UV map.
std::vector<int32_t> link_within_charts(const Triangles &triangles, const HalfEdges &half_edges, const UvAreas &areas,
                                        std::span<const int32_t> triangle_piece) {
  std::vector<int32_t> link(half_edges.twin.size(), -1);
  for (int h = 0; h < 3 * triangles.triangle_count; ++h) {
    const int32_t twin = half_edges.twin[at(h)];
    if (twin < 0 || areas.area[at(h / 3)] * areas.area[at(twin / 3)] <= 0.0) continue;
    if (!triangle_piece.empty() && triangle_piece[at(h / 3)] != triangle_piece[at(twin / 3)]) continue;
    if (agree(triangles, h, next_corner(twin)) && agree(triangles, next_corner(h), twin)) link[at(h)] = twin;
  }
  return link;
}

vec2 uv_centroid(const Triangles &triangles, int triangle) {
  const dvec2 sum = uv_at(triangles, 3 * triangle) + uv_at(triangles, 3 * triangle + 1) + uv_at(triangles, 3 * triangle + 2);
  return vec2(sum / 3.0);
}

void place_points(const Triangles &triangles, const HalfEdges &half_edges, const Fans &fans, Charts &charts) {
  charts.corner_site = fans.corner_fan;
  charts.sites.resize(at(fans.count));
  std::vector<double> widest(at(fans.count), -1.0);
  for (int corner = 0; corner < 3 * triangles.triangle_count; ++corner) {
    const int32_t index = fans.corner_fan[at(corner)];
    if (index < 0) continue;
    Site &site = charts.sites[at(index)];
    if (widest[at(index)] < 0)
      site = {
          half_edges.corner_point[at(corner)], charts.triangle_chart[at(corner / 3)], triangles.corner_uv[at(corner)], {}, 0.0};
    const double angle = uv_angle(triangles, corner);
    if (angle <= widest[at(index)]) continue;
    widest[at(index)] = angle;
    site.inside = uv_centroid(triangles, corner / 3);
  }
  weigh_sites(triangles, charts);
}

void find_borders(const HalfEdges &half_edges, const std::vector<int32_t> &link, Charts &charts) {
  for (int32_t h = 0; h < static_cast<int32_t>(link.size()); ++h) {
    const int32_t chart = charts.triangle_chart[at(h / 3)];
    if (chart < 0 || link[at(h)] >= 0) continue;
    const int32_t twin = half_edges.twin[at(h)];
    const BorderKind kind = twin < 0                                   ? BorderKind::boundary
                            : charts.triangle_chart[at(twin / 3)] >= 0 ? BorderKind::seam
                                                                       : BorderKind::unlinked;
    charts.half_edge_border[at(h)] = static_cast<int32_t>(charts.borders.size());
    charts.borders.push_back({h, -1, chart, kind});
  }
  for (Border &border : charts.borders) {
    if (border.kind == BorderKind::unlinked) ++charts.unlinked_edges;
    if (border.kind != BorderKind::seam) continue;
    const int32_t twin = half_edges.twin[at(border.half_edge)];
    border.twin = charts.half_edge_border[at(twin)];
    if (twin < border.half_edge) continue; // an edge counts once
    ++charts.seam_edges;
    charts.self_seam_edges += charts.triangle_chart[at(twin / 3)] == border.chart;
  }
}

} // namespace

void weigh_sites(const Triangles &triangles, Charts &charts) {
  for (Site &site : charts.sites) site.angle = 0.0;
  for (size_t corner = 0; corner < charts.corner_site.size(); ++corner)
    if (const int32_t index = charts.corner_site[corner]; index >= 0)
      charts.sites[at(index)].angle += surface_angle(triangles, static_cast<int>(corner));
  std::fill(charts.point_site.begin(), charts.point_site.end(), -1);
  for (size_t index = 0; index < charts.sites.size(); ++index) {
    int32_t &chosen = charts.point_site[at(charts.sites[index].point)];
    if (chosen < 0 || charts.sites[index].angle > charts.sites[at(chosen)].angle) chosen = static_cast<int32_t>(index);
  }
}

Charts build_charts(const Triangles &triangles, const HalfEdges &half_edges, std::span<const int32_t> triangle_piece) {
  Charts charts;
  charts.triangle_chart.assign(at(triangles.triangle_count), -1);
  charts.corner_site.assign(half_edges.twin.size(), -1);
  charts.half_edge_border.assign(half_edges.twin.size(), -1);
  charts.point_site.assign(at(half_edges.point_count), -1);
  if (triangles.corner_uv.empty()) return charts;

  const UvAreas areas = measure(triangles, half_edges, charts);
  const std::vector<int32_t> link = link_within_charts(triangles, half_edges, areas, triangle_piece);
  Pieces pieces = trace_pieces(link, areas.left_out);
  charts.chart_count = pieces.count;
  charts.triangle_chart = std::move(pieces.triangle_piece);
  place_points(triangles, half_edges, trace_fans(link, areas.left_out), charts);
  find_borders(half_edges, link, charts);
  return charts;
}

} // namespace paradesc
