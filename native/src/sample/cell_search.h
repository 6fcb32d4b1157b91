// Cells → those within a ball around a center, connected or looked at for that, and their samples: the inner part of
// find_supports.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "sample/reach.h"
#include "sample/supports.h"

namespace paradesc {

// Box around a link's surface points, buffer units.
struct Bounds {
  vec3 low, high;
};

// Squared distance from a point to a box.
inline float box_distance(const Bounds &box, vec3 p) {
  const vec3 gap = glm::max(glm::max(box.low - p, p - box.high), vec3(0.0f));
  return dot(gap, gap);
}

// What one thread keeps from center to center.
class CellSearch {
public:
  CellSearch(const SupportSpace &space, std::span<const CellData> measured, float radius)
      : space_(space), cells_(space.cells), measured_(measured), radius_(radius),
        visited_(static_cast<size_t>(space.cells.count), 0) {}

  // All cells that lie in the ball of any center nearer than `beyond` to the middle, and others: nothing that is connected to the
  // cell within such a ball is missing.
  void reach_from(int32_t cell, vec3 middle, float beyond) {
    ++mark_;
    found_.clear();
    add(cell);
    for (size_t i = 0; i < found_.size(); ++i) {
      const auto from = static_cast<size_t>(found_[i]);
      for (int32_t k = cells_.side_begin[from]; k < cells_.side_begin[from + 1]; ++k) {
        const int32_t other = cells_.side[static_cast<size_t>(k)].x;
        if (visited_[static_cast<size_t>(other)] == mark_) continue;
        const vec4 sphere = measured_[static_cast<size_t>(other)].sphere;
        const vec3 gap = vec3(sphere) - middle;
        const float limit = radius_ + beyond + around * sphere.w;
        if (sphere.w < 0.0f || dot(gap, gap) < limit * limit) add(other); // one that has no place may lead on
      }
    }
    look_at_found(vec3(measured_[static_cast<size_t>(cell)].cone), measured_[static_cast<size_t>(cell)].cone.w);
  }

  bool was_found(int32_t cell) const { return visited_[static_cast<size_t>(cell)] == mark_; }

  // Whether all that was found within the center's ball faces its way and covers its tangent plane once: then it is connected
  // there. measure() comes before.
  bool is_plain(vec3 center) const {
    for (const int32_t k : inside_) {
      const Seen &seen = seen_[static_cast<size_t>(k)];
      if (!seen.plain || (seen.at_boundary && meets_boundary(found_[static_cast<size_t>(k)], center))) return false;
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

  // The cells of the connected part of the center's ball.
  void run(const SupportCenter &center, const std::vector<Bounds> &links, const std::vector<vec4> &positions, bool &boundary) {
    ++mark_;
    found_.clear();
    add(center.cell);
    for (const int32_t site : center.sites) add(cells_.site_cell[static_cast<size_t>(site)]);
    for (size_t i = 0; i < found_.size(); ++i) {
      const auto cell = static_cast<size_t>(found_[i]);
      for (int32_t k = cells_.side_begin[cell]; k < cells_.side_begin[cell + 1]; ++k) {
        const ivec2 side = cells_.side[static_cast<size_t>(k)];
        if (visited_[static_cast<size_t>(side.x)] != mark_ &&
            box_distance(links[static_cast<size_t>(side.y)], center.position) < radius_ * radius_ &&
            in_ball(side.y, positions, center.position))
          add(side.x);
      }
      boundary = boundary || meets_boundary(found_[i], center.position);
    }
    look_at_found(vec3(0.0f), 1.0f);
  }

  // Appends the ranges of what was found and lies in the center's ball; after measure().
  SupportData list(bool boundary, std::vector<ivec2> &ranges) {
    SupportData data{};
    data.cut = boundary ? 1.0f : 0.0f;
    data.first = static_cast<int32_t>(ranges.size());
    taken_.clear();
    int total = 0;
    for (const int32_t k : inside_) {
      const Seen &seen = seen_[static_cast<size_t>(k)];
      // Finer detail than the radius counts through what lies near: cells there are sampled four times as finely each way.
      const bool fine = distance(static_cast<size_t>(k)) < seen.near;
      const ivec2 all = seen.samples[fine];
      total += 1 + all.y - all.x + seen.bare.y - seen.bare.x;
      if (total > MAX_ITERATIONS) {
        data.lost += measured_[static_cast<size_t>(found_[static_cast<size_t>(k)])].area.y;
        continue;
      }
      if (space_.halves || has_bare_) taken_.push_back({k, fine});
      append(space_.halves ? half_of(k, fine, 0) : all, data.first, ranges);
    }
    data.middle = data.last = static_cast<int32_t>(ranges.size());
    for (const Taken &taken : taken_)
      if (space_.halves) append(half_of(taken.place, taken.fine, 1), data.middle, ranges);
    data.last = static_cast<int32_t>(ranges.size());
    for (const Taken &taken : taken_) append(seen_[static_cast<size_t>(taken.place)].bare, data.last, ranges);
    data.end = static_cast<int32_t>(ranges.size());
    return data;
  }

private:
  static constexpr float around = 1.25f; // a link may lie a texel beyond the points of a cell
  static constexpr float least_cosine =
      0.25f; // within 75 degrees hardly a valley is so deep that it leaves the ball of both its sides
  static constexpr float near_share = 0.25f;
  static constexpr size_t lane_count = 8;
  using Lanes [[gnu::vector_size(lane_count * sizeof(float))]] = float;

  // What centers ask of a cell that was found.
  struct Seen {
    float near;       // squared distance from its middle below which it is sampled finely
    bool plain;       // faces its way
    bool at_boundary; // a border of the mesh runs through it
    ivec2 samples[2]; // coarse, fine; of both halves
    ivec2 bare;
  };
  // Of so many cells, to look at them at once.
  struct Middles {
    Lanes x, y, z;
    Lanes outer; // squared distance from there from which on it lies outside the ball
    Lanes rim;   // squared distance from which on it is counted out, and one over the width of where it is counted in part
    Lanes per_rim;
    Lanes area; // projected
  };
  struct Taken {
    int32_t place; // in found_
    bool fine;
  };

  // cone: of the first cell.
  void look_at_found(vec3 normal, float spread) {
    std::sort(found_.begin(), found_.end()); // one order of summation, wherever the search began
    seen_.clear();
    has_bare_ = false;
    middle_.assign((found_.size() + lane_count - 1) / lane_count, Middles{{}, {}, {}, Lanes{} - 1.0f, Lanes{} - 1.0f, {}, {}});
    for (const int32_t cell : found_) {
      const auto i = static_cast<size_t>(cell);
      const CellData &data = measured_[i];
      const bool empty = data.sphere.w < 0.0f;
      const float cosine = dot(normal, vec3(data.cone)), own = std::clamp(data.cone.w, -1.0f, 1.0f);
      const float sine = std::sqrt(std::max(0.0f, (1.0f - cosine * cosine) * (1.0f - own * own)));
      const float outer = radius_ + data.sphere.w, near = near_share * radius_ + data.sphere.w;
      const size_t k = seen_.size(), lane = k % lane_count;
      Middles &m = middle_[k / lane_count];
      m.x[lane] = data.sphere.x;
      m.y[lane] = data.sphere.y;
      m.z[lane] = data.sphere.z;
      m.outer[lane] = empty ? -1.0f : outer * outer;
      m.rim[lane] = empty ? -1.0f : radius_ * (radius_ + 2.0f * data.sphere.w);
      m.per_rim[lane] = 1.0f / std::max(4.0f * radius_ * data.sphere.w, 1e-30f);
      m.area[lane] = data.area.y * std::max(cosine, 0.0f); // projected to the tangent plane of the first cell
      const auto both = [&](bool fine) { return ivec2(space_.samples.of(fine, cell, 0).x, space_.samples.of(fine, cell, 1).y); };
      seen_.push_back({near * near,
                       std::min({own, spread, cosine, cosine * own - sine}) > least_cosine,
                       cells_.boundary_begin[i] < cells_.boundary_begin[i + 1],
                       {both(false), both(true)},
                       {space_.bare.begin[i], space_.bare.begin[i + 1]}});
      has_bare_ = has_bare_ || seen_.back().bare.x < seen_.back().bare.y;
    }
  }

  float distance(size_t place) const { return distance_[place / lane_count][place % lane_count]; }

  ivec2 half_of(int32_t place, bool fine, int half) const {
    return space_.samples.of(fine, found_[static_cast<size_t>(place)], half);
  }

  void add(int32_t cell) {
    if (cell < 0 || visited_[static_cast<size_t>(cell)] == mark_) return;
    visited_[static_cast<size_t>(cell)] = mark_;
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
    for (int32_t k = cells_.boundary_begin[static_cast<size_t>(cell)]; k < cells_.boundary_begin[static_cast<size_t>(cell) + 1];
         ++k) {
      const int half_edge = cells_.boundary[static_cast<size_t>(k)];
      if (segment_in_ball(position(half_edge), position(next_corner(half_edge)), center, radius_)) return true;
    }
    return false;
  }

  // The surface goes over beside one of the link's texels. No margin: it would let in a neighboring finger as often as it keeps a
  // place that belongs.
  bool in_ball(int32_t link, const std::vector<vec4> &positions, vec3 center) const {
    for (int32_t k = cells_.link_begin[static_cast<size_t>(link)]; k < cells_.link_begin[static_cast<size_t>(link) + 1]; ++k) {
      const vec3 gap = vec3(positions[static_cast<size_t>(cells_.link_texel[static_cast<size_t>(k)])]) - center;
      if (dot(gap, gap) < radius_ * radius_) return true;
    }
    return false;
  }

  dvec3 position(int corner) const {
    return dvec3(space_.frame.to_buffer(
        space_.triangles.positions[static_cast<size_t>(space_.triangles.corner_vertex[static_cast<size_t>(corner)])]));
  }

  const SupportSpace &space_;
  const Cells &cells_;
  std::span<const CellData> measured_;
  float radius_;
  std::vector<uint32_t> visited_;
  std::vector<int32_t> found_;
  std::vector<Seen> seen_;      // (found)
  std::vector<Middles> middle_; // (found)
  std::vector<Lanes> distance_; // (found) squared, from the center
  std::vector<int32_t> inside_; // places in found_
  std::vector<Taken> taken_;    // of these, where they are looked through once more
  float flat_ = 0.0f;           // area of all in the center's ball, projected
  bool has_bare_ = false;
  uint32_t mark_ = 0;
};

} // namespace paradesc
