// The list has a center for each wedge, in the order of the wedges; the points that the UV map leaves out come after them.
#include "sample/centers.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "sample/pattern.h"
#include "support/cancel.h"

namespace paradesc {

template <class Value> static void reorder(const std::vector<int32_t> &order, std::vector<Value> &values) {
  if (values.empty()) return;
  std::vector<Value> ordered;
  ordered.reserve(values.size());
  for (const int32_t i : order) ordered.push_back(values[i]);
  values.swap(ordered);
}

void Centers::permute(const std::vector<int32_t> &order_now) {
  reorder(order_now, data);
  reorder(order_now, wedges);
  reorder(order_now, points);
  reorder(order_now, order);
}

static bool is_center(const Charts &charts, const CenterOptions &options, size_t wedge) {
  return options.every_wedge || charts.point_wedge[charts.wedges[wedge].point] == static_cast<int32_t>(wedge);
}

double median_radius_in_texels(const Charts &charts, const CenterOptions &options, float radius,
                               const std::vector<vec4> &ellipses, size_t step) {
  std::vector<double> sizes;
  for (size_t i = 0; i < ellipses.size(); ++i) {
    const vec4 ellipse = ellipses[i] * radius;
    if (is_center(charts, options, i * step))
      sizes.push_back(std::sqrt(std::max(0.0f, ellipse.x * ellipse.w - ellipse.y * ellipse.z)) *
                      static_cast<float>(options.buffer_size));
  }
  if (sizes.empty()) return 0.0;
  std::nth_element(sizes.begin(), sizes.begin() + static_cast<ptrdiff_t>(sizes.size() / 2), sizes.end());
  return sizes[sizes.size() / 2];
}

// Marches start a little inside the chart: from a vertex on its border every direction would begin on an edge.
static vec2 march_start(const Wedge &wedge, int buffer_size) {
  const vec2 way = wedge.inside - wedge.uv;
  const float texels = length(way) * static_cast<float>(buffer_size);
  return wedge.uv + way * std::min(0.2f, 0.02f / std::max(texels, 1e-6f));
}

Centers list_centers(const CenterSpace &space, const CenterOptions &options, const std::vector<vec4> &ellipses) {
  const std::vector<Wedge> &wedges = space.charts.wedges;
  auto position_of = [&](size_t point) {
    if (space.displaced) return space.displaced->position[point];
    return space.bake_space.to_buffer(space.triangles.positions[space.half_edges.point_vertex[point]]);
  };
  const std::vector<vec3> &normals = space.displaced ? space.displaced->normal : space.normals.point;
  Centers centers;
  centers.data.reserve(wedges.size());
  centers.wedges.reserve(wedges.size());
  centers.points.reserve(wedges.size());
  for (size_t i = 0; i < wedges.size(); ++i) {
    if (i % 4096 == 0) checkpoint();
    if (!is_center(space.charts, options, i)) continue;
    const Wedge &wedge = wedges[i];
    centers.data.push_back({position_of(wedge.point), wedge.chart, normals[wedge.point],
                            pattern_rotation(static_cast<uint32_t>(wedge.point), options.seed),
                            vec4(wedge.uv, march_start(wedge, options.buffer_size)),
                            options.connected ? vec4(0.0f) : ellipses[i] * options.ellipse_size});
    centers.wedges.push_back(static_cast<int32_t>(i));
    centers.points.push_back(wedge.point);
  }
  // Points that the UV map leaves out count as well: cells lead there, samples carried by the map do not.
  for (size_t point = 0; options.connected && point < space.charts.point_wedge.size(); ++point) {
    if (space.charts.point_wedge[point] >= 0) continue;
    centers.data.push_back({position_of(point), -1, normals[point], 0.0f, vec4(0.0f), vec4(0.0f)});
    centers.wedges.push_back(-1);
    centers.points.push_back(static_cast<int32_t>(point));
  }
  centers.order.resize(centers.data.size());
  std::iota(centers.order.begin(), centers.order.end(), 0);
  return centers;
}

} // namespace paradesc
