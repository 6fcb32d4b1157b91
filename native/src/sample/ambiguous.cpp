// Areas are compared first, by patches where triangles are many and small: most ambiguous centers have the area that they should.
#include "sample/ambiguous.h"

#include <algorithm>
#include <cmath>

#include "bake/distortion.h"
#include "sample/centers.h"
#include "sample/patch_areas.h"

namespace paradesc {

void AmbiguousCenters::push_back(int32_t center, int32_t point, double area) {
  centers.push_back(center);
  points.push_back(point);
  areas.push_back(area);
}

AmbiguousCenters AmbiguousCenters::part(size_t first, size_t last) const {
  const auto cut = [&](const auto &all) {
    return std::decay_t<decltype(all)>(all.begin() + static_cast<ptrdiff_t>(first), all.begin() + static_cast<ptrdiff_t>(last));
  };
  return {cut(centers), cut(points), cut(areas)};
}

void AmbiguousCenters::filter(const std::function<bool(size_t)> &keep) {
  size_t kept = 0;
  for (size_t i = 0; i < centers.size(); ++i) {
    if (!keep(i)) continue;
    centers[kept] = centers[i];
    points[kept] = points[i];
    areas[kept++] = areas[i];
  }
  centers.resize(kept);
  points.resize(kept);
  areas.resize(kept);
}

// Relative tolerance on a disk's area: samples of a folded surface miss some per cent of it, and few samples miss more.
static double area_tolerance(int samples) {
  return std::max(0.06, 1.1 * std::pow(samples / static_cast<double>(ellipse_enlargement * ellipse_enlargement), -0.75));
}

// How many triangles a disk holds of which some points have one each.
static double triangles_in_disk(const RecheckSpace &space, const std::vector<int32_t> &points) {
  const size_t step = points.size() / 1024 + 1;
  double twice_area = 0.0, count = 0.0;
  for (size_t i = 0; i < points.size(); i += step) {
    const int corner = 3 * (space.half_edges.point_half_edge[points[i]] / 3);
    const vec3 at = space.triangles.position(corner);
    twice_area +=
        static_cast<double>(length(cross(space.triangles.position(corner + 1) - at, space.triangles.position(corner + 2) - at)));
    ++count;
  }
  return count > 0.0 ? 2.0 * pi * space.radius * space.radius * count / twice_area : 0.0;
}

// Patches are worth it if floods over triangles would look at each triangle several times. They are exact enough from 150
// vertices in a ball on: those that its rim cuts off by chance make 1 % of its area, and 3 % for two in a thousand.
static bool floods_are_long(const RecheckSpace &space, const std::vector<int32_t> &points) {
  const double triangles = triangles_in_disk(space, points);
  return triangles > 300.0 &&
         static_cast<double>(points.size()) * std::min(triangles, static_cast<double>(MAX_CONNECTED_TRIANGLES)) >
             16.0 * static_cast<double>(space.triangles.triangle_count);
}

// Drops centers that have nearly the area that patches find.
static void drop_by_patches(const RecheckSpace &space, double tolerance, AmbiguousCenters &centers) {
  PatchAreas patches(space.patches(), space.half_edges, space.triangles, space.radius, space.threads);
  const std::vector<double> found = patches.run(centers.points);
  centers.filter([&](size_t i) { return !(found[i] >= 0.0 && std::abs(found[i] - centers.areas[i]) < 0.5 * tolerance); });
}

void recheck(AmbiguousCenters centers, const RecheckSpace &space, const Recheck &again) {
  constexpr size_t batch = 2048;
  const double tolerance = area_tolerance(space.samples) * pi * space.radius * space.radius;
  if (floods_are_long(space, centers.points)) drop_by_patches(space, tolerance, centers);
  ConnectedTriangleSearch search(space.triangles, space.half_edges, space.radius, MAX_CONNECTED_TRIANGLES, space.threads);
  for (size_t first = 0; first < centers.centers.size(); first += batch) {
    again.before_batch(static_cast<double>(first) / static_cast<double>(centers.centers.size()));
    AmbiguousCenters batched = centers.part(first, std::min(first + batch, centers.centers.size()));
    ConnectedTriangles connected = search.run(batched.points, {batched.areas, tolerance});
    ConnectedTriangles others{{0}, std::move(connected.triangle), {}};
    batched.filter([&](size_t i) {
      if (connected.begin[i] == connected.begin[i + 1]) return false;
      others.begin.push_back(connected.begin[i + 1]);
      return true;
    });
    if (!batched.centers.empty()) again.compute(batched.centers, others);
  }
}

} // namespace paradesc
