// Two triangles that share a seam edge in space → the map from (u, v) of the one to (u, v) of the other.
#include "engine/paper/seam_links.h"

#include <cmath>

namespace paradesc {

static dvec2 uv_of(const Charts &charts, int corner) { return dvec2(charts.corner_uv[corner]); }

static dvec3 position_of(const Triangles &triangles, int corner) { return dvec3(triangles.position(corner)); }

// The matrix whose columns are the shared edge and the vector to the third corner, both from corner `first`, in a plane whose x
// axis runs along the edge. The third corner's y coordinate has the sign of `side`.
static dmat2 unfold(const Triangles &triangles, int first, int second, int third, double side) {
  const dvec3 edge = position_of(triangles, second) - position_of(triangles, first);
  const dvec3 spoke = position_of(triangles, third) - position_of(triangles, first);
  const double span = length(edge);
  return dmat2(dvec2(span, 0.0), dvec2(dot(spoke, edge) / span, side * length(cross(edge, spoke)) / span));
}

static dmat2 in_chart(const Charts &charts, int first, int second, int third) {
  const dvec2 origin = uv_of(charts, first);
  return dmat2(uv_of(charts, second) - origin, uv_of(charts, third) - origin);
}

std::vector<vec4> seam_links(const Triangles &triangles, const Charts &charts) {
  std::vector<vec4> links(2 * charts.borders.size(), vec4(0.0f));
  for (size_t i = 0; i < charts.borders.size(); ++i) {
    const Border &border = charts.borders[i];
    links[2 * i + 1].z = -1.0f - static_cast<float>(border.kind);
    if (border.kind != BorderKind::seam) continue;
    const Border &twin = charts.borders[border.twin];
    const auto [first, second] = border_ends(charts, border);
    const int third = previous_corner(border.half_edge);
    // The twin runs the other way along the same edge.
    const bool forward = first == border.half_edge;
    const int far_first = forward ? next_corner(twin.half_edge) : twin.half_edge;
    const int far_second = forward ? twin.half_edge : next_corner(twin.half_edge);
    const int far_third = previous_corner(twin.half_edge);
    const dmat2 near_plane = unfold(triangles, first, second, third, -1.0);
    const dmat2 far_plane = unfold(triangles, far_first, far_second, far_third, 1.0);
    const dmat2 map = in_chart(charts, far_first, far_second, far_third) * inverse(far_plane) * near_plane *
                      inverse(in_chart(charts, first, second, third));
    links[2 * i] = vec4(map[0], map[1]);
    links[2 * i + 1] = vec4(uv_of(charts, far_first), static_cast<float>(border.twin), static_cast<float>(twin.chart));
    if (!(std::isfinite(links[2 * i].x + links[2 * i].y + links[2 * i].z + links[2 * i].w)))
      links[2 * i + 1].z = -1.0f - static_cast<float>(BorderKind::unlinked);
  }
  return links;
}

} // namespace paradesc
