// Cells → those within a ball around a center, connected or looked at for that, and their samples: the inner part of
// find_neighborhoods.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "sample/ball_lanes.h"
#include "sample/connected_triangles.h"
#include "sample/neighborhoods.h"

namespace paradesc {

// Box around a link's surface points, buffer units.
struct Bounds {
  vec3 low, high;
};

// A cell's leaves side by side, as centers test all of them at once.
struct CellLeaves {
  using Lanes [[gnu::vector_size(CELL_LEAVES * sizeof(float))]] = float;
  Lanes x, y, z;
  Lanes outer; // squared distance from there from which on it lies outside the ball
  Lanes near;  // below which it is sampled finely
  float whole; // squared distance from the cell's middle below which all leaves lie in the ball
  float fine;  // from which on none is sampled finely
  bool joined; // coarse samples are the cell's, not its leaves'
};

// Finer detail than the radius counts through what lies near: leaves there have more samples.
inline CellLeaves leaves_of(const CellData &cell, const CellStrides &strides, size_t index, int leaf_texels, float radius) {
  constexpr float near_share = 0.25f;
  CellLeaves leaves{{}, {}, {}, {}, {}, -1.0f, -1.0f, strides.coarse[CELL_LEAVES * index] > leaf_texels};
  const float rest = radius - cell.sphere.w, within = near_share * radius + 2.0f * cell.sphere.w;
  if (rest > 0.0f) leaves.whole = rest * rest;
  for (size_t i = 0; i < CELL_LEAVES; ++i) {
    const vec4 sphere = cell.leaf[i].sphere;
    const float outer = radius + sphere.w, near = near_share * radius + sphere.w;
    const size_t k = CELL_LEAVES * index + i;
    leaves.x[i] = sphere.x;
    leaves.y[i] = sphere.y;
    leaves.z[i] = sphere.z;
    leaves.outer[i] = sphere.w < 0.0f ? -1.0f : outer * outer;
    leaves.near[i] = sphere.w < 0.0f || strides.fine[k] == strides.coarse[k] ? -1.0f : near * near;
    if (leaves.near[i] > 0.0f) leaves.fine = within * within;
  }
  return leaves;
}

// A search that one thread keeps from center to center.
class CellSearch {
public:
  CellSearch(const SearchSpace &space, std::span<const CellData> measured, std::span<const CellLeaves> leaves, float radius)
      : space_(space), cells_(space.cells), measured_(measured), leaves_(leaves), radius_(radius), balls_(radius),
        visited_(static_cast<size_t>(space.cells.count), 0) {}

  // Finds all cells that are connected to `cell` within the ball of any center nearer than `beyond` to the middle; and others,
  // too.
  void flood_from(int32_t cell, vec3 middle, float beyond) {
    ++mark_;
    found_.clear();
    add(cell);
    for (size_t i = 0; i < found_.size(); ++i) {
      const auto from = static_cast<size_t>(found_[i]);
      for (int32_t k = cells_.adjacency_begin[from]; k < cells_.adjacency_begin[from + 1]; ++k) {
        const int32_t other = cells_.adjacency[k].x;
        if (visited_[other] == mark_) continue;
        const vec4 sphere = measured_[other].sphere;
        const vec3 gap = vec3(sphere) - middle;
        const float limit = radius_ + beyond + around * sphere.w;
        if (sphere.w < 0.0f || dot(gap, gap) < limit * limit) add(other); // one without a sphere may lead on
      }
    }
    std::sort(found_.begin(), found_.end()); // one order of summation, wherever the search began
    look_at_found(mean_normal());
  }

  bool was_found(int32_t cell) const { return visited_[cell] == mark_; }

  // Whether all that was found within the center's ball faces its way and covers its tangent plane once: then it is connected
  // there. measure() comes before.
  bool is_single_sheet(vec3 center) const {
    for (const int32_t k : inside_) {
      const Seen &seen = seen_[k];
      if (!seen.faces_center || (seen.at_boundary && meets_boundary(found_[k], center))) return false;
    }
    return flat_ < 1.25f * static_cast<float>(pi) * radius_ * radius_;
  }

  // Which of those found lie in the center's ball, and their area there, projected.
  void measure(vec3 center) {
    const size_t count = found_.size();
    distance_.resize(middle_.size());
    inside_.resize(count);
    Lanes flat{};
    for (size_t i = 0; i < middle_.size(); ++i) {
      const Middles &m = middle_[i];
      const Lanes dx = m.x - center.x, dy = m.y - center.y, dz = m.z - center.z, square = dx * dx + dy * dy + dz * dz;
      // Between r^2 - 2 r s and r^2 + 2 r s, so that an even disk has its own area.
      const Lanes part = (m.rim - square) * m.per_rim;
      flat += m.area * (part < 0.0f ? Lanes{} : part < 1.0f ? part : Lanes{} + 1.0f);
      distance_[i] = square;
    }
    flat_ = 0.0f;
    for (size_t lane = 0; lane < lane_count; ++lane) flat_ += flat[lane];
    size_t inside = 0;
    for (size_t k = 0; k < count; ++k) { // without a branch
      inside_[inside] = static_cast<int32_t>(k);
      inside += distance(k) < middle_[k / lane_count].outer[k % lane_count];
    }
    inside_.resize(inside);
  }

  // The number of centers, from the first on, that lie so near to it that they search at once.
  size_t together(const std::vector<SearchCenter> &centers, std::span<const int32_t> members) const {
    return balls_.leading(members.size(), 0.6f, [&](size_t i) { return centers[members[i]].position; });
  }

  // The cells of the connected part of each center's ball, for up to BallLanes::max_lanes centers at once; choose() separates
  // them.
  void run(const std::vector<SearchCenter> &centers, std::span<const int32_t> members, const std::vector<Bounds> &links,
           const std::vector<vec3> &link_points) {
    come_.resize(visited_.size(), 0);
    pending_.resize(visited_.size(), 0);
    members_ = members;
    union_.clear();
    boundary_ = 0;
    together_ = {vec3(std::numeric_limits<float>::max()), vec3(-std::numeric_limits<float>::max())};
    balls_.set(members.size(), [&](size_t lane) {
      const vec3 p = centers[members[lane]].position;
      together_ = {glm::min(together_.low, p), glm::max(together_.high, p)};
      return p;
    });
    for (size_t lane = 0; lane < members.size(); ++lane) {
      const SearchCenter &center = centers[members[lane]];
      come_to(center.cell, uint32_t{1} << lane);
      for (const int32_t wedge : center.wedges) come_to(cells_.wedge_cell[wedge], uint32_t{1} << lane);
    }
    for (size_t i = 0; i < queue_.size(); ++i) {
      const auto cell = static_cast<size_t>(queue_[i]);
      const uint32_t lanes = std::exchange(pending_[cell], 0);
      for (int32_t k = cells_.adjacency_begin[cell]; k < cells_.adjacency_begin[cell + 1]; ++k) {
        const ivec2 adjacent = cells_.adjacency[k];
        if (const uint32_t wanted = lanes & ~come_[adjacent.x])
          come_to(adjacent.x, going_over(adjacent.y, links[adjacent.y], link_points, centers, wanted));
      }
      if (cells_.boundary_begin[cell] < cells_.boundary_begin[cell + 1])
        boundary_ |= among(
            lanes & ~boundary_, [&](vec3 p) { return meets_boundary(static_cast<int32_t>(cell), p); }, centers);
    }
    std::sort(union_.begin(), union_.end()); // one order of summation, wherever the search began
    come_of_union_.clear();
    for (const int32_t cell : union_) come_of_union_.push_back(std::exchange(come_[cell], 0));
    queue_.clear();
  }

  // Makes one of these what list() reads. Returns whether the mesh's boundary lies in its ball.
  bool choose(size_t lane, vec3 center) {
    found_.clear();
    for (size_t i = 0; i < union_.size(); ++i)
      if (come_of_union_[i] >> lane & 1) found_.push_back(union_[i]);
    measure_found(center);
    return boundary_ >> lane & 1;
  }

  // Appends the ranges of what was found and lies in the center's ball; after measure() or choose().
  NeighborhoodRanges list(vec3 center, bool boundary, std::vector<ivec2> &ranges) {
    NeighborhoodRanges data{};
    data.hits_boundary = boundary ? 1.0f : 0.0f;
    data.first = static_cast<int32_t>(ranges.size());
    taken_.clear();
    int total = 0;
    for (const int32_t k : inside_) {
      const Taken taken = take(k, center);
      const ivec2 texelless = texelless_of(taken.cell);
      total += 1 + max_samples(taken) + texelless.y - texelless.x;
      if (total > MAX_ITERATIONS) {
        data.missing_area += measured_[taken.cell].area.x;
        continue;
      }
      if (space_.halves || !space_.texelless.samples.empty()) taken_.push_back(taken);
      append(taken, space_.halves ? 0 : -1, data.first, ranges);
    }
    data.middle = data.last = static_cast<int32_t>(ranges.size());
    for (const Taken &taken : taken_)
      if (space_.halves) append(taken, 1, data.middle, ranges);
    data.last = static_cast<int32_t>(ranges.size());
    for (const Taken &taken : taken_) append(texelless_of(taken.cell), data.last, ranges);
    data.end = static_cast<int32_t>(ranges.size());
    return data;
  }

private:
  static constexpr float around = 1.25f; // a link may lie a texel beyond the points of a cell
  static constexpr float least_cosine =
      0.25f; // within 75 degrees hardly a valley is so deep that it leaves the ball of both its sides
  static constexpr size_t lane_count = 8;
  using Lanes [[gnu::vector_size(lane_count * sizeof(float))]] = float;

  // A cell that was found, as centers test it.
  struct Seen {
    bool faces_center; // its normals lie within a cone around those that look at it
    bool at_boundary; // a border of the mesh runs through it
  };
  // The middles of lane_count cells, which centers test at once.
  struct Middles {
    Lanes x, y, z;
    Lanes outer; // squared distance from there from which on it lies outside the ball
    Lanes rim;   // squared distance from which on it is counted out, and one over the width of where it is counted in part
    Lanes per_rim;
    Lanes area; // projected
  };
  // The leaves of a cell that a center takes.
  struct Taken {
    int32_t cell;
    int leaves, fine; // a bit each
  };
  static constexpr int all_leaves = (1 << CELL_LEAVES) - 1;

  vec3 mean_normal() const {
    vec3 sum(0.0f);
    for (const int32_t cell : found_) {
      const CellData &data = measured_[cell];
      if (data.sphere.w >= 0.0f) sum += vec3(data.cone) * data.area.x;
    }
    const float size = length(sum);
    return size > 0.0f ? sum / size : vec3(0.0f);
  }

  // normal: of the tangent plane that centers see them from.
  void look_at_found(vec3 normal) {
    seen_.clear();
    middle_.assign((found_.size() + lane_count - 1) / lane_count, Middles{{}, {}, {}, Lanes{} - 1.0f, Lanes{} - 1.0f, {}, {}});
    for (const int32_t cell : found_) {
      const auto i = static_cast<size_t>(cell);
      const CellData &data = measured_[i];
      const bool empty = data.sphere.w < 0.0f;
      const float cosine = dot(normal, vec3(data.cone)), own = std::clamp(data.cone.w, -1.0f, 1.0f);
      const float sine = std::sqrt(std::max(0.0f, (1.0f - cosine * cosine) * (1.0f - own * own)));
      const float outer = radius_ + data.sphere.w;
      const size_t k = seen_.size(), lane = k % lane_count;
      Middles &m = middle_[k / lane_count];
      m.x[lane] = data.sphere.x;
      m.y[lane] = data.sphere.y;
      m.z[lane] = data.sphere.z;
      m.outer[lane] = empty ? -1.0f : outer * outer;
      m.rim[lane] = empty ? -1.0f : radius_ * (radius_ + 2.0f * data.sphere.w);
      m.per_rim[lane] = 1.0f / std::max(4.0f * radius_ * data.sphere.w, 1e-30f);
      m.area[lane] = data.area.x * std::max(cosine, 0.0f); // projected to the tangent plane
      seen_.push_back(
          {std::min({own, cosine, cosine * own - sine}) > least_cosine, cells_.boundary_begin[i] < cells_.boundary_begin[i + 1]});
    }
  }

  // Does what measure() does, for one center alone.
  void measure_found(vec3 center) {
    distance_.resize((found_.size() + lane_count - 1) / lane_count);
    inside_.clear();
    for (size_t k = 0; k < found_.size(); ++k) {
      const vec4 sphere = measured_[found_[k]].sphere;
      const vec3 gap = vec3(sphere) - center;
      const float square = dot(gap, gap), outer = radius_ + sphere.w;
      distance_[k / lane_count][k % lane_count] = square;
      if (sphere.w >= 0.0f && square < outer * outer) inside_.push_back(static_cast<int32_t>(k));
    }
  }

  ivec2 texelless_of(int32_t cell) const { return {space_.texelless.begin[cell], space_.texelless.begin[cell + 1]}; }

  float distance(size_t slot) const { return distance_[slot / lane_count][slot % lane_count]; }

  Taken take(int32_t slot, vec3 center) const {
    const int32_t cell = found_[slot];
    const CellLeaves &leaves = leaves_[cell];
    const float square = distance(static_cast<size_t>(slot));
    Taken taken{cell, all_leaves, 0};
    const bool near = square < leaves.fine;
    if (!near && (square < leaves.whole || leaves.joined)) return taken;
    const CellLeaves::Lanes dx = leaves.x - center.x, dy = leaves.y - center.y, dz = leaves.z - center.z;
    const CellLeaves::Lanes squares = dx * dx + dy * dy + dz * dz;
    taken.leaves = bits(squares < leaves.outer);
    if (near) taken.fine = bits(squares < leaves.near);
    if (leaves.joined) { // its samples are those of all
      if (taken.fine)
        taken.fine = all_leaves;
      else
        taken.leaves = all_leaves;
    }
    return taken;
  }

  template <class Mask> static int bits(Mask mask) {
    int all = 0;
    for (int i = 0; i < CELL_LEAVES; ++i) all |= mask[i] ? 1 << i : 0;
    return all;
  }

  int max_samples(const Taken &taken) const {
    const ivec2 coarse = space_.samples.of_cell(false, taken.cell), fine = space_.samples.of_cell(true, taken.cell);
    return taken.fine ? coarse.y - coarse.x + fine.y - fine.x : coarse.y - coarse.x;
  }

  // half: of each leaf's samples, or -1: both.
  void append(const Taken &taken, int half, int32_t first, std::vector<ivec2> &ranges) const {
    if (taken.leaves == all_leaves && taken.fine == 0 && half < 0)
      return append(space_.samples.of_cell(false, taken.cell), first, ranges);
    for (int leaf = 0; leaf < CELL_LEAVES; ++leaf) {
      if (!(taken.leaves >> leaf & 1)) continue;
      const bool fine = taken.fine >> leaf & 1;
      append(half < 0 ? space_.samples.of_leaf(fine, taken.cell, leaf) : space_.samples.of_half(fine, taken.cell, leaf, half),
             first, ranges);
    }
  }

  void add(int32_t cell) {
    if (cell < 0 || visited_[cell] == mark_) return;
    visited_[cell] = mark_;
    found_.push_back(cell);
  }

  // first: the list's own, which another list's end must not be joined to.
  static void append(ivec2 range, int32_t first, std::vector<ivec2> &ranges) {
    if (range.x >= range.y) return;
    if (static_cast<int32_t>(ranges.size()) > first && ranges.back().y == range.x)
      ranges.back().y = range.y;
    else
      ranges.push_back(range);
  }

  bool meets_boundary(int32_t cell, vec3 center) const {
    for (int32_t k = cells_.boundary_begin[cell]; k < cells_.boundary_begin[cell + 1]; ++k) {
      const int half_edge = cells_.boundary[k];
      if (segment_in_ball(position(half_edge), position(next_corner(half_edge)), center, radius_)) return true;
    }
    return false;
  }

  void come_to(int32_t cell, uint32_t lanes) {
    if (cell < 0) return;
    const auto i = static_cast<size_t>(cell);
    const uint32_t fresh = lanes & ~come_[i];
    if (!fresh) return;
    if (!come_[i]) union_.push_back(cell);
    if (!pending_[i]) queue_.push_back(cell);
    come_[i] |= fresh;
    pending_[i] |= fresh;
  }

  // Those of the lanes for whose center test() holds.
  template <class Test> uint32_t among(uint32_t lanes, const Test &test, const std::vector<SearchCenter> &centers) const {
    uint32_t passed = 0;
    BallLanes::for_each(lanes, [&](size_t lane) { passed |= uint32_t{test(centers[members_[lane]].position)} << lane; });
    return passed;
  }

  // Those of the lanes whose ball holds a texel of the link.
  uint32_t going_over(int32_t link, const Bounds &box, const std::vector<vec3> &points, const std::vector<SearchCenter> &centers,
                      uint32_t lanes) const {
    const float square = radius_ * radius_;
    const vec3 outside = glm::max(glm::max(box.low - together_.high, together_.low - box.high), vec3(0.0f));
    if (!(dot(outside, outside) < square)) return 0;
    const vec3 across = glm::max(together_.high - box.low, box.high - together_.low);
    if (dot(across, across) < square) return lanes;
    BallLanes::FloatOfEach nearest, farthest; // squared
    for (size_t i = 0; i < balls_.vectors(); ++i) {
      nearest[i] = farthest[i] = BallLanes::Floats{};
      for (int axis = 0; axis < 3; ++axis) {
        const BallLanes::Floats below = box.low[axis] - balls_.centers(i, axis), above = balls_.centers(i, axis) - box.high[axis];
        const BallLanes::Floats gap = below > above ? below : above, way = below < above ? below : above; // either side of zero
        const BallLanes::Floats beyond = gap > 0.0f ? gap : BallLanes::Floats{};
        nearest[i] += beyond * beyond;
        farthest[i] += way * way;
      }
    }
    const uint32_t whole = lanes & balls_.where([&](size_t i) { return farthest[i] < square; });
    const uint32_t near = lanes & ~whole & balls_.where([&](size_t i) { return nearest[i] < square; });
    return whole | among(
                       near, [&](vec3 p) { return in_ball(link, points, p); }, centers);
  }

  // The surface goes over beside one of the link's texels. There is no margin: it would let in a neighboring finger as often as
  // it would keep surface that belongs.
  bool in_ball(int32_t link, const std::vector<vec3> &points, vec3 center) const {
    for (int32_t k = cells_.link_begin[link]; k < cells_.link_begin[link + 1]; ++k) {
      const vec3 gap = points[k] - center;
      if (dot(gap, gap) < radius_ * radius_) return true;
    }
    return false;
  }

  dvec3 position(int corner) const {
    return dvec3(space_.bake_space.to_buffer(space_.triangles.positions[space_.triangles.corner_vertex[corner]]));
  }

  const SearchSpace &space_;
  const Cells &cells_;
  std::span<const CellData> measured_;
  std::span<const CellLeaves> leaves_;
  float radius_;
  BallLanes balls_; // of several centers at once
  std::vector<uint32_t> visited_;
  std::vector<int32_t> found_;
  std::vector<Seen> seen_;      // (found)
  std::vector<Middles> middle_; // (found)
  std::vector<Lanes> distance_; // (found) squared, from the center
  std::vector<int32_t> inside_; // indices into found_
  std::vector<Taken> taken_;    // of these, where they are looked through once more
  // The state of a search of several centers at once; each has a bit.
  std::span<const int32_t> members_;
  Bounds together_;                     // of the centers
  std::vector<uint32_t> come_;          // (cells) that have come there, and
  std::vector<uint32_t> pending_;       // of which others do not know yet; 0 between calls
  std::vector<int32_t> queue_, union_;  // cells
  std::vector<uint32_t> come_of_union_; // (union)
  uint32_t boundary_ = 0;
  float flat_ = 0.0f; // area of all in the center's ball, projected
  uint32_t mark_ = 0;
};

} // namespace paradesc
