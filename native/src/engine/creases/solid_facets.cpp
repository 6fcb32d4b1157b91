// Parts of facets in the ball → the tensor, computed from the parts' sides only, however many triangles there are.
#include <algorithm>
#include <cmath>

#include "engine/creases/solid.h"
#include "support/angle.h"

namespace paradesc {

namespace {

// Returns whether the place lies inside the facet: counts the sides that a ray along the first axis crosses.
bool is_in(dvec2 place, const Facets &facets, const Facet &facet) {
  bool inside = false;
  for (int32_t s = facet.side_begin; s < facet.side_end; ++s) {
    const FacetSide &side = facets.side[s];
    const dvec2 a = facet.axes.of(side.begin - facet.middle) - place, b = facet.axes.of(side.end - facet.middle) - place;
    if ((a.y > 0) != (b.y > 0) && (cross(a, b) > 0) == (b.y > a.y)) inside = !inside;
  }
  return inside;
}

} // namespace

double SolidMeasure::height_over(const Facet &facet, const FacetPart &part) const {
  const std::span<const int32_t> own = flood_.own_facets();
  if (std::find(own.begin(), own.end(), part.facet) != own.end()) return 0;
  const double height = glm::dot(facet.normal, facet.middle - center_.position);
  // A center that is off the line between two others by needles alone lies on the surface behind the needles.
  if (std::abs(height) < rounding_)
    for (const int32_t index : flood_.sides(part)) {
      const FacetSide &side = surface_.facets.side[index];
      if (segment_distance(side.begin - center_.position, side.end - center_.position) < rounding_) return 0;
    }
  return height;
}

// Cuts a plane by the ball → region_. The flood says which corners are inside, so that it and both sides of a corner agree: where
// one side leaves the ball, another one enters it.
void SolidMeasure::cut(const FacetPart &part, double height) {
  const Facet &facet = surface_.facets.facet[part.facet];
  const double rim2 = radius_ * radius_ - height * height;
  region_.radius = std::sqrt(rim2);
  region_.segments.clear();
  double turn = 0; // from where sides leave the ball to where they enter it
  for (const int32_t index : flood_.sides(part)) {
    const FacetSide &side = surface_.facets.side[index];
    const dvec2 a = facet.axes.of(side.begin - center_.position), b = facet.axes.of(side.end - center_.position), way = b - a;
    const bool begins = flood_.is_inside(side.begin), ends = flood_.is_inside(side.end);
    if (begins && ends) {
      region_.segments.emplace_back(a, b);
      continue;
    }
    const double length2 = glm::dot(way, way), foot = -glm::dot(a, way) / length2, across = cross(a, way);
    const double half2 = (rim2 - across * across / length2) / length2;
    const double half = std::sqrt(std::max(half2, 0.0));
    const double from_here = begins ? 0 : std::clamp(foot - half, 0.0, 1.0), to = ends ? 1 : std::clamp(foot + half, 0.0, 1.0);
    if (!begins && !ends && !(from_here < to)) continue; // the side only touches the rim
    const dvec2 begin = a + from_here * way, end = a + to * way;
    region_.segments.emplace_back(begin, end);
    if (!begins) turn += angle_of(begin.y, begin.x);
    if (!ends) turn -= angle_of(end.y, end.x);
  }
  region_.arcs = arcs_of(part, turn);
}

// Returns the angle of the rim's arcs within the part of the facet. If the rim cuts sides, it is, up to whole turns, the sum of
// angles from each exit of the ball to the next entry. Without arcs between them, the rim is entirely outside the part, or
// entirely inside: sides around the part have a positive area, and sides of holes in it a negative one. If sides only touch the
// rim, the facet says whether the disc's side of them belongs to it.
double SolidMeasure::arcs_of(const FacetPart &part, double turn) const {
  const double arcs = turn - 2 * pi * std::floor(turn / (2 * pi));
  constexpr double rounding = 1e-9, within = 1 - 1e-3;
  if (std::min(arcs, 2 * pi - arcs) > rounding) return arcs;
  double area = 0;
  for (const auto &[begin, end] : region_.segments) area += 0.5 * cross(begin, end);
  if (std::abs(area) > rounding * radius_ * radius_) return area > 0 ? 0 : 2 * pi;
  const Facet &facet = surface_.facets.facet[part.facet];
  dvec2 place = facet.axes.of(center_.position - facet.middle);
  if (part.begin < part.end) {
    const FacetSide &side = surface_.facets.side[flood_.sides(part).front()];
    const dvec2 begin = facet.axes.of(side.begin - center_.position), way = facet.axes.of(side.end - side.begin);
    place += within * (begin + way * std::clamp(-glm::dot(begin, way) / glm::dot(way, way), 0.0, 1.0));
  }
  return is_in(place, surface_.facets, facet) ? 2 * pi : 0;
}

void SolidMeasure::add_part(Sums &sums, const FacetPart &part) {
  const Facet &facet = surface_.facets.facet[part.facet];
  const double height = height_over(facet, part);
  if (!(std::abs(height) < radius_)) return;
  for (const int32_t index : flood_.sides(part)) {
    const FacetSide &side = surface_.facets.side[index];
    if (side.is_crease || !(std::abs(side.bend) > LEAST_BEND)) continue;
    const dvec3 begin = side.begin - center_.position, end = side.end - center_.position;
    add_bend(sums.smooth, facet.normal, end - begin, side.bend * kernel_on_segment(begin, end, radius_));
  }
  const bool is_bent = turns(facet.gradient, radius_);
  if (height == 0 && !is_bent) return;
  cut(part, height);
  if (height != 0) add_plane(sums.hard, facet.normal, height, seen_and_filled(region_, std::abs(height), radius_));
  if (is_bent) add_turn(sums.smooth, facet.normal, facet.axes, facet.gradient, kernel_over(region_, height, radius_));
}

} // namespace paradesc
