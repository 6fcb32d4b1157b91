// Border segments → texels they touch; exact distances between texels (Felzenszwalb and Huttenlocher 2012).
#include "engine/paper/border_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "support/union_find.h"

namespace paradesc {

// Calls visit(x, y) for each texel that the segment touches, with a margin for the rounding in marches.
template <class Visit> static void touched_texels(dvec2 a, dvec2 b, int size, const Visit &visit) {
  constexpr double margin = 0.01;
  if (a.x > b.x) std::swap(a, b);
  auto texel = [&](double x) { return std::clamp(static_cast<int>(std::floor(x)), 0, size - 1); };
  for (int x = texel(a.x - margin); x <= texel(b.x + margin); ++x) {
    const double left = std::max(a.x, x - margin), right = std::min(b.x, x + 1 + margin);
    double y0 = a.y, y1 = b.y;
    if (b.x - a.x > 1e-9) {
      const double slope = (b.y - a.y) / (b.x - a.x);
      y0 = a.y + slope * (std::clamp(left, a.x, b.x) - a.x);
      y1 = a.y + slope * (std::clamp(right, a.x, b.x) - a.x);
    }
    if (y0 > y1) std::swap(y0, y1);
    for (int y = texel(y0 - margin); y <= texel(y1 + margin); ++y) visit(x, y);
  }
}

// Squared distances along one line: the lower envelope of the parabolas of its texels.
static void envelope(std::vector<float> &line, std::vector<float> &result, std::vector<int> &apex, std::vector<float> &bound) {
  const int n = static_cast<int>(line.size());
  int k = -1;
  for (int q = 0; q < n; ++q) {
    const float fq = line[q];
    if (!std::isfinite(fq)) continue;
    float s = -std::numeric_limits<float>::infinity();
    while (k >= 0) {
      const int v = apex[k];
      const float fv = line[v];
      s = (fq - fv) / (2.0f * static_cast<float>(q - v)) + 0.5f * static_cast<float>(q + v);
      if (s > bound[k]) break;
      --k;
    }
    ++k;
    apex[k] = q;
    bound[k] = k == 0 ? -std::numeric_limits<float>::infinity() : s;
  }
  const int last = k;
  k = 0;
  for (int q = 0; q < n; ++q) {
    if (last < 0) {
      result[q] = std::numeric_limits<float>::infinity();
      continue;
    }
    while (k < last && bound[k + 1] < static_cast<float>(q)) ++k;
    const auto gap = static_cast<float>(q - apex[k]);
    result[q] = gap * gap + line[apex[k]];
  }
}

static void distance_transform(std::vector<float> &field, int size) {
  const auto n = static_cast<size_t>(size);
  std::vector<float> line(n), result(n), bound(n + 1);
  std::vector<int> apex(n + 1);
  for (size_t x = 0; x < n; ++x) {
    for (size_t y = 0; y < n; ++y) line[y] = field[y * n + x];
    envelope(line, result, apex, bound);
    for (size_t y = 0; y < n; ++y) field[y * n + x] = result[y];
  }
  for (size_t y = 0; y < n; ++y) {
    std::copy_n(field.begin() + static_cast<ptrdiff_t>(y * n), n, line.begin());
    envelope(line, result, apex, bound);
    std::copy_n(result.begin(), n, field.begin() + static_cast<ptrdiff_t>(y * n));
  }
}

BorderGrid build_border_grid(const Charts &charts, int size) {
  BorderGrid grid;
  grid.size = size;
  const size_t texels = static_cast<size_t>(size) * static_cast<size_t>(size);
  for (const Border &border : charts.borders) {
    const auto [first, second] = border_ends(charts, border);
    grid.border_uv.emplace_back(charts.corner_uv[first], charts.corner_uv[second]);
  }
  std::vector<int32_t> begin(texels + 1, 0);
  auto visit_all = [&](const auto &visit) {
    for (size_t i = 0; i < charts.borders.size(); ++i) {
      const dvec2 a(dvec2(grid.border_uv[i].x, grid.border_uv[i].y) * static_cast<double>(size));
      const dvec2 b(dvec2(grid.border_uv[i].z, grid.border_uv[i].w) * static_cast<double>(size));
      touched_texels(a, b, size, [&](int x, int y) {
        visit(i, static_cast<size_t>(y) * static_cast<size_t>(size) + static_cast<size_t>(x));
      });
    }
  };
  visit_all([&](size_t, size_t texel) { ++begin[texel + 1]; });
  for (size_t i = 0; i < texels; ++i) begin[i + 1] += begin[i];
  grid.list.resize(2 * static_cast<size_t>(begin[texels]));
  std::vector<int32_t> next(begin.begin(), begin.end() - 1);
  visit_all([&](size_t border, size_t texel) {
    const auto slot = 2 * static_cast<size_t>(next[texel]++);
    grid.list[slot] = static_cast<int32_t>(border);
    grid.list[slot + 1] = charts.borders[border].chart;
  });

  std::vector<float> distance(texels);
  for (size_t i = 0; i < texels; ++i) distance[i] = begin[i + 1] > begin[i] ? 0.0f : std::numeric_limits<float>::infinity();
  distance_transform(distance, size);
  grid.cells.resize(2 * texels);
  for (size_t i = 0; i < texels; ++i) {
    const int32_t count = begin[i + 1] - begin[i];
    // Two positions in two texels are at least as far apart as the texels' centers, less a texel's diagonal.
    const double safe = std::floor(std::sqrt(std::min(distance[i], 1e9f)) - 1.415);
    grid.cells[2 * i] = count > 0 ? -count : static_cast<int32_t>(std::max(safe, 0.0));
    grid.cells[2 * i + 1] = begin[i];
  }
  return grid;
}

std::vector<int32_t> number_seams(const Charts &charts) {
  const size_t count = charts.borders.size();
  const auto is_seam = [&](size_t i) { return charts.borders[i].kind == BorderKind::seam; };
  UnionFind sets(count);
  // Borders of one seam meet at a wedge, and so do their twins.
  std::map<std::pair<int32_t, int32_t>, int32_t> met;
  for (size_t i = 0; i < count; ++i) {
    if (!is_seam(i)) continue;
    const int32_t near = charts.borders[i].half_edge;
    const int32_t far = charts.borders[charts.borders[i].twin].half_edge;
    for (const auto &[a, b] : {std::pair(near, next_corner(far)), std::pair(next_corner(near), far)}) {
      const std::pair wedges(charts.corner_wedge[a], charts.corner_wedge[b]);
      const auto [other, is_new] = met.emplace(wedges, static_cast<int32_t>(i));
      if (!is_new) sets.join(other->second, static_cast<int32_t>(i));
    }
  }
  std::vector<int32_t> seam;
  for (size_t i = 0; i < count; ++i) seam.push_back(is_seam(i) ? sets.root_of(static_cast<int32_t>(i)) : -1);
  return seam;
}

} // namespace paradesc
