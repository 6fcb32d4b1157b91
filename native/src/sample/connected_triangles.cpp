// Floods over the mesh: from the triangles at a point over every edge that meets the ball, for one point or for many at once.
#include "sample/connected_triangles.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "sample/ball_lanes.h"
#include "support/parallel.h"

namespace paradesc {

// Offsets from the center are in units of the radius: meshes have any size.
// Whether the segment between two positions outside the ball meets it. Most do not, and need no division.
static bool passes(vec3 a, vec3 b) {
  const vec3 way = b - a;
  const float length = dot(way, way), along = -dot(a, way);
  return along > 0.0f && along < length && (dot(a, a) - 1.0f) * length < along * along;
}

namespace {

// The middles of 16 equal parts of a triangle.
struct PartMiddles {
  static constexpr int side = 4;
  vec3 middle[side * side];

  PartMiddles(vec3 corner, vec3 first_side, vec3 second_side) {
    constexpr float step = 1.0f / static_cast<float>(3 * side);
    const vec3 first = first_side * step, second = second_side * step;
    size_t count = 0;
    for (int i = 0; i < side; ++i)
      for (int j = 0; i + j < side; ++j) {
        const vec3 lower =
            corner + first * (3.0f * static_cast<float>(i) + 1.0f) + second * (3.0f * static_cast<float>(j) + 1.0f);
        middle[count++] = lower;
        if (i + j + 1 < side) middle[count++] = lower + first + second;
      }
  }
};

} // namespace

// Each point is a lane: one bit of each vertex's and each triangle's state. In dense meshes neighboring points are connected to
// nearly the same triangles, and the flood comes to most of these in one step for all points.
class SharedFlood {
public:
  SharedFlood(const Triangles &triangles, const HalfEdges &half_edges, double radius, size_t limit)
      : triangles_(triangles), half_edges_(half_edges), balls_(radius), limit_(limit),
        reached_(static_cast<size_t>(triangles.triangle_count), 0), inside_(static_cast<size_t>(triangles.vertex_count), 0) {}

  // Areas within the ball of up to BallLanes::max_lanes points: below 0 where a point's is not known, 0 where there are too many
  // triangles.
  void measure(std::span<const int32_t> points, std::span<double> areas) {
    begin(points);
    const int32_t seed = points[0];
    const vec3 start = position(seed);
    const uint32_t lanes = balls_.holding(start); // with the seed within their ball
    for_each_triangle(seed, [&](int32_t triangle) { add(triangle, lanes); });
    for (size_t i = 0; i < queue_.size() && common_count_ <= limit_; ++i) {
      if (i % 1024 == 1023) leave_out_many();
      const Step step = queue_[i]; // a copy: the queue grows
      cross_edges(step.triangle, step.lanes & live_);
    }
    for (size_t lane = 0; lane < points.size(); ++lane) {
      // Where the seed is connected to the point, both are connected to the same triangles.
      const bool joined = reached_[static_cast<size_t>(half_edges_.point_half_edge[points[lane]]) / 3] >> lane & 1;
      const double area = common_area_ + static_cast<double>(areas_[lane / width][lane % width]);
      const double unit = static_cast<double>(balls_.scale()) * static_cast<double>(balls_.scale());
      areas[lane] = count(lane) > limit_ ? 0.0 : joined ? area / unit : -1.0;
    }
    for (const Step &step : queue_) reached_[step.triangle] = 0;
    for (const int32_t vertex : known_) inside_[vertex] = 0;
  }

  // Whether two points lie so near each other that one flood serves both.
  bool together(int32_t point, int32_t other) const {
    constexpr float near = 0.7f; // of the radius
    const vec3 gap = (position(point) - position(other)) * balls_.scale();
    return dot(gap, gap) < near * near;
  }

  // Appends the triangles of a point that measure() knows the area of, sorted.
  void list(size_t lane, std::vector<int32_t> &found) {
    if (!sorted_) std::ranges::sort(queue_, {}, &Step::triangle);
    sorted_ = true;
    for (const Step &step : queue_)
      if (step.lanes >> lane & 1) found.push_back(step.triangle);
  }

private:
  static constexpr size_t width = BallLanes::width;
  using Lanes = BallLanes::Floats;
  using Bits = BallLanes::Bits;
  static constexpr uint32_t is_known = uint32_t{1} << 31; // of a vertex: its lanes have been looked at
  struct Step {
    int32_t triangle;
    uint32_t lanes; // that have come there
  };

  void begin(std::span<const int32_t> points) {
    balls_.set(points.size(), [&](size_t lane) { return position(points[lane]); });
    live_ = balls_.all();
    for (size_t i = 0; i < balls_.vectors(); ++i) {
      counts_[i] = Bits{};
      areas_[i] = Lanes{};
    }
    common_count_ = 0;
    common_area_ = 0.0;
    queue_.clear();
    sorted_ = false;
    known_.clear();
  }

  vec3 position(int32_t point) const { return triangles_.positions[half_edges_.point_vertex[point]]; }

  template <class Visit> void for_each_triangle(int32_t point, const Visit &visit) const {
    const int32_t first = half_edges_.point_half_edge[point];
    for (int32_t corner = first; corner >= 0;) {
      visit(corner / 3);
      corner = half_edges_.twin[previous_corner(corner)];
      if (corner == first) break;
    }
  }

  void add(int32_t triangle, uint32_t lanes) {
    uint32_t &reached = reached_[triangle];
    const uint32_t fresh = lanes & ~reached;
    if (!fresh) return;
    reached |= fresh;
    queue_.push_back({triangle, fresh});
    __builtin_prefetch(&triangles_.corner_vertex[3 * static_cast<size_t>(triangle)]); // looked at soon
    __builtin_prefetch(&half_edges_.twin[3 * static_cast<size_t>(triangle)]);
  }

  // The lanes whose ball holds a vertex.
  uint32_t inside(int32_t vertex) {
    uint32_t &known = inside_[vertex];
    if (known) return known;
    known_.push_back(vertex);
    return known = is_known | balls_.holding(triangles_.positions[vertex]);
  }

  // Adds what lies beyond the triangle's edges where they meet the ball of these lanes, and to their areas the part of its own
  // within.
  void cross_edges(int32_t triangle, uint32_t lanes) {
    const size_t first = 3 * static_cast<size_t>(triangle);
    vec3 corner[3];
    uint32_t within[3];
    for (size_t i = 0; i < 3; ++i) {
      const int32_t vertex = triangles_.corner_vertex[first + i];
      corner[i] = triangles_.positions[vertex];
      within[i] = inside(vertex) & lanes;
    }
    for (size_t i = 0; i < 3; ++i) {
      const int32_t twin = half_edges_.twin[first + i];
      if (twin < 0) continue;
      const uint32_t wanted = lanes & ~reached_[twin / 3];
      if (!wanted) continue;
      const size_t next = i == 2 ? 0 : i + 1;
      uint32_t over = (within[i] | within[next]) & wanted;
      BallLanes::for_each(wanted & ~over, [&](size_t lane) {
        if (passes(balls_.offset(corner[i], lane), balls_.offset(corner[next], lane))) over |= uint32_t{1} << lane;
      });
      add(twin / 3, over);
    }
    add_area(corner, within, lanes);
  }

  void add_area(const vec3 (&corner)[3], const uint32_t (&within)[3], uint32_t lanes) {
    constexpr float smallest = 0.08f, small = 1.5f; // squares of its sides, in radii
    const vec3 first_side = corner[1] - corner[0], second_side = corner[2] - corner[0];
    const float unit = balls_.scale() * balls_.scale(), area = 0.5f * length(cross(first_side, second_side)) * unit;
    const uint32_t whole = within[0] & within[1] & within[2];
    if (whole == balls_.all()) {
      common_area_ += static_cast<double>(area);
      ++common_count_;
      return;
    }
    for (size_t i = 0; i < balls_.vectors(); ++i) counts_[i] -= BallLanes::are_in(lanes, i);
    const vec3 third_side = corner[2] - corner[1];
    const float squares = (dot(first_side, first_side) + dot(second_side, second_side) + dot(third_side, third_side)) * unit;
    if (squares < smallest) {
      for (size_t i = 0; i < balls_.vectors(); ++i) // a third for each corner
        areas_[i] -=
            __builtin_convertvector(
                BallLanes::are_in(within[0], i) + BallLanes::are_in(within[1], i) + BallLanes::are_in(within[2], i), Lanes) *
            (area / 3.0f);
      return;
    }
    if (squares < small) {
      for (size_t i = 0; i < balls_.vectors(); ++i) {
        const Lanes part =
            part_below_zero(depth(corner[0], squares, i), depth(corner[1], squares, i), depth(corner[2], squares, i));
        areas_[i] += BallLanes::are_in(lanes, i) ? part * area : Lanes{};
      }
      return;
    }
    const PartMiddles parts(corner[0], first_side, second_side);
    for (size_t i = 0; i < balls_.vectors(); ++i) {
      Bits inside{};
      for (const vec3 middle : parts.middle) inside += balls_.squares(middle, i) < 1.0f;
      areas_[i] -= __builtin_convertvector(inside & BallLanes::are_in(lanes, i), Lanes) * (area / std::size(parts.middle));
    }
  }

  // How far a corner lies outside the ball, as the square of its distance tells it. Between corners, squares are lower than what
  // is linear between theirs; in the mean over a triangle, by a twelfth of its sides' squares.
  Lanes depth(vec3 corner, float sides, size_t vector) const { return balls_.squares(corner, vector) - (1.0f + sides / 12.0f); }

  // Of a triangle, the part where what is linear between these values at its corners is below 0.
  static Lanes part_below_zero(Lanes a, Lanes b, Lanes c) {
    const Bits first = a < 0.0f, second = b < 0.0f, third = c < 0.0f;
    const Bits first_alone = (first ^ second) & (first ^ third), second_alone = (second ^ first) & (second ^ third);
    // The one whose sign is another than the other two's cuts off a corner: as long as its part of both sides is.
    const auto pick = [&](Lanes if_first, Lanes if_second, Lanes if_third) {
      const Lanes others = second_alone ? if_second : if_third;
      return first_alone ? if_first : others;
    };
    const Lanes one = pick(a, b, c), next = pick(b, c, a), last = pick(c, a, b);
    const Bits alone = first_alone | second_alone | ((third ^ first) & (third ^ second));
    const Lanes cut_off = one * one / ((one - next) * (one - last));
    const Lanes whole = third ? Lanes{} + 1.0f : Lanes{};
    return alone ? (one < 0.0f ? cut_off : 1.0f - cut_off) : whole;
  }

  // Lanes with too many triangles go no further.
  void leave_out_many() {
    BallLanes::for_each(live_, [&](size_t lane) {
      if (count(lane) > limit_) live_ &= ~(uint32_t{1} << lane);
    });
  }

  size_t count(size_t lane) const { return common_count_ + static_cast<size_t>(counts_[lane / width][lane % width]); }

  const Triangles &triangles_;
  const HalfEdges &half_edges_;
  BallLanes balls_;
  size_t limit_;
  std::vector<uint32_t> reached_; // (triangle_count) lanes that have come there; 0 between calls
  std::vector<uint32_t> inside_;  // (vertex_count) as inside() says; 0 where it was not asked
  std::vector<Step> queue_;       // each triangle once for a lane
  bool sorted_ = false;           // the queue, by triangles
  std::vector<int32_t> known_;    // vertices that inside() was asked for
  uint32_t live_ = 0;             // lanes without too many triangles
  double common_area_ = 0.0;      // of triangles within the balls of all lanes
  size_t common_count_ = 0;
  BallLanes::FloatOfEach areas_; // of each lane's others
  BallLanes::BitsOfEach counts_;
};

ConnectedTriangleSearch::ConnectedTriangleSearch(const Triangles &triangles, const HalfEdges &half_edges, double radius,
                                                 size_t limit, int threads)
    : triangles_(triangles), half_edges_(half_edges), radius_(radius), limit_(limit), threads_(threads) {}

ConnectedTriangleSearch::~ConnectedTriangleSearch() = default;

ConnectedTriangles ConnectedTriangleSearch::run(std::span<const int32_t> points, const ExpectedAreas &expected) {
  constexpr size_t block = 8 * BallLanes::max_lanes;
  const size_t count = points.size();
  std::vector<std::vector<int32_t>> found((count + block - 1) / block);
  std::vector<size_t> first_of(count, 0); // in the list of the point's block
  ConnectedTriangles connected;
  connected.begin.assign(count + 1, 0);
  connected.area.assign(count, 0.0);
  // Of these points.
  const auto measure = [&](SharedFlood &flood, std::span<const size_t> some, std::vector<int32_t> &list) {
    int32_t point[BallLanes::max_lanes];
    double area[BallLanes::max_lanes];
    for (size_t lane = 0; lane < some.size(); ++lane) point[lane] = points[some[lane]];
    flood.measure({point, some.size()}, {area, some.size()});
    for (size_t lane = 0; lane < some.size(); ++lane) {
      const size_t i = some[lane];
      connected.area[i] = area[lane];
      if (!(area[lane] > 0.0)) continue;
      if (!expected.areas.empty() && std::abs(connected.area[i] - expected.areas[i]) < expected.tolerance) continue;
      first_of[i] = list.size();
      flood.list(lane, list);
      connected.begin[i + 1] = static_cast<int32_t>(list.size() - first_of[i]);
    }
  };
  parallel_blocks(static_cast<int>(count), threads_, static_cast<int>(block), [&](int from, int to) {
    const auto begin = static_cast<size_t>(from), end = static_cast<size_t>(to);
    std::vector<int32_t> list; // of its own: neighboring vectors share cache lines
    floods_.with_one([&] { return SharedFlood(triangles_, half_edges_, radius_, limit_); },
                     [&](SharedFlood &flood) {
                       std::vector<size_t> left(end - begin), others, some;
                       std::iota(left.begin(), left.end(), begin);
                       for (; !left.empty(); left.swap(others)) {
                         some.clear();
                         others.clear();
                         for (const size_t i : left) { // the first one whatever its position is: it may be no number
                           const bool joins =
                               some.empty() || (some.size() < BallLanes::max_lanes && flood.together(points[left[0]], points[i]));
                           (joins ? some : others).push_back(i);
                         }
                         measure(flood, some, list);
                       }
                       for (size_t i = begin; i < end; ++i)
                         if (connected.area[i] < 0.0) measure(flood, std::span(&i, 1), list);
                     });
    found[begin / block] = std::move(list);
  });
  std::partial_sum(connected.begin.begin(), connected.begin.end(), connected.begin.begin());
  connected.triangle.reserve(static_cast<size_t>(connected.begin.back()));
  for (size_t i = 0; i < count; ++i) {
    const auto first = found[i / block].begin() + static_cast<ptrdiff_t>(first_of[i]);
    connected.triangle.insert(connected.triangle.end(), first, first + (connected.begin[i + 1] - connected.begin[i]));
  }
  return connected;
}

} // namespace paradesc
