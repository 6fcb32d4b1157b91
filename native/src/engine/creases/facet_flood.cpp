// Floods across sides and edges that meet the ball. A facet of which the ball may cut several parts is visited by its triangles.
#include "engine/creases/facet_flood.h"

#include <utility>

#include "mesh/ball_flood.h"
#include "support/cancel.h"

namespace paradesc {

FacetFlood::FacetFlood(const Triangles &triangles, const HalfEdges &half_edges, const Facets &facets)
    : triangles_(triangles), half_edges_(half_edges), facets_(facets), mark_(static_cast<size_t>(triangles.triangle_count), 0),
      met_(facets.facet.size()), side_mark_(facets.side.size(), 0) {}

void FacetFlood::run(dvec3 center, int32_t point, int32_t triangle, double radius) {
  center_ = center;
  radius_ = radius;
  ++places_;
  reached_.clear();
  inside_.clear();
  sides_.clear();
  parts_.clear();
  own_facets_.clear();
  if (point < 0) start(triangle);
  const int32_t first = point < 0 ? -1 : half_edges_.point_half_edge[point];
  for (int32_t corner = first; corner >= 0;) {
    start(corner / 3);
    corner = half_edges_.twin[previous_corner(corner)];
    if (corner == first) break;
  }
  own_triangles_ = reached_.size();
  for (size_t triangles = 0, sides = 0; triangles < reached_.size() || sides < sides_.size();) {
    checkpoint_at(triangles + sides, 4096);
    if (sides < sides_.size()) {
      cross(facets_.side[sides_[sides++]]);
      continue;
    }
    cross_edges(triangles++);
  }
}

bool FacetFlood::has_reached(int32_t half_edge) const {
  const int32_t triangle = half_edge / 3, facet = facets_.of_triangle[triangle];
  return mark_[triangle] == places_ || (facet >= 0 && met_[facet].place == places_ && met_[facet].cut == Cut::one);
}

void FacetFlood::start(int32_t triangle) {
  if (facets_.of_triangle[triangle] >= 0) own_facets_.push_back(facets_.of_triangle[triangle]);
  reach(3 * triangle, is_inside(3 * triangle), is_inside(3 * triangle + 1));
}

// Reaches the triangle of a half-edge, of whose ends it is known whether they lie in the ball.
void FacetFlood::reach(int32_t half_edge, bool begin_inside, bool end_inside) {
  const int32_t triangle = half_edge / 3, k = half_edge % 3;
  if (mark_[triangle] == places_) return;
  const int32_t facet = facets_.of_triangle[triangle];
  if (facet >= 0) {
    if (!is_one(facet)) reach_part(triangle);
    return;
  }
  mark_[triangle] = places_;
  reached_.push_back(triangle);
  const bool apex_inside = is_inside(previous_corner(half_edge));
  inside_.push_back(static_cast<uint8_t>(begin_inside << k | end_inside << (k + 1) % 3 | apex_inside << (k + 2) % 3));
}

// Returns whether the ball can cut only one part out of the facet; if so, that part is reached.
bool FacetFlood::is_one(int32_t index) {
  Met &met = met_[index];
  if (met.place == places_) return met.cut == Cut::one;
  met = {places_, Cut::one};
  const Facet &facet = facets_.facet[index];
  const auto first = static_cast<int32_t>(sides_.size());
  int entries = 0; // places where chains of sides enter the ball
  for (int32_t s = facet.side_begin; s < facet.side_end; ++s) {
    const FacetSide &side = facets_.side[s];
    if (!meets(side.begin, side.end)) continue;
    sides_.push_back(s);
    if (!is_inside(side.begin)) ++entries;
  }
  if (facet.is_convex || entries <= 1) {
    parts_.push_back({index, first, static_cast<int32_t>(sides_.size())});
    return true;
  }
  met.cut = Cut::several;
  sides_.resize(static_cast<size_t>(first));
  return false;
}

// Reaches all of the part that contains this triangle.
void FacetFlood::reach_part(int32_t triangle) {
  const int32_t facet = facets_.of_triangle[triangle];
  const auto first = static_cast<int32_t>(sides_.size());
  mark_[triangle] = places_;
  waiting_.assign(1, triangle);
  while (!waiting_.empty()) {
    const int32_t begin = 3 * waiting_.back();
    waiting_.pop_back();
    for (int32_t edge = begin; edge < begin + 3; ++edge) {
      const int32_t side = facets_.side_of[edge], behind = half_edges_.twin[edge] / 3;
      if (side < 0 && mark_[behind] == places_) continue;
      if (!meets(edge)) continue;
      if (side >= 0) {
        if (std::exchange(side_mark_[side], places_) != places_) sides_.push_back(side);
        continue;
      }
      mark_[behind] = places_;
      waiting_.push_back(behind);
    }
  }
  parts_.push_back({facet, first, static_cast<int32_t>(sides_.size())});
}

void FacetFlood::cross_edges(size_t reached) {
  const int32_t begin = 3 * reached_[reached];
  const uint32_t inside = inside_[reached];
  for (int32_t k = 0; k < 3; ++k) cross(begin + k, (inside >> k & 1) != 0, (inside >> (k + 1) % 3 & 1) != 0);
}

void FacetFlood::cross(int32_t half_edge, bool begin_inside, bool end_inside) {
  const int32_t twin = half_edges_.twin[half_edge];
  if (twin < 0 || mark_[twin / 3] == places_) return;
  const int32_t facet = facets_.of_triangle[twin / 3];
  if (facet >= 0 && met_[facet].place == places_ && met_[facet].cut == Cut::one) return;
  if (begin_inside || end_inside || meets(half_edge)) reach(twin, end_inside, begin_inside);
}

void FacetFlood::cross(const FacetSide &side) {
  const std::span<const int32_t> edges = facets_.half_edges(side);
  if (half_edges_.twin[edges.front()] < 0 || (side.neighbor >= 0 && is_one(side.neighbor))) return;
  for (const int32_t edge : edges) cross(edge, is_inside(edge), is_inside(next_corner(edge)));
}

bool FacetFlood::is_inside(dvec3 place) const {
  const dvec3 from_center = place - center_;
  return glm::dot(from_center, from_center) < radius_ * radius_;
}

bool FacetFlood::meets(dvec3 begin, dvec3 end) const {
  return is_inside(begin) || is_inside(end) || segment_distance(begin - center_, end - center_) < radius_;
}

bool FacetFlood::meets(int32_t half_edge) const {
  return meets(dvec3(triangles_.position(half_edge)), dvec3(triangles_.position(next_corner(half_edge))));
}

} // namespace paradesc
