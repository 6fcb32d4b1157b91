// Triangles and chart edges → texel centers, as the bake finds them; results at texels → results at points.
#include "sample/texels.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "descriptor/registry.h"
#include "support/cancel.h"
#include "support/parallel.h"

namespace paradesc {

static constexpr int many = 256; // texels of a row, or triangles, between two checks for cancelling
static constexpr float nan = std::numeric_limits<float>::quiet_NaN();

namespace {

// The layout, scaled to texels of the map.
struct Raster {
  const Charts &charts;
  TexelMap &map;
  dvec2 uv(int32_t corner) const { return dvec2(charts.corner_uv[corner]) * static_cast<double>(map.size); }
  size_t index(int x, int y) const { return static_cast<size_t>(y) * static_cast<size_t>(map.size) + static_cast<size_t>(x); }
  // The first and last texel whose centers lie in [low, high].
  ivec2 range(double low, double high) const {
    return {std::max(static_cast<int>(std::ceil(low - 0.5)), 0),
            std::min(static_cast<int>(std::floor(high - 0.5)), map.size - 1)};
  }
};

} // namespace

// Draws a triangle; if several triangles claim a texel, the first one gets it.
static void draw_triangle(const Raster &raster, int32_t triangle, int32_t chart, std::vector<TexelCenter> &found) {
  const dvec2 a = raster.uv(3 * triangle), b = raster.uv(3 * triangle + 1), c = raster.uv(3 * triangle + 2);
  const double area = cross(b - a, c - a);
  if (area == 0.0) return;
  const ivec2 rows = raster.range(std::min({a.y, b.y, c.y}), std::max({a.y, b.y, c.y}));
  const ivec2 columns = raster.range(std::min({a.x, b.x, c.x}), std::max({a.x, b.x, c.x}));
  for (int y = rows.x; y <= rows.y; ++y) {
    if (columns.y - columns.x >= many) checkpoint();
    for (int x = columns.x; x <= columns.y; ++x) {
      const dvec2 position(x + 0.5, y + 0.5);
      const double wb = cross(position - a, c - a) / area, wc = cross(b - a, position - a) / area;
      if (wb < 0.0 || wc < 0.0 || wb + wc > 1.0) continue;
      int32_t &entry = raster.map.index[raster.index(x, y)];
      if (entry >= 0) {
        raster.map.overlapping += wb > 0.0 && wc > 0.0 && wb + wc < 1.0;
        continue;
      }
      entry = static_cast<int32_t>(found.size());
      const dvec2 uv = position / static_cast<double>(raster.map.size);
      found.push_back({static_cast<int32_t>(raster.index(x, y)), triangle, chart, vec2(wb, wc), vec2(uv), false});
    }
  }
}

// Gives texels that a border passes through the nearest position on the border. distance: of the texels that borders own, from
// center `owned` on, to their border.
static void draw_border(const Raster &raster, const Border &border, size_t owned, std::vector<TexelCenter> &found,
                        std::vector<double> &distance) {
  constexpr double half_diagonal = 0.7072; // of a texel
  const auto [first, second] = border_ends(raster.charts, border);
  const int32_t triangle = border.half_edge / 3;
  const dvec2 a = raster.uv(first), way = raster.uv(second) - a;
  const double square = std::max(dot(way, way), 1e-30);
  const ivec2 rows = raster.range(std::min(0.0, way.y) + a.y - half_diagonal, std::max(0.0, way.y) + a.y + half_diagonal);
  for (int y = rows.x; y <= rows.y; ++y) {
    if (way.x * way.x > many * many) checkpoint();
    // The part of the edge that can be near this row's texels.
    double from = 0.0, to = 1.0;
    if (std::abs(way.y) > 1e-9) {
      const double low = (y - 0.5 - a.y) / way.y, high = (y + 1.5 - a.y) / way.y;
      from = std::clamp(std::min(low, high), 0.0, 1.0);
      to = std::clamp(std::max(low, high), 0.0, 1.0);
    }
    const ivec2 columns = raster.range(a.x + std::min(from * way.x, to * way.x) - half_diagonal,
                                       a.x + std::max(from * way.x, to * way.x) + half_diagonal);
    for (int x = columns.x; x <= columns.y; ++x) {
      const dvec2 middle(x + 0.5, y + 0.5);
      const double t = std::clamp(dot(middle - a, way) / square, 0.0, 1.0);
      const double gap = length(middle - a - way * t);
      int32_t &entry = raster.map.index[raster.index(x, y)];
      if (gap > half_diagonal || (entry >= 0 && static_cast<size_t>(entry) < owned)) continue;
      if (entry >= 0 && distance[static_cast<size_t>(entry) - owned] <= gap) continue;
      vec3 weights(0.0f);
      weights[first % 3] = static_cast<float>(1.0 - t);
      weights[second % 3] = static_cast<float>(t);
      const dvec2 uv = (a + way * t) / static_cast<double>(raster.map.size);
      const auto texel = static_cast<int32_t>(raster.index(x, y));
      const TexelCenter center{texel, triangle, border.chart, vec2(weights.y, weights.z), vec2(uv), true};
      if (entry < 0) {
        entry = static_cast<int32_t>(found.size());
        found.push_back(center);
        distance.push_back(gap);
      } else {
        found[entry] = center;
        distance[static_cast<size_t>(entry) - owned] = gap;
      }
    }
  }
}

// Puts the centers in the order of their texels.
static void sort_by_texel(TexelMap &map) {
  std::vector<TexelCenter> sorted;
  sorted.reserve(map.centers.size());
  for (size_t texel = 0; texel < map.index.size(); ++texel) {
    if (texel % 65536 == 0) checkpoint();
    int32_t &entry = map.index[texel];
    if (entry < 0) continue;
    sorted.push_back(map.centers[entry]);
    entry = static_cast<int32_t>(sorted.size()) - 1;
  }
  map.centers = std::move(sorted);
}

TexelMap build_texel_map(const Charts &charts, int size) {
  TexelMap map;
  map.size = size;
  map.index.assign(static_cast<size_t>(size) * static_cast<size_t>(size), -1);
  const Raster raster{charts, map};
  for (int32_t t = 0; t < static_cast<int32_t>(charts.triangle_chart.size()); ++t) {
    if (t % many == 0) checkpoint();
    if (const int32_t chart = charts.triangle_chart[t]; chart >= 0) draw_triangle(raster, t, chart, map.centers);
  }
  std::vector<double> distance;
  const size_t owned = map.centers.size();
  for (size_t i = 0; i < charts.borders.size(); ++i) {
    if (i % many == 0) checkpoint();
    draw_border(raster, charts.borders[i], owned, map.centers, distance);
  }
  sort_by_texel(map);
  return map;
}

namespace {

struct Weighted {
  int32_t center;
  float weight; // all weights add up to 1; a weight may be negative
  float near;   // the weight used if some values are undefined
};

// Finds weights for the value at 0 of a plane fitted, weighted by nearness, to values at the offsets (in texels). Returns false
// if the offsets do not span the plane.
bool fit_plane(const std::vector<vec2> &offsets, std::vector<Weighted> &found) {
  glm::dmat3 moments(0.0);
  for (size_t i = 0; i < found.size(); ++i) {
    const dvec3 row(1.0, dvec2(offsets[i]));
    moments += static_cast<double>(found[i].near) * outerProduct(row, row);
  }
  const double spread = moments[1][1] + moments[2][2];
  if (!(determinant(moments) > 0.01 * moments[0][0] * spread * spread)) return false;
  const dvec3 plane = inverse(moments)[0];
  for (size_t i = 0; i < found.size(); ++i)
    found[i].weight = found[i].near * static_cast<float>(dot(plane, dvec3(1.0, dvec2(offsets[i]))));
  return true;
}

class Lookup {
public:
  explicit Lookup(const TexelMap &map) : map_(map) {}

  // Finds the texel centers that a wedge's values are taken from; none if no texel of its chart is near.
  void near(const Wedge &wedge, std::vector<Weighted> &found) const {
    const vec2 texel = wedge.uv * static_cast<float>(map_.size) - 0.5f;
    const vec2 low = glm::floor(texel), share = texel - low;
    found.clear();
    bool regular = true;
    for (int i = 0; i < 4; ++i) {
      const float weight = (i % 2 ? share.x : 1.0f - share.x) * (i / 2 ? share.y : 1.0f - share.y);
      const int32_t index = at(static_cast<int>(low.x) + i % 2, static_cast<int>(low.y) + i / 2, wedge.chart);
      regular = regular && index >= 0 && !map_.centers[index].on_border;
      found.push_back({index, weight, weight});
    }
    if (!regular) found = beside_border(wedge);
    if (found.empty()) add_nearest(texel, wedge.chart, found);
  }

private:
  int32_t at(int x, int y, int32_t chart) const {
    if (x < 0 || y < 0 || x >= map_.size || y >= map_.size) return -1;
    const int32_t index = map_.index[static_cast<size_t>(y) * static_cast<size_t>(map_.size) + static_cast<size_t>(x)];
    return index >= 0 && map_.centers[index].chart == chart ? index : -1;
  }

  std::vector<Weighted> beside_border(const Wedge &wedge) const {
    constexpr float radius = 2.0f;
    const vec2 here = wedge.uv * static_cast<float>(map_.size);
    const ivec2 middle(glm::floor(here));
    std::vector<Weighted> found;
    std::vector<vec2> offsets;
    float sum = 0.0f;
    for (int y = middle.y - 2; y <= middle.y + 2; ++y)
      for (int x = middle.x - 2; x <= middle.x + 2; ++x) {
        const int32_t index = at(x, y, wedge.chart);
        if (index < 0) continue;
        const vec2 offset = map_.centers[index].uv * static_cast<float>(map_.size) - here;
        const float nearness = 1.0f - dot(offset, offset) / (radius * radius);
        if (nearness < 1e-3f) continue;
        found.push_back({index, nearness * nearness, nearness * nearness});
        offsets.push_back(offset);
        sum += found.back().near;
      }
    if (found.size() < 4 || !fit_plane(offsets, found))
      for (Weighted &one : found) one.weight /= sum;
    return found;
  }

  void add_nearest(vec2 texel, int32_t chart, std::vector<Weighted> &found) const {
    constexpr int radius = 4;
    float nearest = std::numeric_limits<float>::max();
    const ivec2 middle(glm::round(texel));
    for (int y = middle.y - radius; y <= middle.y + radius; ++y)
      for (int x = middle.x - radius; x <= middle.x + radius; ++x) {
        const vec2 gap = vec2(x, y) - texel;
        const int32_t index = at(x, y, chart);
        if (index < 0 || dot(gap, gap) >= nearest) continue;
        nearest = dot(gap, gap);
        found.assign(1, {index, 1.0f, 1.0f});
      }
  }

  const TexelMap &map_;
};

} // namespace

static bool is_defined(const float *value, size_t width) {
  return std::none_of(value, value + width, [](float part) { return std::isnan(part); });
}

// Mixes values by weight. A direction has two signs, so each direction is first turned to the side of the first one.
static void mix_value(const std::vector<Weighted> &from, const std::vector<float> &values, size_t width, float *out) {
  const auto at = [&](const Weighted &one) { return &values[static_cast<size_t>(one.center) * width]; };
  if (width == 1) {
    float whole = 0.0f; // NaN if any value is NaN
    for (const Weighted &one : from) whole += one.weight * *at(one);
    *out = whole;
    if (!std::isnan(whole)) return;
  }
  const bool whole = std::all_of(from.begin(), from.end(), [&](const Weighted &one) { return is_defined(at(one), width); });
  vec3 sum(0.0f), side(0.0f);
  float total = 0.0f;
  for (const Weighted &one : from) {
    if (!is_defined(at(one), width)) continue;
    vec3 value(0.0f);
    for (size_t k = 0; k < width; ++k) value[static_cast<int>(k)] = at(one)[k];
    if (total == 0.0f) side = value;
    const float weight = whole ? one.weight : one.near;
    sum += (width == 3 && dot(value, side) < 0.0f ? -weight : weight) * value;
    total += one.near;
  }
  if (width == 3)
    sum /= std::max(length(sum), 1e-30f);
  else if (!whole)
    sum /= std::max(total, 1e-30f);
  for (size_t k = 0; k < width; ++k) out[k] = total > 0.0f ? sum[static_cast<int>(k)] : nan;
}

CenterResults look_up(const TexelMap &map, const CenterResults &results, const Charts &charts, int threads) {
  constexpr int block = 16384;
  const Lookup lookup(map);
  const size_t count = charts.point_wedge.size(), centers = map.centers.size();
  CenterResults found;
  found.refined_share = results.refined_share;
  found.coverage.assign(count, nan);
  found.boundary.assign(count, 0);
  for (const auto &values : results.values) found.values.emplace_back(centers ? values.size() / centers * count : 0, nan);
  parallel_blocks(static_cast<int>(count), threads, block, [&](int begin, int end) {
    std::vector<Weighted> from;
    for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
      if (charts.point_wedge[i] < 0) continue;
      lookup.near(charts.wedges[charts.point_wedge[i]], from);
      if (from.empty()) continue;
      for (size_t row = 0; row < results.values.size(); ++row) {
        const size_t width = results.values[row].size() / centers;
        mix_value(from, results.values[row], width, &found.values[row][i * width]);
      }
      mix_value(from, results.coverage, 1, &found.coverage[i]);
      found.coverage[i] = std::clamp(found.coverage[i], 0.0f, 1.0f);
      for (const Weighted &one : from) found.boundary[i] |= results.boundary[one.center];
    }
  });
  return found;
}

std::vector<std::vector<float>> images_of(const TexelMap &map, const CenterResults &results, std::span<const int> descriptors) {
  std::vector<std::vector<float>> images;
  auto add = [&](const std::vector<float> &values, size_t width) {
    std::vector<float> image(map.index.size() * width, nan);
    for (size_t i = 0; i < values.size(); ++i) {
      checkpoint_at(i);
      image[map.centers[i / width].texel * width + i % width] = values[i];
    }
    images.push_back(std::move(image));
  };
  for (size_t i = 0; i < descriptors.size(); ++i)
    add(results.values[i], static_cast<size_t>(descriptor_row(descriptors[i]).components));
  add(results.coverage, 1);
  add({results.boundary.begin(), results.boundary.end()}, 1);
  return images;
}

} // namespace paradesc
