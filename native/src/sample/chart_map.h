// Triangle ids and borders of the layout → the texel that carries a position on a chart, and whether the straight line between
// two positions stays on the chart.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "mesh/charts.h"
#include "sample/border_grid.h"

namespace paradesc {

// Written inline because std::floor is a function call in builds that also serve processors before 2008.
inline int floor_of(double x) {
  const int whole = static_cast<int>(x);
  return whole - (x < whole);
}

// Finds the texel that a position on a chart belongs to, and tests whether two positions are joined by a straight line on the
// chart.
class ChartMap {
public:
  ChartMap(const std::vector<int32_t> &ids, const BorderGrid &grid, const Charts &charts)
      : ids_(ids), grid_(grid), charts_(charts), size_(grid.size) {}

  bool inside(int x, int y) const { return x >= 0 && y >= 0 && x < size_ && y < size_; }
  size_t index(int x, int y) const { return static_cast<size_t>(y) * static_cast<size_t>(size_) + static_cast<size_t>(x); }
  // The chart of a texel whose center lies on a chart, else -1.
  int32_t chart(int x, int y) const { return ids_[2 * index(x, y) + 1] >= 0 ? ids_[2 * index(x, y)] : -1; }

  int32_t triangle(int x, int y) const { return ids_[2 * index(x, y) + 1]; } // if the texel's center lies on a chart

  // A texel's center; beside a border, moved slightly towards its triangle's centroid: rasterizers round, and a center that they
  // call inside may be slightly outside.
  dvec2 middle(int x, int y) const {
    const dvec2 center(x + 0.5, y + 0.5);
    const int32_t triangle = ids_[2 * index(x, y) + 1];
    if (!has_border(x, y) || triangle < 0) return center;
    dvec2 sum(0.0);
    for (size_t i = 0; i < 3; ++i) sum += dvec2(charts_.corner_uv[3 * triangle + i]);
    const dvec2 way = sum * (size_ / 3.0) - center;
    return center + way * std::min(0.5, 0.02 / std::max(length(way), 1e-9));
  }

  // Returns whether no border of the chart crosses the segment from a to b, which lie in one texel or in adjacent texels.
  bool joined(dvec2 a, dvec2 b, int32_t of_chart) const {
    const int x0 = floor_of(std::min(a.x, b.x)), x1 = floor_of(std::max(a.x, b.x));
    const int y0 = floor_of(std::min(a.y, b.y)), y1 = floor_of(std::max(a.y, b.y));
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x)
        if (inside(x, y) && crossed(x, y, a, b, of_chart)) return false;
    return true;
  }

  // Returns whether the segment from a to b, both in this texel, crosses the chart's borders an odd number of times.
  bool crosses_oddly(int x, int y, dvec2 a, dvec2 b, int32_t of_chart) const {
    bool odd = false;
    each_border(x, y, of_chart, [&](dvec2 c, dvec2 d) {
      const bool between = (cross(b - a, c - a) > 0.0) != (cross(b - a, d - a) > 0.0);
      if (between && (cross(d - c, a - c) > 0.0) != (cross(d - c, b - c) > 0.0)) odd = !odd;
    });
    return odd;
  }

  bool has_border(int x, int y) const { return grid_.cells[2 * index(x, y)] < 0; }
  // Returns whether no border runs through this texel or the texels around it.
  bool is_far_from_borders(int x, int y) const { return grid_.cells[2 * index(x, y)] > 0; }
  int32_t owner(int x, int y) const { return ids_[2 * index(x, y)]; } // the chart that owns the texel, also by an edge line

  // The texel that carries a position on a chart: the texel around it, or an adjacent one joined to it; -1: none.
  int64_t carrier(dvec2 position, int32_t of_chart) const {
    const int x = floor_of(position.x), y = floor_of(position.y);
    if (inside(x, y) && chart(x, y) == of_chart && (!has_border(x, y) || joined(position, middle(x, y), of_chart)))
      return static_cast<int64_t>(index(x, y));
    int64_t best = -1;
    double nearest = 1e9;
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        if (!inside(x + dx, y + dy) || chart(x + dx, y + dy) != of_chart) continue;
        const dvec2 there = middle(x + dx, y + dy);
        const double distance = dot(there - position, there - position);
        if (distance >= nearest || !joined(position, there, of_chart)) continue;
        nearest = distance;
        best = static_cast<int64_t>(index(x + dx, y + dy));
      }
    return best;
  }

private:
  template <class Visit> void each_border(int x, int y, int32_t of_chart, const Visit &visit) const {
    const size_t texel = index(x, y);
    const int32_t begin = grid_.cells[2 * texel + 1];
    for (int32_t i = begin; i < begin - std::min(grid_.cells[2 * texel], 0); ++i) {
      if (grid_.list[2 * static_cast<size_t>(i) + 1] != of_chart) continue;
      const dvec4 uv = dvec4(grid_.border_uv[grid_.list[2 * static_cast<size_t>(i)]]) * static_cast<double>(size_);
      visit(dvec2(uv.x, uv.y), dvec2(uv.z, uv.w));
    }
  }

  bool crossed(int x, int y, dvec2 a, dvec2 b, int32_t of_chart) const {
    bool result = false;
    each_border(x, y, of_chart, [&](dvec2 c, dvec2 d) {
      const double side_c = cross(b - a, c - a), side_d = cross(b - a, d - a), side_a = cross(d - c, a - c),
                   side_b = cross(d - c, b - c);
      result |= side_c * side_d <= 0.0 && side_a * side_b < 0.0;
    });
    return result;
  }

  const std::vector<int32_t> &ids_;
  const BorderGrid &grid_;
  const Charts &charts_;
  int size_;
};

} // namespace paradesc
