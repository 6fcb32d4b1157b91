// Patches grow from triangle to triangle, round, and the next begins beside the last.
#include "mesh/patches.h"

#include <algorithm>
#include <deque>
#include <numeric>
#include <utility>

#include "support/cancel.h"

namespace paradesc {

namespace {

class Grower {
public:
  explicit Grower(const HalfEdges &half_edges) : half_edges_(half_edges), count_(half_edges.corner_point.size() / 3) {
    patches_.triangle_patch.assign(count_, -1);
    patches_.triangle.reserve(count_);
    patches_.corner.reserve(3 * count_);
    for (std::vector<int32_t> *begin : {&patches_.begin, &patches_.point_begin}) begin->push_back(0);
  }

  Patches run() {
    for (size_t triangle = 0; triangle < count_; ++triangle) {
      seeds_.assign(1, static_cast<int32_t>(triangle));
      for (size_t i = 0; i < seeds_.size(); ++i)
        if (is_free(seeds_[i])) grow(seeds_[i]);
    }
    for (size_t patch = 0; patch < patches_.count(); ++patch) describe(patch);
    link();
    return std::move(patches_);
  }

private:
  bool is_free(int32_t triangle) const {
    const auto t = static_cast<size_t>(triangle);
    return patches_.triangle_patch[t] < 0 && half_edges_.corner_point[3 * t] >= 0;
  }

  // The triangle across a half-edge, or -1.
  int32_t across(size_t half_edge) const {
    const int32_t twin = half_edges_.twin[half_edge];
    return twin < 0 ? -1 : twin / 3;
  }

  int sides_within(int32_t triangle, int32_t patch) const {
    int sides = 0;
    for (size_t i = 0; i < 3; ++i) {
      const int32_t other = across(3 * static_cast<size_t>(triangle) + i);
      sides += other >= 0 && patches_.triangle_patch[other] == patch;
    }
    return sides;
  }

  // Adds triangles in notches first, the others breadth first.
  void grow(int32_t seed) {
    const auto patch = static_cast<int32_t>(patches_.count());
    const size_t first = patches_.triangle.size();
    front_.assign(1, seed);
    while (!front_.empty() && patches_.triangle.size() - first < Patches::max_triangles) {
      const int32_t triangle = front_.front();
      front_.pop_front();
      if (!is_free(triangle)) continue;
      patches_.triangle_patch[triangle] = patch;
      patches_.triangle.push_back(triangle);
      for (size_t i = 0; i < 3; ++i) {
        const int32_t other = across(3 * static_cast<size_t>(triangle) + i);
        if (other < 0 || !is_free(other)) continue;
        if (sides_within(other, patch) > 1)
          front_.push_front(other);
        else
          front_.push_back(other);
      }
    }
    for (const int32_t triangle : front_)
      if (is_free(triangle)) seeds_.push_back(triangle);
    patches_.begin.push_back(static_cast<int32_t>(patches_.triangle.size()));
    if (patch % 1024 == 1023) checkpoint();
  }

  // Lists the points of a patch.
  void describe(size_t patch) {
    points_.clear();
    for (auto k = static_cast<size_t>(patches_.begin[patch]); k < static_cast<size_t>(patches_.begin[patch + 1]); ++k)
      for (size_t i = 0; i < 3; ++i)
        patches_.corner.push_back(slot_of(half_edges_.corner_point[3 * static_cast<size_t>(patches_.triangle[k]) + i]));
    patches_.point.insert(patches_.point.end(), points_.begin(), points_.end());
    patches_.point_begin.push_back(static_cast<int32_t>(patches_.point.size()));
  }

  // Lists for each point of a patch the other patches that have it, too.
  void link() {
    std::vector<int32_t> begin(static_cast<size_t>(half_edges_.point_count) + 1, 0), patch_of(patches_.point.size());
    for (const int32_t point : patches_.point) ++begin[point + 1];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<int32_t> next(begin.begin(), begin.end() - 1);
    const auto for_each_point = [&](const auto &visit) { // visit(patch, point)
      for (size_t patch = 0; patch < patches_.count(); ++patch)
        for (auto k = static_cast<size_t>(patches_.point_begin[patch]); k < static_cast<size_t>(patches_.point_begin[patch + 1]);
             ++k)
          visit(static_cast<int32_t>(patch), static_cast<size_t>(patches_.point[k]));
    };
    for_each_point([&](int32_t patch, size_t point) { patch_of[next[point]++] = patch; });
    patches_.link_begin.push_back(0);
    for_each_point([&](int32_t patch, size_t point) {
      for (int32_t k = begin[point]; k < begin[point + 1]; ++k)
        if (const int32_t other = patch_of[k]; other != patch) patches_.link.push_back(other);
      patches_.link_begin.push_back(static_cast<int32_t>(patches_.link.size()));
    });
  }

  uint8_t slot_of(int32_t point) {
    const auto slot = static_cast<size_t>(std::ranges::find(points_, point) - points_.begin());
    if (slot == points_.size()) points_.push_back(point);
    return static_cast<uint8_t>(slot);
  }

  const HalfEdges &half_edges_;
  const size_t count_;
  Patches patches_;
  std::vector<int32_t> seeds_;  // beside patches that are done
  std::deque<int32_t> front_;   // beside the patch that grows
  std::vector<int32_t> points_; // of one patch
};

} // namespace

Patches build_patches(const HalfEdges &half_edges) { return Grower(half_edges).run(); }

} // namespace paradesc
