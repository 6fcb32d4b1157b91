// One value per center → one value per vertex. Texels have become points before, by sample/texels.cpp.
#include "gather/field.h"

#include <cmath>
#include <limits>
#include <utility>

#include "descriptor/registry.h"
#include "support/parallel.h"

namespace paradesc {

static constexpr float nan = std::numeric_limits<float>::quiet_NaN();
static constexpr int block = 16384; // of vertices

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

void gather(const HalfEdges &half_edges, const CenterResults &results, std::span<const int> rows, int threads, Field &field) {
  std::vector<int32_t> vertex_center(half_edges.vertex_point.size());
  parallel_blocks(static_cast<int>(vertex_center.size()), threads, block, [&](int begin, int end) {
    for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
      const int32_t point = half_edges.vertex_point[i];
      vertex_center[i] = point < 0 || std::isnan(results.coverage[point]) ? -1 : point;
    }
  });
  for (size_t i = 0; i < rows.size(); ++i) {
    const DescriptorRow &row = descriptor_row(rows[i]);
    field.names.emplace_back(row.name);
    field.values.push_back(pick(vertex_center, results.values[i], static_cast<size_t>(row.components), threads));
  }
  field.values.push_back(pick(vertex_center, results.coverage, 1, threads));
  field.names.emplace_back("coverage");
  fill_mask(half_edges, vertex_center, results, threads, field);
  count(half_edges, threads, field);
}

} // namespace paradesc
