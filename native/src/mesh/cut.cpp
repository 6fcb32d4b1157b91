// Finds overlapping triangles square by square. On a chart that overlaps itself, grows pieces triangle by triangle; a triangle
// that would overlap its piece waits for the next one.
#include "mesh/cut.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numeric>
#include <utility>

#include "support/parallel.h"

namespace paradesc {
namespace {

// Triangles that overlap by less than this only touch: corners count as equal up to 1e-6 (charts.cpp).
constexpr double hair = 2e-6;
constexpr int deepest = 20; // levels of the quadtree; its squares are then smaller than a hair

struct Outline : Bounds<dvec2> {
  std::array<dvec2, 3> corner;
};

Outline outline(const Charts &charts, int32_t triangle) {
  Outline result;
  for (size_t i = 0; i < 3; ++i) {
    result.corner[i] = dvec2(charts.corner_uv[3 * triangle + i]);
    result.add(result.corner[i]);
  }
  return result;
}

// Returns whether all of b lies beyond one of a's edges.
bool parted_by_an_edge(const Outline &a, const Outline &b) {
  const double turn = cross(a.corner[1] - a.corner[0], a.corner[2] - a.corner[0]) < 0.0 ? -1.0 : 1.0;
  for (size_t i = 0; i < 3; ++i) {
    const dvec2 start = a.corner[i], edge = a.corner[(i + 1) % 3] - start;
    double depth = 0.0; // of b towards the inside of a
    for (const dvec2 corner : b.corner) depth = std::max(depth, turn * cross(edge, corner - start));
    if (depth <= hair * length(edge)) return true;
  }
  return false;
}

bool overlap(const Outline &a, const Outline &b) {
  if (a.low.x > b.high.x || b.low.x > a.high.x || a.low.y > b.high.y || b.low.y > a.high.y) return false;
  return !parted_by_an_edge(a, b) && !parted_by_an_edge(b, a);
}

// Squares of the UV map, each with the triangles whose boxes meet it.
struct Squares {
  int side = 1; // squares along a side
  dvec2 low{0.0};
  double per_unit = 1.0;
  std::vector<int32_t> begin; // (side * side + 1) into triangle
  std::vector<int32_t> triangle;

  // Never decreases with the coordinate.
  int index(double coordinate, double lowest) const {
    return std::clamp(static_cast<int>((coordinate - lowest) * per_unit), 0, side - 1);
  }
  template <class Visit> void each_met(const Outline &outline, const Visit &visit) const {
    const int x0 = index(outline.low.x, low.x), x1 = index(outline.high.x, low.x);
    for (int y = index(outline.low.y, low.y); y <= index(outline.high.y, low.y); ++y)
      for (int x = x0; x <= x1; ++x) visit(y * side + x);
  }
};

Bounds<dvec2> range_of(const Charts &charts) {
  Bounds<dvec2> range;
  for (const vec2 &uv : charts.corner_uv) range.add(dvec2(uv));
  return range;
}

// Sorts about two triangles into each square. Makes no lists if long triangles would fill too many squares.
Squares sort_into_squares(const Charts &charts) {
  const auto triangle_count = static_cast<int32_t>(charts.triangle_chart.size());
  constexpr int64_t max_per_triangle = 16;
  const Bounds<dvec2> range = range_of(charts);
  Squares squares;
  squares.side = std::clamp(static_cast<int>(std::sqrt(0.5 * triangle_count)), 1, 4096);
  squares.low = range.low;
  squares.per_unit = squares.side / std::max({range.size().x, range.size().y, hair});
  const auto each_triangle = [&](const auto &visit) {
    for (int32_t triangle = 0; triangle < triangle_count; ++triangle)
      if (charts.triangle_chart[triangle] >= 0) visit(triangle, outline(charts, triangle));
  };
  int64_t count = 0;
  each_triangle([&](int32_t, const Outline &own) {
    const auto squares_along = [&](double low, double high, double lowest) {
      return int64_t{1} + squares.index(high, lowest) - squares.index(low, lowest);
    };
    count += squares_along(own.low.x, own.high.x, range.low.x) * squares_along(own.low.y, own.high.y, range.low.y);
  });
  if (count > max_per_triangle * triangle_count) return squares;
  squares.begin.assign((squares.side * squares.side) + 2, 0);
  each_triangle([&](int32_t, const Outline &own) { squares.each_met(own, [&](size_t i) { ++squares.begin[i + 2]; }); });
  std::partial_sum(squares.begin.begin(), squares.begin.end(), squares.begin.begin());
  squares.triangle.resize(squares.begin.back());
  each_triangle([&](int32_t triangle, const Outline &own) {
    squares.each_met(own, [&](size_t i) { squares.triangle[squares.begin[i + 1]++] = triangle; });
  });
  squares.begin.pop_back();
  return squares;
}

struct Overlaps {
  std::vector<std::atomic<uint8_t>> within; // (chart_count) 1: the chart overlaps itself
  std::atomic<bool> between{false};         // two charts overlap
};

// Tests each pair once: only in the square where the intersection of its two boxes begins.
void find_overlaps_in(const Charts &charts, const Squares &squares, size_t square, std::vector<Outline> &outlines,
                      Overlaps &found) {
  outlines.clear();
  const int32_t first = squares.begin[square];
  for (int32_t i = first; i < squares.begin[square + 1]; ++i) {
    const int32_t triangle = squares.triangle[i], chart = charts.triangle_chart[triangle];
    const Outline own = outline(charts, triangle);
    for (size_t k = 0; k < outlines.size(); ++k) {
      const dvec2 low = glm::max(own.low, outlines[k].low), high = glm::min(own.high, outlines[k].high);
      if (low.x > high.x || low.y > high.y) continue;
      if (static_cast<size_t>(squares.index(low.y, squares.low.y) * squares.side + squares.index(low.x, squares.low.x)) != square)
        continue;
      const bool same = charts.triangle_chart[squares.triangle[first + k]] == chart;
      if (same ? found.within[chart].load(std::memory_order_relaxed) != 0 : found.between.load(std::memory_order_relaxed))
        continue; // known
      if (!overlap(own, outlines[k])) continue;
      if (same)
        found.within[chart] = 1;
      else
        found.between = true;
    }
    outlines.push_back(own);
  }
}

// Finds the charts that overlap themselves or others. Returns false if the squares cannot be used for that.
bool find_overlaps(const Charts &charts, int threads, Overlaps &found) {
  const Squares squares = sort_into_squares(charts);
  if (squares.begin.empty()) return false;
  parallel_blocks(squares.side * squares.side, threads, 4096, [&](int begin, int end) {
    std::vector<Outline> outlines;
    for (auto square = begin; square < end; ++square) find_overlaps_in(charts, squares, square, outlines, found);
  });
  return true;
}

// The triangles of one piece by position: a quadtree that stores a triangle in the square that contains its center and has about
// its size. Each square knows the bounding box of all that is stored below it. Small and large triangles may lie side by side.
class Occupancy {
public:
  explicit Occupancy(const Charts &charts) : charts_(charts) {}

  // Triangles must lie in the range.
  void set_range(const Bounds<dvec2> &range) {
    low_ = range.low;
    side_ = std::max({range.size().x, range.size().y, hair});
  }

  void clear() {
    nodes_.assign(1, Node{});
    items_.clear();
  }

  void insert(int32_t triangle) {
    const Outline own = outline(charts_, triangle);
    const dvec2 middle = 0.5 * (own.low + own.high);
    const double extent = std::max(own.size().x, own.size().y);
    int32_t node = 0;
    dvec2 low = low_;
    double half = 0.5 * side_;
    nodes_[0].add(own);
    for (int depth = 0; depth < deepest && half >= extent; ++depth, half *= 0.5) {
      const bool right = middle.x >= low.x + half, upper = middle.y >= low.y + half;
      low += half * dvec2(right, upper);
      node = child(node, right + 2 * upper);
      nodes_[node].add(own);
    }
    items_.push_back({triangle, nodes_[node].first});
    nodes_[node].first = static_cast<int32_t>(items_.size()) - 1;
  }

  bool overlaps(int32_t triangle) const { return overlaps(outline(charts_, triangle), nodes_[0]); }

private:
  struct Node : Bounds<dvec2> {
    std::array<int32_t, 4> child{-1, -1, -1, -1};
    int32_t first = -1; // into items_
  };
  struct Item {
    int32_t triangle, next;
  };

  int32_t child(int32_t node, int quarter) {
    const int32_t known = nodes_[node].child[quarter];
    if (known >= 0) return known;
    const auto made = static_cast<int32_t>(nodes_.size());
    nodes_.emplace_back();
    return nodes_[node].child[quarter] = made;
  }

  bool overlaps(const Outline &own, const Node &node) const {
    if (own.high.x < node.low.x || own.high.y < node.low.y || own.low.x > node.high.x || own.low.y > node.high.y) return false;
    for (int32_t item = node.first; item >= 0; item = items_[item].next)
      if (overlap(own, outline(charts_, items_[item].triangle))) return true;
    return std::any_of(node.child.begin(), node.child.end(),
                       [&](int32_t child) { return child >= 0 && overlaps(own, nodes_[child]); });
  }

  const Charts &charts_;
  dvec2 low_{0.0};
  double side_ = 1.0;
  std::vector<Node> nodes_;
  std::vector<Item> items_;
};

struct Cutting {
  const Charts &charts;
  std::vector<int32_t> link;           // (3 * triangle_count) the half-edge across within the chart, or -1
  std::vector<int32_t> triangle_piece; // -1: of none yet
  std::vector<int32_t> tried_by;       // (triangle_count) the last piece that tried to take the triangle
  std::vector<int32_t> queue;
  Occupancy occupancy;
  int32_t pieces = 0;
};

// The triangle of the chart that is the most steps away: strips are then cut from one end. Sets the range to the chart's.
int32_t far_end(Cutting &cutting, std::vector<uint8_t> &seen, int32_t start) {
  Bounds<dvec2> range;
  cutting.queue.assign(1, start);
  seen[start] = 1;
  for (size_t i = 0; i < cutting.queue.size(); ++i) {
    const int32_t triangle = cutting.queue[i];
    range.add(outline(cutting.charts, triangle));
    for (int32_t h = 3 * triangle; h < 3 * triangle + 3; ++h) {
      const int32_t next = cutting.link[h] / 3;
      if (cutting.link[h] < 0 || seen[next]) continue;
      seen[next] = 1;
      cutting.queue.push_back(next);
    }
  }
  cutting.occupancy.set_range(range);
  return cutting.queue.back();
}

// Grows a new piece from this triangle as far as possible. Returns the adjacent triangles that would overlap the piece.
std::vector<int32_t> grow(Cutting &cutting, int32_t seed) {
  const int32_t piece = cutting.pieces++;
  std::vector<int32_t> refused;
  cutting.occupancy.clear();
  cutting.queue.assign(1, seed);
  cutting.tried_by[seed] = piece;
  for (size_t i = 0; i < cutting.queue.size(); ++i) {
    if (i % 1024 == 0) checkpoint();
    const int32_t triangle = cutting.queue[i];
    if (cutting.occupancy.overlaps(triangle)) {
      refused.push_back(triangle);
      continue;
    }
    cutting.occupancy.insert(triangle);
    cutting.triangle_piece[triangle] = piece;
    for (int32_t h = 3 * triangle; h < 3 * triangle + 3; ++h) {
      const int32_t next = cutting.link[h] / 3;
      if (cutting.link[h] < 0 || cutting.triangle_piece[next] >= 0 || cutting.tried_by[next] == piece) continue;
      cutting.tried_by[next] = piece;
      cutting.queue.push_back(next);
    }
  }
  return refused;
}

// Cuts the triangle's chart into pieces. Returns whether there is more than one.
bool cut_chart(Cutting &cutting, std::vector<uint8_t> &seen, int32_t start) {
  std::vector<int32_t> seeds{far_end(cutting, seen, start)};
  const int32_t first = cutting.pieces;
  for (size_t i = 0; i < seeds.size(); ++i) {
    if (cutting.triangle_piece[seeds[i]] >= 0) continue; // an earlier seed's piece has reached it
    const std::vector<int32_t> refused = grow(cutting, seeds[i]);
    seeds.insert(seeds.end(), refused.begin(), refused.end());
  }
  return cutting.pieces > first + 1;
}

// Returns whether triangles of two different charts overlap. Must be called when no chart overlaps itself.
bool charts_overlap(const Charts &charts, Occupancy &occupancy) {
  occupancy.set_range(range_of(charts));
  occupancy.clear();
  for (int32_t triangle = 0; triangle < static_cast<int32_t>(charts.triangle_chart.size()); ++triangle) {
    if (triangle % 1024 == 0) checkpoint();
    if (charts.triangle_chart[triangle] < 0) continue;
    if (occupancy.overlaps(triangle)) return true;
    occupancy.insert(triangle);
  }
  return false;
}

} // namespace

Cuts cut_charts(const HalfEdges &half_edges, const Charts &charts, int threads) {
  Overlaps overlaps{std::vector<std::atomic<uint8_t>>(charts.chart_count), false};
  const bool known = find_overlaps(charts, threads, overlaps);
  const auto count = static_cast<int32_t>(charts.triangle_chart.size());
  Cutting cutting{charts, half_edges.twin,  std::vector<int32_t>(count, -1), std::vector<int32_t>(count, -1),
                  {},     Occupancy(charts)};
  for (size_t h = 0; h < cutting.link.size(); ++h)
    if (charts.half_edge_border[h] >= 0 || charts.triangle_chart[h / 3] < 0) cutting.link[h] = -1;
  std::vector<uint8_t> seen(count, 0);
  std::vector<int32_t> whole(charts.chart_count, -1); // (charts) the one piece of a chart that stays whole, or -1
  Cuts cuts;
  for (int32_t start = 0; start < count; ++start) {
    const int32_t chart = charts.triangle_chart[start];
    if (chart < 0 || seen[start]) continue;
    if (known && !overlaps.within[chart]) {
      if (whole[chart] < 0) whole[chart] = cutting.pieces++;
      cutting.triangle_piece[start] = whole[chart];
      continue;
    }
    cuts.cut_charts += cut_chart(cutting, seen, start);
  }
  cuts.overlapping = cuts.cut_charts > 0 || (known ? overlaps.between.load() : charts_overlap(charts, cutting.occupancy));
  cuts.triangle_piece = std::move(cutting.triangle_piece);
  return cuts;
}

} // namespace paradesc
