// One value a place → one value a vertex.
#include "gather/field.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace paradesc {

static constexpr float nan = std::numeric_limits<float>::quiet_NaN();

// Largest less smallest value over the places of each point; NaN where a point has one place, infinity where the value exists at
// some places only.
static std::vector<float> spread(const SiteResults &results, const std::vector<float> &values, size_t points) {
  struct Range {
    float low = std::numeric_limits<float>::infinity(), high = -std::numeric_limits<float>::infinity();
    int places = 0, undefined = 0;
  };
  std::vector<Range> ranges(points);
  for (size_t i = 0; i < results.point.size(); ++i) {
    Range &range = ranges[static_cast<size_t>(results.point[i])];
    ++range.places;
    if (std::isnan(values[i])) {
      ++range.undefined;
      continue;
    }
    range.low = std::min(range.low, values[i]);
    range.high = std::max(range.high, values[i]);
  }
  std::vector<float> result(points, nan);
  for (size_t i = 0; i < points; ++i) {
    if (ranges[i].places < 2 || ranges[i].undefined == ranges[i].places) continue;
    result[i] = ranges[i].undefined ? std::numeric_limits<float>::infinity() : ranges[i].high - ranges[i].low;
  }
  return result;
}

static std::vector<float> to_vertices(const HalfEdges &half_edges, const std::vector<float> &points) {
  std::vector<float> vertices(half_edges.vertex_point.size(), nan);
  for (size_t i = 0; i < vertices.size(); ++i)
    if (half_edges.vertex_point[i] >= 0) vertices[i] = points[static_cast<size_t>(half_edges.vertex_point[i])];
  return vertices;
}

static void fill_mask(const HalfEdges &half_edges, const std::vector<int32_t> &primary, const SiteResults &results,
                      Field &field) {
  field.mask.assign(half_edges.vertex_point.size(), 0);
  for (size_t i = 0; i < field.mask.size(); ++i) {
    const int32_t point = half_edges.vertex_point[i];
    if (point < 0) {
      field.mask[i] = PDESC_MASK_NO_FACE;
      continue;
    }
    const int32_t place = primary[static_cast<size_t>(point)];
    if (place < 0) {
      field.mask[i] = PDESC_MASK_NO_TEXEL;
      continue;
    }
    if (results.boundary[static_cast<size_t>(place)]) field.mask[i] |= PDESC_MASK_BOUNDARY;
    if (results.coverage[static_cast<size_t>(place)] < 0.9f) field.mask[i] |= PDESC_MASK_LOW_COVERAGE;
  }
}

static void count(const HalfEdges &half_edges, Field &field) {
  double coverage = 0.0;
  int with_face = 0;
  for (size_t i = 0; i < field.mask.size(); ++i) {
    field.report.boundary_vertices += (field.mask[i] & PDESC_MASK_BOUNDARY) != 0;
    field.report.low_coverage_vertices += (field.mask[i] & PDESC_MASK_LOW_COVERAGE) != 0;
    bool undefined = false;
    for (size_t row = 0; row + 1 < field.values.size(); ++row) undefined |= std::isnan(field.values[row][i]);
    field.report.undefined_vertices += undefined;
    if (half_edges.vertex_point[i] < 0) continue;
    ++with_face;
    coverage += std::isnan(field.values.back()[i]) ? 0.0 : static_cast<double>(field.values.back()[i]);
  }
  field.report.coverage_mean = with_face ? coverage / with_face : 0.0;
}

void gather(const HalfEdges &half_edges, const SiteResults &results, bool with_seam_error, Field &field) {
  const auto points = static_cast<size_t>(half_edges.point_count);
  std::vector<int32_t> primary(points, -1);
  for (size_t i = 0; i < results.point.size(); ++i)
    if (results.primary[i]) primary[static_cast<size_t>(results.point[i])] = static_cast<int32_t>(i);
  auto add = [&](const std::vector<float> &values) {
    std::vector<float> at_points(points, nan);
    for (size_t i = 0; i < points; ++i)
      if (primary[i] >= 0) at_points[i] = values[static_cast<size_t>(primary[i])];
    field.values.push_back(to_vertices(half_edges, at_points));
    if (with_seam_error) field.seam_error.push_back(to_vertices(half_edges, spread(results, values, points)));
  };
  for (const auto &values : results.values) add(values);
  add(results.coverage);
  field.names.emplace_back("coverage");
  fill_mask(half_edges, primary, results, field);
  count(half_edges, field);
}

} // namespace paradesc
