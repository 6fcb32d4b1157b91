// A point is evaluated at its primary wedge, a texel where it lies. A point that the UV map leaves out has no center.
#include "engine/paper/centers.h"

#include <algorithm>

#include "engine/paper/pattern.h"
#include "support/cancel.h"

namespace paradesc {

double median_radius_in_texels(const Charts &charts, int buffer_size, float radius, const std::vector<vec4> &ellipses,
                               size_t step) {
  std::vector<double> sizes;
  for (size_t i = 0; i < ellipses.size(); ++i) {
    const dvec4 ellipse = dvec4(ellipses[i]) * static_cast<double>(radius);
    const double shorter = 0.5 * (ellipse.x + ellipse.w - length(dvec2(ellipse.x - ellipse.w, 2.0 * ellipse.y))); // of its axes
    const bool primary = charts.point_wedge[charts.wedges[i * step].point] == static_cast<int32_t>(i * step);
    if (primary) sizes.push_back(std::max(0.0, shorter) * buffer_size);
  }
  if (sizes.empty()) return 0.0;
  std::nth_element(sizes.begin(), sizes.begin() + static_cast<ptrdiff_t>(sizes.size() / 2), sizes.end());
  return sizes[sizes.size() / 2];
}

std::vector<int32_t> centers_on_charts(const Charts &charts, const Centers &centers) {
  std::vector<int32_t> numbers;
  for (size_t i = 0; i < centers.list.size(); ++i)
    if (!centers.texels.empty() || charts.point_wedge[i] >= 0) numbers.push_back(static_cast<int32_t>(i));
  return numbers;
}

// Marches start slightly inside the chart: on its border every direction would begin on an edge. way: to the inside.
static vec4 with_start(vec2 uv, vec2 way, int size) {
  const float texels = length(way) * static_cast<float>(size);
  return vec4(uv, uv + way * std::min(0.2f, 0.02f / std::max(texels, 1e-6f)));
}

static CenterData describe_point(const Charts &charts, const CenterOptions &options, int32_t point,
                                 const std::vector<vec4> &ellipses) {
  const int32_t index = charts.point_wedge[point];
  const Wedge &wedge = charts.wedges[index];
  CenterData data{};
  data.chart = wedge.chart;
  data.phase = pattern_rotation(static_cast<uint32_t>(point), options.seed);
  data.uv = with_start(wedge.uv, wedge.inside - wedge.uv, options.buffer_size);
  data.ellipse = ellipses[index] * options.ellipse_size;
  return data;
}

static CenterData describe_texel(const Charts &charts, const CenterOptions &options, const TexelCenter &center, int map_size,
                                 const std::vector<vec4> &ellipses) {
  const vec3 weights(1.0f - center.weights.x - center.weights.y, center.weights);
  const auto corner = 3 * static_cast<size_t>(center.triangle);
  vec4 ellipse(0.0f);
  for (size_t i = 0; i < 3; ++i) ellipse += ellipses[charts.corner_wedge[corner + i]] * weights[static_cast<int>(i)];
  const auto uv = [&](size_t i) { return charts.corner_uv[corner + i]; };
  const bool inside = std::min({weights.x, weights.y, weights.z}) > 1e-4f;
  CenterData data{};
  data.chart = center.chart;
  data.phase = pattern_rotation(static_cast<uint32_t>(center.texel), options.seed);
  data.uv = inside ? vec4(center.uv, center.uv) : with_start(center.uv, (uv(0) + uv(1) + uv(2)) / 3.0f - center.uv, map_size);
  data.ellipse = ellipse * options.ellipse_size;
  return data;
}

std::vector<CenterData> describe_centers(const Charts &charts, const CenterOptions &options, const Centers &centers,
                                         const std::vector<int32_t> &numbers, const std::vector<vec4> &ellipses,
                                         const DisplacedPoints *displaced) {
  std::vector<CenterData> all;
  all.reserve(numbers.size());
  for (const int32_t i : numbers) {
    if (i % 4096 == 0) checkpoint();
    CenterData &data =
        all.emplace_back(centers.texels.empty() ? describe_point(charts, options, i, ellipses)
                                                : describe_texel(charts, options, centers.texels[i], centers.map_size, ellipses));
    data.position = displaced ? displaced->position[i] : centers.list[i].position;
    data.normal = displaced ? displaced->normal[i] : centers.list[i].normal;
  }
  return all;
}

} // namespace paradesc
