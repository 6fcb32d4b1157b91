// Cells by their links, then surfels by the edges between them.
#include "engine/cpu/search.h"

#include <algorithm>
#include <limits>

#include "sample/connected_triangles.h"

namespace paradesc {

Search::Search(const SurfelSource &source, const Surfels &surfels, const SurfaceSamples &samples, CountNearest count_nearest)
    : source_(source), surfels_(surfels), samples_(samples), count_nearest_(count_nearest), mark_(surfels.cell_sphere.size(), 0),
      reached_mark_(surfels.surfel.size(), 0) {}

void Search::look(const std::vector<TreeCenter> &centers, std::span<const int32_t> group) {
  vec3 low(std::numeric_limits<float>::max()), high(-low);
  for (const int32_t i : group) {
    low = glm::min(low, centers[i].position);
    high = glm::max(high, centers[i].position);
  }
  middle_ = 0.5f * (low + high);
  const float reach = surfels_.radius + 0.5f * length(high - low);
  find_cells(centers, group, reach);
  list_blocks(reach);
}

// All cells that are connected to the group's own by cells that come near the balls of its centers.
void Search::find_cells(const std::vector<TreeCenter> &centers, std::span<const int32_t> group, float reach) {
  ++searches_;
  cells_.clear();
  const auto add = [&](int32_t cell) {
    if (std::exchange(mark_[cell], searches_) != searches_) cells_.push_back(cell);
  };
  for (const int32_t i : group) add(surfels_.triangle_cell[centers[i].triangle]);
  for (size_t i = 0; i < cells_.size(); ++i)
    for (int32_t k = surfels_.link_begin[cells_[i]]; k < surfels_.link_begin[cells_[i] + 1]; ++k) {
      const int32_t other = surfels_.link[k];
      if (mark_[other] == searches_) continue;
      const vec4 sphere = surfels_.cell_sphere[other];
      const vec3 gap = vec3(sphere) - middle_;
      const float limit = reach + sphere.w;
      if (dot(gap, gap) < limit * limit) add(other);
    }
  std::sort(cells_.begin(), cells_.end()); // one order of summation, wherever the search began
}

void Search::list_blocks(float reach) {
  stored_.clear();
  divided_.clear();
  divided_samples_.clear(source_.map != nullptr);
  divided_surfels_.clear();
  boundary_.clear();
  for (const int32_t cell : cells_) {
    const int32_t first = surfels_.cell_begin[cell], last = surfels_.cell_begin[cell + 1];
    const int32_t begin = samples_.first[first], end = samples_.first[last];
    if (begin < end)
      for (int32_t block = begin / block_lanes; block <= (end - 1) / block_lanes; ++block)
        if (stored_.empty() || stored_.last() < block) stored_.add(block, samples_.block_sphere[block], surfels_.radius);
    if (surfels_.surfel[first].samples > max_stored_samples) { // a cell of its own
      const int32_t before = divided_samples_.count();
      divide_triangle(source_, surfels_, first, middle_, reach, divided_samples_);
      divided_surfels_.push_back({first, before, divided_samples_.count()});
    }
    boundary_.insert(boundary_.end(), surfels_.boundary.begin() + surfels_.boundary_begin[cell],
                     surfels_.boundary.begin() + surfels_.boundary_begin[cell + 1]);
  }
  divided_samples_.fill_block();
  for (int32_t block = 0; block < divided_samples_.blocks(); ++block)
    divided_.add(block, divided_samples_.sphere(block), surfels_.radius);
}

bool Search::meets_ball(int32_t half_edge, vec3 center) const {
  return segment_in_ball(source_.position(half_edge), source_.position(next_corner(half_edge)), center, surfels_.radius);
}

bool Search::near_boundary(vec3 center) const {
  return std::ranges::any_of(boundary_, [&](int32_t half_edge) { return meets_ball(half_edge, center); });
}

// Null: it is not very large, or it was not found.
const Search::Range *Search::find_divided(int32_t surfel) const {
  if (surfels_.surfel[surfel].samples <= max_stored_samples) return nullptr;
  const auto found = std::ranges::lower_bound(divided_surfels_, surfel, {}, &Range::surfel);
  return found != divided_surfels_.end() && found->surfel == surfel ? &*found : nullptr;
}

int32_t Search::count_nearest_of(int32_t surfel, const SumCenter &at) const {
  const auto count = [&](const Samples &samples, int32_t begin, int32_t end) {
    return begin < end ? count_nearest_(surfels_.radius, samples.data(), samples.stride(), begin, end, at) : 0;
  };
  if (const Range *range = find_divided(surfel)) return count(divided_samples_, range->begin, range->end);
  return count(samples_.samples, samples_.first[surfel], samples_.first[surfel + 1]);
}

void Search::start_flood(int32_t triangle) {
  ++floods_;
  reached_.clear();
  reach(surfels_.triangle_surfel[triangle]);
}

void Search::reach(int32_t surfel) {
  if (std::exchange(reached_mark_[surfel], floods_) != floods_) reached_.push_back(surfel);
}

// A piece of surface that is not connected to the center would come nearest to it somewhere: so there is none if all samples
// where the surface may do so are connected to the center by each other.
bool Search::is_one_piece(const TreeCenter &center, const SumCenter &at, int32_t nearest) {
  start_flood(center.triangle);
  int32_t found = 0;
  for (size_t i = 0; i < reached_.size() && found < nearest; ++i) {
    const int32_t surfel = reached_[i], here = count_nearest_of(surfel, at);
    found += here;
    const bool is_empty = samples_.first[surfel] == samples_.first[surfel + 1];
    if (i > 0 && here == 0 && !is_empty) continue;
    if (surfels_.surfel[surfel].level == 0)
      reach_neighbors(surfel, center.position);
    else // clusters are small
      for (int32_t k = surfels_.neighbor_begin[surfel]; k < surfels_.neighbor_begin[surfel + 1]; ++k) reach(surfels_.neighbor[k]);
  }
  return found == nearest;
}

// Whether the boundary is met, too.
bool Search::reach_neighbors(int32_t surfel, vec3 center) {
  bool boundary = false;
  for (int32_t i = surfels_.first[surfel]; i < surfels_.first[surfel + 1]; ++i)
    for (int32_t half_edge = 3 * source_.tree.triangle[i]; half_edge < 3 * source_.tree.triangle[i] + 3; ++half_edge) {
      const int32_t twin = source_.half_edges.twin[half_edge];
      const int32_t behind = twin < 0 ? -1 : surfels_.triangle_surfel[twin / 3];
      if ((behind >= 0 && reached_mark_[behind] == floods_) || !meets_ball(half_edge, center)) continue;
      if (behind >= 0)
        reach(behind);
      else
        boundary = true;
    }
  return boundary;
}

Search::Connected Search::find_connected(const TreeCenter &center, const SumCenter &at, int32_t nearest) {
  const bool may_end = near_boundary(center.position);
  if (!may_end && is_one_piece(center, at, nearest)) return {true, false};
  start_flood(center.triangle);
  Connected connected{false, false};
  int32_t found = 0;
  for (size_t i = 0; i < reached_.size(); ++i) {
    if (reach_neighbors(reached_[i], center.position)) connected.boundary = true;
    if (may_end) continue;
    found += count_nearest_of(reached_[i], at);
    if (found == nearest) return {true, false};
  }
  for (const int32_t surfel : reached_) {
    stored_.take(samples_.first[surfel], samples_.first[surfel + 1]);
    if (const Range *range = find_divided(surfel)) divided_.take(range->begin, range->end);
  }
  stored_.hide_rest();
  divided_.hide_rest();
  return connected;
}

void Search::forget_connected() {
  stored_.show_all();
  divided_.show_all();
}

} // namespace paradesc
