// One value a place → one value a vertex.
#include "gather/field.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "descriptor/registry.h"

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

// Of a direction, which has two signs: the angle between each place and the first one of its point.
static std::vector<float> angles(const SiteResults &results, const std::vector<float> &values, size_t points) {
  std::vector<int32_t> first(points, -1);
  std::vector<float> result(results.point.size(), nan);
  for (size_t i = 0; i < result.size(); ++i) {
    int32_t &other = first[static_cast<size_t>(results.point[i])];
    if (other < 0) other = static_cast<int32_t>(i);
    const float *a = &values[3 * i], *b = &values[3 * static_cast<size_t>(other)];
    result[i] = std::acos(std::min(std::abs(a[0] * b[0] + a[1] * b[1] + a[2] * b[2]), 1.0f));
  }
  return result;
}

// points: (points, width).
static std::vector<float> to_vertices(const HalfEdges &half_edges, const std::vector<float> &points, size_t width) {
  std::vector<float> vertices(half_edges.vertex_point.size() * width, nan);
  for (size_t i = 0; i < vertices.size(); ++i) {
    const int32_t point = half_edges.vertex_point[i / width];
    if (point >= 0) vertices[i] = points[static_cast<size_t>(point) * width + i % width];
  }
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
    for (size_t row = 0; row + 1 < field.values.size(); ++row)
      undefined |= std::isnan(field.values[row][i * (field.values[row].size() / field.mask.size())]);
    field.report.undefined_vertices += undefined;
    if (half_edges.vertex_point[i] < 0) continue;
    ++with_face;
    coverage += std::isnan(field.values.back()[i]) ? 0.0 : static_cast<double>(field.values.back()[i]);
  }
  field.report.coverage_mean = with_face ? coverage / with_face : 0.0;
}

void append(SiteResults &all, SiteResults &&part) {
  const auto add = [](auto &to, const auto &from) { to.insert(to.end(), from.begin(), from.end()); };
  const auto before = static_cast<double>(all.coverage.size()), more = static_cast<double>(part.coverage.size());
  all.refined_share = (all.refined_share * before + part.refined_share * more) / std::max(before + more, 1.0);
  all.values.resize(part.values.size());
  for (size_t i = 0; i < part.values.size(); ++i) add(all.values[i], part.values[i]);
  add(all.point, part.point);
  add(all.primary, part.primary);
  add(all.coverage, part.coverage);
  add(all.boundary, part.boundary);
}

void gather(const HalfEdges &half_edges, const SiteResults &results, bool with_seam_error, Field &field) {
  const auto points = static_cast<size_t>(half_edges.point_count);
  std::vector<int32_t> primary(points, -1);
  for (size_t i = 0; i < results.point.size(); ++i)
    if (results.primary[i]) primary[static_cast<size_t>(results.point[i])] = static_cast<int32_t>(i);
  auto add = [&](const std::vector<float> &values, size_t width) {
    std::vector<float> at_points(points * width, nan);
    for (size_t i = 0; i < at_points.size(); ++i) {
      if (primary[i / width] < 0) continue;
      const float value = values[static_cast<size_t>(primary[i / width]) * width + i % width];
      if (std::isfinite(value)) at_points[i] = value; // else more than a float holds, as the volume of a huge sphere
    }
    field.values.push_back(to_vertices(half_edges, at_points, width));
    if (!with_seam_error) return;
    const auto differences = spread(results, width == 3 ? angles(results, values, points) : values, points);
    field.seam_error.push_back(to_vertices(half_edges, differences, 1));
  };
  for (size_t i = 0; i < field.names.size(); ++i) {
    const DescriptorRow &row = descriptor_row(find_descriptor(field.names[i].c_str()));
    add(results.values.empty() ? std::vector<float>() : results.values[i], static_cast<size_t>(row.components));
  }
  add(results.coverage, 1);
  field.names.emplace_back("coverage");
  fill_mask(half_edges, primary, results, field);
  count(half_edges, field);
}

} // namespace paradesc
