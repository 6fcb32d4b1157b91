// One value per center → one value per vertex.
#include "gather/field.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "descriptor/registry.h"
#include "support/parallel.h"

namespace paradesc {

static constexpr float nan = std::numeric_limits<float>::quiet_NaN();
static constexpr int block = 16384; // of vertices

// The range of values over the centers of each point; NaN if a point has one center, infinity if the value exists at some of its
// centers only.
static std::vector<float> spread(const CenterResults &results, const std::vector<float> &values, size_t points) {
  struct Range {
    float low = std::numeric_limits<float>::infinity(), high = -std::numeric_limits<float>::infinity();
    int centers = 0, undefined = 0;
  };
  std::vector<Range> ranges(points);
  for (size_t i = 0; i < results.point.size(); ++i) {
    Range &range = ranges[results.point[i]];
    ++range.centers;
    if (std::isnan(values[i])) {
      ++range.undefined;
      continue;
    }
    range.low = std::min(range.low, values[i]);
    range.high = std::max(range.high, values[i]);
  }
  std::vector<float> result(points, nan);
  for (size_t i = 0; i < points; ++i) {
    if (ranges[i].centers < 2 || ranges[i].undefined == ranges[i].centers) continue;
    result[i] = ranges[i].undefined ? std::numeric_limits<float>::infinity() : ranges[i].high - ranges[i].low;
  }
  return result;
}

// The same for directions, which have two signs: the angle between each center's direction and that of its point's first center.
static std::vector<float> angles(const CenterResults &results, const std::vector<float> &values, size_t points) {
  std::vector<int32_t> first(points, -1);
  std::vector<float> result(results.point.size(), nan);
  for (size_t i = 0; i < result.size(); ++i) {
    int32_t &other = first[results.point[i]];
    if (other < 0) other = static_cast<int32_t>(i);
    const float *a = &values[3 * i], *b = &values[3 * static_cast<size_t>(other)];
    result[i] = std::acos(std::min(std::abs(a[0] * b[0] + a[1] * b[1] + a[2] * b[2]), 1.0f));
  }
  return result;
}

static std::vector<float> at_vertices(const HalfEdges &half_edges, const std::vector<float> &points) {
  std::vector<float> vertices;
  vertices.reserve(half_edges.vertex_point.size());
  for (const int32_t point : half_edges.vertex_point) vertices.push_back(point >= 0 ? points[point] : nan);
  return vertices;
}

// rows: (vertices) the row of each vertex; -1: none. Infinite values become NaN: they overflow a float, such as the volume of a
// huge sphere.
static std::vector<float> pick(const std::vector<int32_t> &rows, const std::vector<float> &values, size_t width, int threads) {
  std::vector<float> picked(rows.size() * width, nan);
  parallel_blocks(static_cast<int>(rows.size()), threads, block, [&](int begin, int end) {
    for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i)
      for (size_t k = 0; k < width && rows[i] >= 0; ++k)
        if (const float value = values[static_cast<size_t>(rows[i]) * width + k]; std::isfinite(value))
          picked[i * width + k] = value;
  });
  return picked;
}

static uint8_t mask_of(const CenterResults &results, int32_t point, int32_t center) {
  if (point < 0) return PDESC_MASK_NO_FACE;
  if (center < 0) return PDESC_MASK_NO_TEXEL;
  const bool boundary = results.boundary[center] != 0;
  const bool low = results.coverage[center] < 0.9f;
  return static_cast<uint8_t>((boundary ? PDESC_MASK_BOUNDARY : 0) | (low ? PDESC_MASK_LOW_COVERAGE : 0));
}

static void fill_mask(const HalfEdges &half_edges, const std::vector<int32_t> &vertex_center, const CenterResults &results,
                      int threads, Field &field) {
  field.mask.resize(vertex_center.size());
  parallel_blocks(static_cast<int>(vertex_center.size()), threads, block, [&](int begin, int end) {
    for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i)
      field.mask[i] = mask_of(results, half_edges.vertex_point[i], vertex_center[i]);
  });
}

static void count(const HalfEdges &half_edges, int threads, Field &field) {
  struct Counts {
    int boundary = 0, low = 0, undefined = 0, with_face = 0;
    double coverage = 0.0;
  };
  const size_t vertices = field.mask.size();
  std::vector<Counts> parts((vertices + block - 1) / block);
  std::vector<std::pair<const float *, size_t>> rows; // all rows but coverage: values, and their number per vertex
  for (size_t row = 0; vertices > 0 && row + 1 < field.values.size(); ++row)
    rows.emplace_back(field.values[row].data(), field.values[row].size() / vertices);
  parallel_blocks(static_cast<int>(vertices), threads, block, [&](int begin, int end) {
    Counts part; // local, because neighbors in parts share cache lines
    for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
      part.boundary += (field.mask[i] & PDESC_MASK_BOUNDARY) != 0;
      part.low += (field.mask[i] & PDESC_MASK_LOW_COVERAGE) != 0;
      bool undefined = false;
      for (const auto &[values, width] : rows) undefined |= std::isnan(values[i * width]);
      part.undefined += undefined;
      if (half_edges.vertex_point[i] < 0) continue;
      ++part.with_face;
      const float coverage = field.values.back()[i];
      part.coverage += std::isnan(coverage) ? 0.0 : static_cast<double>(coverage);
    }
    parts[begin / block] = part;
  });
  Counts all;
  for (const Counts &part : parts) {
    all.boundary += part.boundary;
    all.low += part.low;
    all.undefined += part.undefined;
    all.with_face += part.with_face;
    all.coverage += part.coverage;
  }
  field.report.boundary_vertices += all.boundary;
  field.report.low_coverage_vertices += all.low;
  field.report.undefined_vertices += all.undefined;
  field.report.coverage_mean = all.with_face ? all.coverage / all.with_face : 0.0;
}

void gather(const HalfEdges &half_edges, const CenterResults &results, bool with_seam_error, int threads, Field &field) {
  const auto points = static_cast<size_t>(half_edges.point_count);
  std::vector<int32_t> primary(points, -1), vertex_center(half_edges.vertex_point.size());
  for (size_t i = 0; i < results.point.size(); ++i)
    if (results.primary[i]) primary[results.point[i]] = static_cast<int32_t>(i);
  parallel_blocks(static_cast<int>(vertex_center.size()), threads, block, [&](int begin, int end) {
    for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i)
      vertex_center[i] = half_edges.vertex_point[i] < 0 ? -1 : primary[half_edges.vertex_point[i]];
  });
  auto add = [&](const std::vector<float> &values, size_t width) {
    field.values.push_back(pick(vertex_center, values, width, threads));
    if (!with_seam_error) return;
    const auto differences = spread(results, width == 3 ? angles(results, values, points) : values, points);
    field.seam_error.push_back(at_vertices(half_edges, differences));
  };
  for (size_t i = 0; i < field.names.size(); ++i) {
    const DescriptorRow &row = descriptor_row(find_descriptor(field.names[i].c_str()));
    add(results.values.empty() ? std::vector<float>() : results.values[i], static_cast<size_t>(row.components));
  }
  add(results.coverage, 1);
  field.names.emplace_back("coverage");
  fill_mask(half_edges, vertex_center, results, threads, field);
  count(half_edges, threads, field);
}

} // namespace paradesc
