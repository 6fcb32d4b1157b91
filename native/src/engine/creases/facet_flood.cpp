// Floods across sides and edges that meet the ball. A facet of which the ball may cut several parts is visited by its triangles.
#include "engine/creases/facet_flood.h"

#include <algorithm>
#include <utility>

#include "support/cancel.h"

namespace paradesc {

FacetFlood::FacetFlood(const CreasedSurface &surface, const FaceRows &rows)
    : triangles_(surface.triangles), half_edges_(surface.half_edges), facets_(surface.facets), all_rows_(rows),
      mark_(static_cast<size_t>(surface.triangles.triangle_count), Mark{0}), met_(facets_.facet.size()),
      side_mark_(facets_.side.size(), 0) {}

void FacetFlood::run(dvec3 center, int32_t point, int32_t triangle, double radius) {
  center_ = center;
  radius_ = radius;
  ++places_;
  own_mark_ = static_cast<Mark>(1 + places_ % 255);
  if (own_mark_ == Mark{1}) std::ranges::fill(mark_, Mark{0});
  reached_ = 0;
  sides_.clear();
  parts_.clear();
  own_facets_.clear();
  large_.clear();
  if (point < 0)
    start(triangle);
  else
    for_each_corner_around(half_edges_, point, [&](int32_t corner) { start(corner / 3); });
  own_triangles_ = reached_;
  for (size_t triangles = 0, sides = 0; triangles < reached_ || sides < sides_.size();) {
    checkpoint_at(triangles + sides, 4096);
    if (sides < sides_.size())
      cross(facets_.side[sides_[sides++]]);
    else
      go_on(triangles++);
  }
  if (reached_ > 0) std::fill_n(rows_.begin() + static_cast<ptrdiff_t>(reached_), FACE_LANES, rows_[0]);
}

bool FacetFlood::has_reached(int32_t half_edge) const {
  const int32_t triangle = half_edge / 3, facet = facets_.of_triangle[triangle];
  return mark_[triangle] == own_mark_ || (facet >= 0 && met_[facet].place == places_ && met_[facet].cut == Cut::one);
}

void FacetFlood::start(int32_t triangle) {
  if (facets_.of_triangle[triangle] >= 0) own_facets_.push_back(facets_.of_triangle[triangle]);
  reach(3 * triangle, is_inside(3 * triangle), is_inside(next_corner(3 * triangle)));
}

// Reaches the triangle of a half-edge if it is new.
void FacetFlood::reach(int32_t half_edge, bool begin_inside, bool end_inside) {
  const int32_t triangle = half_edge / 3, facet = facets_.of_triangle[triangle];
  if (mark_[triangle] == own_mark_) return;
  if (facet < 0)
    append(half_edge, begin_inside, end_inside, true);
  else if (!is_one(facet))
    reach_part(triangle);
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
  mark_[triangle] = own_mark_;
  waiting_.assign(1, triangle);
  while (!waiting_.empty()) {
    const int32_t begin = 3 * waiting_.back();
    waiting_.pop_back();
    for (int32_t edge = begin; edge < begin + 3; ++edge) {
      const int32_t side = facets_.side_of[edge], behind = half_edges_.twin[edge] / 3;
      if (side < 0 && mark_[behind] == own_mark_) continue;
      if (!meets(edge)) continue;
      if (side >= 0) {
        if (std::exchange(side_mark_[side], places_) != places_) sides_.push_back(side);
        continue;
      }
      mark_[behind] = own_mark_;
      waiting_.push_back(behind);
    }
  }
  parts_.push_back({facet, first, static_cast<int32_t>(sides_.size())});
}

// Crosses the edges of a triangle. Without a start there, the flood has come across one of them.
inline void FacetFlood::go_on(size_t reached) {
  const auto [half_edge, inside] = entered_[reached];
  const int32_t triangle = half_edge / 3, k = half_edge % 3, next = k == 2 ? 0 : k + 1, apex = k == 0 ? 2 : k - 1;
  const FaceRow &row = all_rows_.of(triangle);
  rows_[reached] = &row;
  if (row.state == FACE_LARGE) [[unlikely]]
    large_.push_back(triangle);
  const float(&place)[3] = row.corner[apex].place;
  const bool begin_inside = (inside & 1) != 0, end_inside = (inside & 2) != 0,
             apex_inside = is_inside({place[0], place[1], place[2]});
  if (reached < own_triangles_) [[unlikely]]
    cross(row, k, begin_inside, end_inside);
  cross(row, next, end_inside, apex_inside);
  cross(row, apex, apex_inside, begin_inside);
}

// Most triangles take the last line. Whether they are new is unpredictable, so it does not branch.
[[gnu::always_inline]] inline void FacetFlood::cross(const FaceRow &row, int32_t k, bool begin_inside, bool end_inside) {
  const int32_t twin = row.twin[k];
  if (!(begin_inside | end_inside)) [[unlikely]] {
    const auto place = [&](int32_t i) { return dvec3(row.corner[i].place[0], row.corner[i].place[1], row.corner[i].place[2]); };
    if (twin == NO_TWIN || !meets(place(k), place(k == 2 ? 0 : k + 1))) return;
  }
  if (twin < 0) {
    if (twin != NO_TWIN) reach(~twin, end_inside, begin_inside);
    return;
  }
  append(twin, end_inside, begin_inside, mark_[twin / 3] != own_mark_);
}

[[gnu::always_inline]] inline void FacetFlood::append(int32_t half_edge, bool begin_inside, bool end_inside, bool is_new) {
  if (reached_ == entered_.size()) [[unlikely]] {
    entered_.resize(2 * reached_ + 64);
    rows_.resize(entered_.size() + FACE_LANES);
  }
  entered_[reached_] = {half_edge, begin_inside | end_inside << 1};
  mark_[half_edge / 3] = own_mark_;
  all_rows_.prefetch(half_edge / 3);
  reached_ += is_new;
}

void FacetFlood::cross(const FacetSide &side) {
  const std::span<const int32_t> edges = facets_.half_edges(side);
  if (half_edges_.twin[edges.front()] < 0 || (side.neighbor >= 0 && is_one(side.neighbor))) return;
  for (const int32_t edge : edges)
    if (meets(edge)) reach(half_edges_.twin[edge], is_inside(next_corner(edge)), is_inside(edge));
}

bool FacetFlood::is_inside(dvec3 place) const {
  const dvec3 from_center = place - center_;
  return glm::dot(from_center, from_center) < radius_ * radius_;
}

// Compares squares: divisions and roots would take longer than the rest.
bool FacetFlood::meets(dvec3 begin, dvec3 end) const {
  const dvec3 a = begin - center_, b = end - center_, way = b - a;
  const double square = radius_ * radius_, beyond = glm::dot(a, a) - square;
  if (beyond < 0 || glm::dot(b, b) < square) return true;
  const double along = -glm::dot(a, way), length2 = glm::dot(way, way);
  return along > 0 && along < length2 && beyond * length2 < along * along;
}

bool FacetFlood::meets(int32_t half_edge) const {
  return meets(dvec3(triangles_.position(half_edge)), dvec3(triangles_.position(next_corner(half_edge))));
}

} // namespace paradesc
