// The list has a center for each wedge that is asked for, in the order of wedges. A point that the UV map leaves out has none.
#include "sample/centers.h"

#include <algorithm>

#include "sample/pattern.h"
#include "support/cancel.h"

namespace paradesc {

static bool is_center(const Charts &charts, const CenterOptions &options, size_t wedge) {
  return options.every_wedge || charts.point_wedge[charts.wedges[wedge].point] == static_cast<int32_t>(wedge);
}

double median_radius_in_texels(const Charts &charts, const CenterOptions &options, float radius,
                               const std::vector<vec4> &ellipses, size_t step) {
  std::vector<double> sizes;
  for (size_t i = 0; i < ellipses.size(); ++i) {
    const dvec4 ellipse = dvec4(ellipses[i]) * static_cast<double>(radius);
    const double shorter = 0.5 * (ellipse.x + ellipse.w - length(dvec2(ellipse.x - ellipse.w, 2.0 * ellipse.y))); // of its axes
    if (is_center(charts, options, i * step)) sizes.push_back(std::max(0.0, shorter) * options.buffer_size);
  }
  if (sizes.empty()) return 0.0;
  std::nth_element(sizes.begin(), sizes.begin() + static_cast<ptrdiff_t>(sizes.size() / 2), sizes.end());
  return sizes[sizes.size() / 2];
}

// Marches start slightly inside the chart: from a vertex on its border every direction would begin on an edge.
static vec2 march_start(const Wedge &wedge, int buffer_size) {
  const vec2 way = wedge.inside - wedge.uv;
  const float texels = length(way) * static_cast<float>(buffer_size);
  return wedge.uv + way * std::min(0.2f, 0.02f / std::max(texels, 1e-6f));
}

Centers list_centers(const Charts &charts, const CenterOptions &options) {
  Centers centers;
  for (size_t i = 0; i < charts.wedges.size(); ++i) {
    if (i % 4096 == 0) checkpoint();
    if (!is_center(charts, options, i)) continue;
    const int32_t point = charts.wedges[i].point;
    centers.wedges.push_back(static_cast<int32_t>(i));
    centers.points.push_back(point);
    centers.primary.push_back(charts.point_wedge[point] == static_cast<int32_t>(i));
  }
  return centers;
}

std::vector<CenterData> describe_centers(const Charts &charts, const CenterOptions &options, const Centers &centers,
                                         const std::vector<vec4> &ellipses) {
  std::vector<CenterData> data(centers.points.size());
  for (size_t i = 0; i < data.size(); ++i) {
    if (i % 4096 == 0) checkpoint();
    const Wedge &wedge = charts.wedges[centers.wedges[i]];
    data[i].chart = wedge.chart;
    data[i].phase = pattern_rotation(static_cast<uint32_t>(wedge.point), options.seed);
    data[i].uv = vec4(wedge.uv, march_start(wedge, options.buffer_size));
    data[i].ellipse = ellipses[centers.wedges[i]] * options.ellipse_size;
  }
  return data;
}

void place_centers(const CenterSpace &space, const Centers &centers, std::vector<CenterData> &data) {
  const DisplacedPoints *displaced = space.displaced;
  for (size_t i = 0; i < data.size(); ++i) {
    const int32_t point = centers.points[i];
    const vec3 given = space.triangles.positions[space.half_edges.point_vertex[point]];
    data[i].position = displaced ? displaced->position[point] : space.bake_space.to_buffer(given);
    data[i].normal = displaced ? displaced->normal[point] : space.normals.point[point];
  }
}

} // namespace paradesc
