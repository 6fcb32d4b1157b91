// Grows round patches from triangle to triangle; the next patch starts beside the last one.
#include "mesh/patches.h"

#include <algorithm>
#include <deque>
#include <utility>

#include "support/cancel.h"

namespace paradesc {

namespace {

class Grower {
public:
  explicit Grower(const HalfEdges &half_edges)
      : half_edges_(half_edges), count_(static_cast<int32_t>(half_edges.corner_point.size() / 3)) {
    patches_.code.assign(static_cast<size_t>(count_), -1);
  }

  Patches run() {
    for (int32_t triangle = 0; triangle < count_; ++triangle) {
      seeds_.assign(1, triangle);
      for (size_t i = 0; i < seeds_.size(); ++i)
        if (is_free(seeds_[i])) grow(seeds_[i]);
    }
    patches_.neighbor_begin.push_back(0);
    for (int32_t patch = 0; patch < patches_.count(); ++patch) list_neighbors(patch);
    return std::move(patches_);
  }

private:
  bool is_free(int32_t triangle) const { return patches_.code[triangle] < 0 && half_edges_.corner_point[3 * triangle] >= 0; }

  int sides_within(int32_t triangle, int32_t patch) const {
    int sides = 0;
    for (int32_t side = 0; side < 3; ++side) {
      const int32_t other = patches_.across(half_edges_, 3 * triangle + side);
      sides += other >= 0 && other / Patches::max_triangles == patch;
    }
    return sides;
  }

  // Adds triangles in notches of the patch first, all others breadth first.
  void grow(int32_t seed) {
    const int32_t patch = patches_.count(), first = patch * Patches::max_triangles;
    patches_.triangle.resize(patches_.triangle.size() + Patches::max_triangles, -1);
    front_.assign(1, seed);
    for (int32_t code = first; !front_.empty() && code < first + Patches::max_triangles;) {
      const int32_t triangle = front_.front();
      front_.pop_front();
      if (!is_free(triangle)) continue;
      patches_.triangle[code] = triangle;
      patches_.code[triangle] = code++;
      for (int32_t side = 0; side < 3; ++side) {
        const int32_t twin = half_edges_.twin[3 * triangle + side];
        if (twin < 0 || !is_free(twin / 3)) continue;
        if (sides_within(twin / 3, patch) > 1)
          front_.push_front(twin / 3);
        else
          front_.push_back(twin / 3);
      }
    }
    for (const int32_t triangle : front_)
      if (is_free(triangle)) seeds_.push_back(triangle);
    if (patch % 1024 == 1023) checkpoint();
  }

  void list_neighbors(int32_t patch) {
    const int32_t begin = patches_.neighbor_begin.back();
    for (int32_t code = patch * Patches::max_triangles; code < (patch + 1) * Patches::max_triangles; ++code) {
      if (patches_.triangle[code] < 0) break;
      for (int32_t side = 0; side < 3; ++side) {
        const int32_t other = patches_.across(half_edges_, 3 * patches_.triangle[code] + side);
        if (other < 0 || other / Patches::max_triangles == patch) continue;
        const int32_t to = other / Patches::max_triangles;
        auto found = std::find_if(patches_.neighbor.begin() + begin, patches_.neighbor.end(),
                                  [&](const ivec2 &neighbor) { return neighbor.x == to; });
        if (found == patches_.neighbor.end()) found = patches_.neighbor.insert(found, ivec2(to, 0));
        found->y |= static_cast<int32_t>(uint32_t{1} << other % Patches::max_triangles);
      }
    }
    patches_.neighbor_begin.push_back(static_cast<int32_t>(patches_.neighbor.size()));
  }

  const HalfEdges &half_edges_;
  const int32_t count_;
  Patches patches_;
  std::vector<int32_t> seeds_; // beside patches that are done
  std::deque<int32_t> front_;  // beside the patch that grows
};

} // namespace

Patches build_patches(const HalfEdges &half_edges) { return Grower(half_edges).run(); }

} // namespace paradesc
