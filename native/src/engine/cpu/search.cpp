// Cells by their links, then surfels by the edges between them.
#include "engine/cpu/search.h"

#include <algorithm>
#include <limits>

#include "sample/connected_triangles.h"

namespace paradesc {

Search::Search(const SurfelSource &source, const Surfels &surfels, const SurfaceSamples &samples)
    : source_(source), surfels_(surfels), samples_(samples), mark_(surfels.cell_sphere.size(), 0),
      first_here_(surfels.cell_sphere.size(), 0) {}

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
  linked_ = false;
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
  int32_t here = 0;
  for (const int32_t cell : cells_) {
    first_here_[cell] = here;
    const int32_t first = surfels_.cell_begin[cell], last = surfels_.cell_begin[cell + 1];
    here += last - first;
    const int32_t begin = samples_.first[first], end = samples_.first[last];
    if (begin < end)
      for (int32_t block = begin / block_lanes; block <= (end - 1) / block_lanes; ++block)
        if (stored_.empty() || stored_.last() < block) stored_.add(block, samples_.block_sphere[block], surfels_.radius);
    if (surfels_.surfel[first].samples > max_stored_samples) { // a cell of its own
      const int32_t before = divided_samples_.count();
      divide_triangle(source_, surfels_, first, middle_, reach, divided_samples_);
      divided_surfels_.push_back({here - 1, before, divided_samples_.count()});
    }
    for (int32_t k = surfels_.boundary_begin[cell]; k < surfels_.boundary_begin[cell + 1]; ++k) {
      const int32_t half_edge = surfels_.boundary[k];
      boundary_.push_back({-1, source_.position(half_edge), source_.position(next_corner(half_edge))});
    }
  }
  divided_samples_.fill_block();
  for (int32_t block = 0; block < divided_samples_.blocks(); ++block)
    divided_.add(block, divided_samples_.sphere(block), surfels_.radius);
}

bool Search::meets_ball(const Link &link, vec3 center) const {
  return segment_in_ball(link.from, link.to, center, surfels_.radius);
}

bool Search::near_boundary(const TreeCenter &center) const {
  return std::ranges::any_of(boundary_, [&](const Link &edge) { return meets_ball(edge, center.position); });
}

// -1: its cell was not found.
int32_t Search::number_here(int32_t surfel) const {
  const int32_t cell = surfels_.triangle_cell[source_.tree.triangle[surfels_.first[surfel]]];
  return mark_[cell] == searches_ ? first_here_[cell] + surfel - surfels_.cell_begin[cell] : -1;
}

void Search::link_surfel(int32_t surfel) {
  for (int32_t i = surfels_.first[surfel]; i < surfels_.first[surfel + 1]; ++i)
    for (int32_t half_edge = 3 * source_.tree.triangle[i]; half_edge < 3 * source_.tree.triangle[i] + 3; ++half_edge) {
      const int32_t twin = source_.half_edges.twin[half_edge];
      const int32_t behind = twin < 0 ? -1 : surfels_.triangle_surfel[twin / 3];
      if (behind == surfel) continue;
      const int32_t number = behind < 0 ? -1 : number_here(behind);
      if (behind >= 0 && number < 0) continue;
      link_.push_back({number, source_.position(half_edge), source_.position(next_corner(half_edge))});
    }
}

void Search::list_links() {
  link_.clear();
  link_begin_.assign(1, 0);
  for (const int32_t cell : cells_)
    for (int32_t k = surfels_.cell_begin[cell]; k < surfels_.cell_begin[cell + 1]; ++k) {
      link_surfel(k);
      link_begin_.push_back(static_cast<int32_t>(link_.size()));
    }
  reached_mark_.resize(std::max(reached_mark_.size(), link_begin_.size()), 0);
  linked_ = true;
}

Search::Connected Search::connected(const TreeCenter &center) {
  if (!linked_) list_links();
  ++floods_;
  reached_.clear();
  const auto reach = [&](int32_t surfel) {
    if (std::exchange(reached_mark_[surfel], floods_) != floods_) reached_.push_back(surfel);
  };
  Connected connected{};
  reach(number_here(surfels_.triangle_surfel[center.triangle]));
  for (size_t i = 0; i < reached_.size(); ++i)
    for (int32_t k = link_begin_[reached_[i]]; k < link_begin_[reached_[i] + 1]; ++k) {
      const Link &link = link_[k];
      if ((link.surfel >= 0 && reached_mark_[link.surfel] == floods_) || !meets_ball(link, center.position)) continue;
      if (link.surfel >= 0)
        reach(link.surfel);
      else
        connected.boundary = true;
    }
  list_reached();
  connected.samples = connected_.of(connected_samples_);
  return connected;
}

// The samples of the surfels that were reached.
void Search::list_reached() {
  std::sort(reached_.begin(), reached_.end());
  connected_samples_.clear(source_.map != nullptr);
  size_t cell = 0;
  for (const int32_t here : reached_) {
    while (cell + 1 < cells_.size() && first_here_[cells_[cell + 1]] <= here) ++cell;
    const int32_t surfel = surfels_.cell_begin[cells_[cell]] + here - first_here_[cells_[cell]];
    connected_samples_.append(samples_.samples, samples_.first[surfel], samples_.first[surfel + 1]);
    if (surfels_.surfel[surfel].samples <= max_stored_samples) continue;
    const Range &range = *std::ranges::lower_bound(divided_surfels_, here, {}, &Range::surfel);
    connected_samples_.append(divided_samples_, range.begin, range.end);
  }
  connected_samples_.fill_block();
  connected_.clear();
  for (int32_t block = 0; block < connected_samples_.blocks(); ++block)
    connected_.add(block, connected_samples_.sphere(block), surfels_.radius);
}

} // namespace paradesc
