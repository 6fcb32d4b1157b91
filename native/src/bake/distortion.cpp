// Triangle edges in space and in (u, v) → first fundamental forms and sampling ellipses.
#include "bake/distortion.h"

#include <algorithm>
#include <cmath>

namespace paradesc {

BakeSpace bake_space_of(const Box &box) {
  const dvec3 half = 0.5 * (box.high - box.low);
  const double longest = std::max({half.x, half.y, half.z});
  return {0.5 * (box.low + box.high), longest > 0.0 ? 1.0 / longest : 1.0};
}

vec4 form_of(const Triangles &triangles, const Charts &charts, const BakeSpace &bake_space, size_t triangle) {
  dvec3 p[3];
  dvec2 uv[3];
  for (size_t i = 0; i < 3; ++i) {
    const size_t corner = 3 * triangle + i;
    p[i] = dvec3(triangles.positions[triangles.corner_vertex[corner]]);
    uv[i] = dvec2(charts.corner_uv[corner]);
  }
  const dvec3 e1 = (p[1] - p[0]) * bake_space.scale, e2 = (p[2] - p[0]) * bake_space.scale;
  const dvec2 d1 = uv[1] - uv[0], d2 = uv[2] - uv[0];
  const double area = cross(d1, d2);
  const dvec3 p_u = (e1 * d2.y - e2 * d1.y) / area;
  const dvec3 p_v = (e2 * d1.x - e1 * d2.x) / area;
  return vec4(dot(p_u, p_u), dot(p_u, p_v), dot(p_v, p_v), length(cross(p_u, p_v)));
}

// The symmetric square root of a positive 2x2 matrix (xx, xy, yy).
static vec4 square_root(dvec3 m) {
  const double root = std::sqrt(std::max(m.x * m.z - m.y * m.y, 0.0));
  const double trace = std::sqrt(std::max(m.x + m.z + 2.0 * root, 1e-300));
  return vec4((m.x + root) / trace, m.y / trace, m.y / trace, (m.z + root) / trace);
}

std::vector<vec4> sampling_ellipses(const Triangles &triangles, const Charts &charts, const BakeSpace &bake_space, size_t step) {
  const size_t count = (charts.wedges.size() + step - 1) / step;
  std::vector<dvec3> inverse(count, dvec3(0.0));
  std::vector<double> weight(count, 0.0);
  for (size_t corner = 0; corner < charts.corner_wedge.size(); ++corner) {
    if (charts.corner_wedge[corner] < 0 || static_cast<size_t>(charts.corner_wedge[corner]) % step != 0) continue;
    const auto wedge = static_cast<size_t>(charts.corner_wedge[corner]) / step;
    const vec4 form = form_of(triangles, charts, bake_space, corner / 3);
    const double determinant = static_cast<double>(form.w) * form.w;
    if (!(determinant > 0.0)) continue;
    const double angle = surface_angle(triangles, static_cast<int>(corner));
    inverse[wedge] += angle / determinant * dvec3(form.z, -form.y, form.x);
    weight[wedge] += angle;
  }
  std::vector<vec4> ellipses(count, vec4(0.0f));
  for (size_t i = 0; i < count; ++i)
    if (weight[i] > 0.0) ellipses[i] = square_root(inverse[i] / weight[i]);
  return ellipses;
}

} // namespace paradesc
