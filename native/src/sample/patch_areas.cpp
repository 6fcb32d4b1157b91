// Floods from vertex to vertex over edges within the ball, for many points at once, by patches: of those that a ball holds, all
// vertices are reached where one is.
#include "sample/patch_areas.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "sample/ball_lanes.h"
#include "support/cancel.h"
#include "support/parallel.h"

namespace paradesc {

static MeasuredPatches measure(const Patches &patches, const HalfEdges &half_edges, const Triangles &triangles, int threads) {
  // Points share the area of all their triangles, of other patches too.
  std::vector<float> share(static_cast<size_t>(half_edges.point_count), 0.0f);
  const auto position = [&](int32_t point) { return triangles.positions[half_edges.point_vertex[point]]; };
  for (size_t t = 0; t < patches.triangle_patch.size(); ++t) {
    if (patches.triangle_patch[t] < 0) continue;
    const int32_t *corner = &half_edges.corner_point[3 * t];
    const vec3 first = position(corner[0]);
    const float third = length(cross(position(corner[1]) - first, position(corner[2]) - first)) / 6.0f;
    for (size_t i = 0; i < 3; ++i) share[corner[i]] += third;
  }
  MeasuredPatches measured;
  measured.point.resize(patches.point.size());
  measured.sphere.resize(patches.count());
  measured.largest.resize(patches.count());
  parallel_blocks(static_cast<int>(patches.count()), threads, 1024, [&](int from, int to) {
    for (auto patch = static_cast<size_t>(from); patch < static_cast<size_t>(to); ++patch) {
      const auto begin = static_cast<size_t>(patches.point_begin[patch]),
                 end = static_cast<size_t>(patches.point_begin[patch + 1]);
      vec3 low(std::numeric_limits<float>::max()), high(-low);
      for (size_t k = begin; k < end; ++k) {
        const vec3 at = position(patches.point[k]);
        measured.point[k] = vec4(at, share[patches.point[k]]);
        low = glm::min(low, at);
        high = glm::max(high, at);
      }
      const vec3 middle = 0.5f * (low + high);
      float farthest = 0.0f, largest = 0.0f; // squared
      for (size_t k = begin; k < end; ++k) {
        const vec3 gap = vec3(measured.point[k]) - middle;
        farthest = std::max(farthest, dot(gap, gap));
      }
      for (auto k = static_cast<size_t>(patches.begin[patch]); k < static_cast<size_t>(patches.begin[patch + 1]); ++k) {
        const auto corner = [&](size_t i) { return vec3(measured.point[begin + patches.corner[3 * k + i]]); };
        const vec3 normal = cross(corner(1) - corner(0), corner(2) - corner(0));
        largest = std::max(largest, dot(normal, normal));
      }
      measured.sphere[patch] = vec4(middle, std::sqrt(farthest));
      measured.largest[patch] = 0.5f * std::sqrt(largest);
    }
  });
  return measured;
}

// Each ball is a lane: one bit of each vertex's and each patch's state.
class PatchFlood {
public:
  PatchFlood(const Patches &patches, const MeasuredPatches &measured, const HalfEdges &half_edges, const Triangles &triangles,
             double radius)
      : patches_(patches), measured_(measured), half_edges_(half_edges), triangles_(triangles), balls_(radius),
        reached_(static_cast<size_t>(half_edges.point_count), 0), states_(patches.count()) {}

  // Areas of up to BallLanes::max_lanes of the points, by their numbers, which this reorders: below 0 where it is not known.
  void run(std::span<const int32_t> points, std::span<int32_t> numbers, std::vector<double> &areas) {
    while (!numbers.empty()) {
      flood(points, numbers);
      size_t apart = 0; // not connected with the first one within their ball: another flood
      for (size_t lane = 0; lane < numbers.size(); ++lane) {
        const auto number = static_cast<size_t>(numbers[lane]);
        if (lane == 0 || (reached_[points[number]] >> lane & 1))
          areas[number] = area_of(lane);
        else
          numbers[apart++] = numbers[lane];
      }
      clear();
      numbers = numbers.first(apart);
    }
  }

private:
  static constexpr size_t width = BallLanes::width;
  using Lanes = BallLanes::Floats;
  struct State {
    uint32_t pending = 0; // lanes with new points
    uint32_t done = 0;    // lanes whose ball holds all of it
    bool listed = false;
  };

  vec3 position(int32_t point) const { return triangles_.positions[half_edges_.point_vertex[point]]; }

  void flood(std::span<const int32_t> points, std::span<const int32_t> numbers) {
    balls_.set(numbers.size(), [&](size_t lane) { return position(points[numbers[lane]]); });
    unknown_ = 0;
    common_area_ = 0.0;
    std::fill_n(areas_, balls_.vectors(), Lanes{});
    const auto seed = static_cast<size_t>(points[numbers[0]]);
    const auto triangle = static_cast<size_t>(half_edges_.point_half_edge[seed] / 3);
    const int32_t patch = patches_.triangle_patch[triangle];
    seed_ = patches_.point_begin[patch];
    while (patches_.point[seed_] != static_cast<int32_t>(seed)) ++seed_;
    come_to(patch, balls_.all());
    for (size_t i = 0; i < queue_.size(); ++i) visit(static_cast<size_t>(queue_[i]));
  }

  double area_of(size_t lane) const {
    if (unknown_ >> lane & 1) return -1.0;
    return common_area_ + static_cast<double>(areas_[lane / width][lane % width]);
  }

  void clear() {
    for (const int32_t patch : visited_) {
      const auto i = static_cast<size_t>(patch);
      for (auto k = static_cast<size_t>(patches_.point_begin[i]); k < static_cast<size_t>(patches_.point_begin[i + 1]); ++k)
        reached_[patches_.point[k]] = 0;
      states_[i] = {};
    }
    visited_.clear();
    queue_.clear();
  }

  void come_to(int32_t patch, uint32_t lanes) {
    State &state = states_[patch];
    const uint32_t fresh = lanes & ~state.done;
    if (!fresh) return;
    if (!state.pending) queue_.push_back(patch);
    state.pending |= fresh;
    if (!state.listed) visited_.push_back(patch);
    state.listed = true;
  }

  void visit(size_t patch) {
    constexpr float small = 0.03f; // a hundredth of a disk
    const uint32_t lanes = std::exchange(states_[patch].pending, 0);
    const vec4 sphere = measured_.sphere[patch];
    const float size = sphere.w * balls_.scale(), inner = std::max(1.0f - size, 0.0f), outer = 1.0f + size;
    BallLanes::FloatOfEach squares;
    for (size_t i = 0; i < balls_.vectors(); ++i) squares[i] = balls_.squares(vec3(sphere), i);
    const uint32_t whole = lanes & balls_.where([&](size_t i) { return squares[i] < inner * inner; });
    const uint32_t part = lanes & ~whole & balls_.where([&](size_t i) { return squares[i] < outer * outer; });
    states_[patch].done |= whole;
    if (part && !(measured_.largest[patch] * balls_.scale() * balls_.scale() < small)) unknown_ |= part;
    const auto begin = static_cast<size_t>(patches_.point_begin[patch]),
               end = static_cast<size_t>(patches_.point_begin[patch + 1]);
    uint32_t found[3 * Patches::max_triangles]; // by points: the lanes that come there
    if (part)
      connect(patch, whole, part, found);
    else
      std::fill_n(found, end - begin, whole);
    for (size_t k = begin; k < end; ++k) {
      uint32_t &reached = reached_[patches_.point[k]];
      const uint32_t fresh = found[k - begin] & ~reached;
      if (!fresh) continue;
      reached |= fresh;
      add_area(fresh, measured_.point[k].w);
      for (auto i = static_cast<size_t>(patches_.link_begin[k]); i < static_cast<size_t>(patches_.link_begin[k + 1]); ++i)
        come_to(patches_.link[i], fresh);
    }
  }

  // Finds which lanes come to each point of the patch, over its edges from the points that they have come to already.
  void connect(size_t patch, uint32_t whole, uint32_t part, uint32_t *found) const {
    const auto begin = static_cast<size_t>(patches_.point_begin[patch]),
               end = static_cast<size_t>(patches_.point_begin[patch + 1]);
    uint32_t held[3 * Patches::max_triangles];  // the lanes whose ball holds each
    uint32_t missing = 0;                       // among them those that have not come there
    for (size_t k = begin; k < end; ++k) {
      held[k - begin] = whole | (balls_.holding(vec3(measured_.point[k])) & part);
      const uint32_t come = reached_[patches_.point[k]] | (static_cast<int32_t>(k) == seed_ ? balls_.all() : 0);
      found[k - begin] = whole | (come & held[k - begin]);
      missing |= held[k - begin] & ~found[k - begin];
    }
    const auto first = static_cast<size_t>(patches_.begin[patch]), last = static_cast<size_t>(patches_.begin[patch + 1]);
    for (bool more = missing != 0; more;) {
      more = false;
      missing = 0;
      for (size_t k = 3 * first; k < 3 * last; k += 3) {
        uint32_t come = 0, fresh = 0;
        for (size_t i = k; i < k + 3; ++i) come |= found[patches_.corner[i]];
        for (size_t i = k; i < k + 3; ++i) {
          const uint8_t slot = patches_.corner[i];
          const uint32_t before = found[slot], open = held[slot] & ~before;
          found[slot] = before | (come & open);
          fresh |= come & open;
          missing |= open & ~come;
        }
        more |= fresh != 0;
      }
      more &= missing != 0;
    }
  }

  void add_area(uint32_t lanes, float area) {
    if (lanes == balls_.all()) {
      common_area_ += static_cast<double>(area);
      return;
    }
    for (size_t i = 0; i < balls_.vectors(); ++i) areas_[i] -= __builtin_convertvector(BallLanes::are_in(lanes, i), Lanes) * area;
  }

  const Patches &patches_;
  const MeasuredPatches &measured_;
  const HalfEdges &half_edges_;
  const Triangles &triangles_;
  BallLanes balls_;
  std::vector<uint32_t> reached_; // (point_count) lanes that have come there; 0 between calls
  std::vector<State> states_;     // (patches) the same
  std::vector<int32_t> queue_;    // patches with pending lanes, and before them those that had some
  std::vector<int32_t> visited_;  // patches, each once
  int32_t seed_ = 0;              // in Patches::point
  uint32_t unknown_ = 0;
  double common_area_ = 0.0;     // of points that all lanes come to at once
  BallLanes::FloatOfEach areas_; // of each lane's others
};

PatchAreas::PatchAreas(const Patches &patches, const HalfEdges &half_edges, const Triangles &triangles, double radius,
                       int threads)
    : patches_(patches), half_edges_(half_edges), triangles_(triangles), radius_(radius), threads_(threads),
      measured_(measure(patches, half_edges, triangles, threads)) {}

PatchAreas::~PatchAreas() = default;

// Sorts points into groups that lie near each other, by halving across the longest side of their box. Returns where groups begin,
// and the end.
std::vector<size_t> PatchAreas::put_side_by_side(std::span<const int32_t> points, std::span<int32_t> order) const {
  constexpr size_t lanes = BallLanes::max_lanes;
  const auto position = [&](int32_t number) {
    const auto point = static_cast<size_t>(points[number]);
    return triangles_.positions[half_edges_.point_vertex[point]];
  };
  std::vector<size_t> begin{0};
  const auto split = [&](const auto &self, size_t first, size_t last) -> void {
    if (last - first <= lanes) {
      begin.push_back(last);
      return;
    }
    checkpoint();
    vec3 low(std::numeric_limits<float>::max()), high(-low);
    for (size_t i = first; i < last; ++i) {
      low = glm::min(low, position(order[i]));
      high = glm::max(high, position(order[i]));
    }
    const vec3 side = high - low;
    const int axis = side.x >= side.y && side.x >= side.z ? 0 : side.y >= side.z ? 1 : 2;
    const size_t half = (last - first + 1) / 2;
    const size_t middle = first + (half + lanes - 1) / lanes * lanes; // all groups but the last are full
    std::ranges::nth_element(order.begin() + static_cast<ptrdiff_t>(first), order.begin() + static_cast<ptrdiff_t>(middle),
                             order.begin() + static_cast<ptrdiff_t>(last), {},
                             [&](int32_t i) { return std::pair(position(i)[axis], i); });
    self(self, first, middle);
    self(self, middle, last);
  };
  split(split, 0, order.size());
  return begin;
}

std::vector<double> PatchAreas::run(std::span<const int32_t> points) {
  std::vector<double> areas(points.size(), -1.0);
  std::vector<int32_t> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  const std::vector<size_t> groups = put_side_by_side(points, order);
  parallel_blocks(static_cast<int>(groups.size()) - 1, threads_, 8, [&](int from, int to) {
    floods_.with_one([&] { return PatchFlood(patches_, measured_, half_edges_, triangles_, radius_); },
                     [&](PatchFlood &flood) {
                       for (auto i = static_cast<size_t>(from); i < static_cast<size_t>(to); ++i)
                         flood.run(points, std::span(order).subspan(groups[i], groups[i + 1] - groups[i]), areas);
                     });
  });
  return areas;
}

} // namespace paradesc
