// Cells by their links, then surfels by the edges between them.
#include "engine/cpu/search.h"

#include <algorithm>
#include <limits>

#include "sample/connected_triangles.h"

namespace paradesc {

Search::Search(const SurfelSource &source, const Surfels &surfels, const SurfaceSamples &samples)
    : source_(source), surfels_(surfels), samples_(samples), mark_(surfels.cell_sphere.size(), 0),
      nearest_of_surfel_(surfels.surfel.size(), 0), reached_mark_(surfels.surfel.size(), 0) {}

void Search::look(const std::vector<TreeCenter> &centers, std::span<const int32_t> group) {
  vec3 low(std::numeric_limits<float>::max()), high(-low);
  for (const int32_t i : group) {
    low = glm::min(low, centers[i].position);
    high = glm::max(high, centers[i].position);
  }
  middle_ = 0.5f * (low + high);
  const float reach = surfels_.radius + 0.5f * length(high - low);
  find_cells(centers, group, reach);
  list_samples(reach);
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

void Search::list_samples(float reach) {
  for (const int32_t surfel : nearest_surfels_) nearest_of_surfel_[surfel] = 0;
  nearest_surfels_.clear();
  noted_ = false;
  found_.clear();
  divided_.clear();
  boundary_.clear();
  for (const int32_t cell : cells_) { // very large triangles, each a cell of its own, before any of them is pointed to
    const int32_t first = surfels_.cell_begin[cell];
    if (surfels_.surfel[first].samples > max_stored_samples) divide_triangle(source_, surfels_, first, middle_, reach, divided_);
  }
  size_t next = 0;
  for (const int32_t cell : cells_) {
    const int32_t first = surfels_.cell_begin[cell], last = surfels_.cell_begin[cell + 1];
    for (int32_t i = samples_.first[first]; i < samples_.first[last]; ++i) add_sample(samples_.sample[i], reach);
    for (; next < divided_.size() && divided_[next].surfel == first; ++next) add_sample(divided_[next], reach);
    boundary_.insert(boundary_.end(), surfels_.boundary.begin() + surfels_.boundary_begin[cell],
                     surfels_.boundary.begin() + surfels_.boundary_begin[cell + 1]);
  }
  shown_.assign(found_.size(), 0xffff);
  nearest_.resize(found_.size());
}

void Search::add_sample(const FlatSample &sample, float reach) {
  const float x = sample.position[0] - middle_.x, y = sample.position[1] - middle_.y, z = sample.position[2] - middle_.z;
  const float limit = 1.00001f * (reach + sample.reach);
  if (x * x + y * y + z * z < limit * limit) found_.push_back(&sample);
}

bool Search::meets_ball(int32_t half_edge, vec3 center) const {
  return segment_in_ball(source_.position(half_edge), source_.position(next_corner(half_edge)), center, surfels_.radius);
}

bool Search::near_boundary(vec3 center) const {
  return std::ranges::any_of(boundary_, [&](int32_t half_edge) { return meets_ball(half_edge, center); });
}

void Search::note_nearest() {
  if (std::exchange(noted_, true)) return;
  for (size_t i = 0; i < found_.size(); ++i) {
    if (nearest_[i] == 0) continue;
    uint16_t &of_surfel = nearest_of_surfel_[found_[i]->surfel];
    if (of_surfel == 0) nearest_surfels_.push_back(found_[i]->surfel);
    of_surfel = static_cast<uint16_t>(of_surfel | nearest_[i]);
  }
}

int32_t Search::count_nearest(int lane) const {
  return static_cast<int32_t>(
      std::ranges::count_if(nearest_surfels_, [&](int32_t surfel) { return (nearest_of_surfel_[surfel] >> lane & 1) != 0; }));
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
bool Search::is_one_piece(const TreeCenter &center, int lane, int32_t nearest) {
  start_flood(center.triangle);
  int32_t found = 0;
  size_t around = 1; // the center's own surfel, and those around it
  for (size_t i = 0; i < reached_.size() && found < nearest; ++i) {
    const int32_t surfel = reached_[i];
    const bool may_be_nearest = (nearest_of_surfel_[surfel] >> lane & 1) != 0;
    const bool is_empty = samples_.first[surfel] == samples_.first[surfel + 1];
    if (may_be_nearest) ++found;
    if (i >= around && !may_be_nearest && !is_empty) continue;
    if (surfels_.surfel[surfel].level == 0)
      reach_neighbors(surfel, center.position);
    else // clusters are small
      for (int32_t k = surfels_.neighbor_begin[surfel]; k < surfels_.neighbor_begin[surfel + 1]; ++k) reach(surfels_.neighbor[k]);
    if (i == 0) around = reached_.size();
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

Search::Connected Search::find_connected(const TreeCenter &center, int lane) {
  note_nearest();
  const int32_t nearest = count_nearest(lane);
  const bool may_end = near_boundary(center.position);
  if (!may_end && is_one_piece(center, lane, nearest)) return {true, false};
  start_flood(center.triangle);
  Connected connected{false, false};
  int32_t found = 0;
  for (size_t i = 0; i < reached_.size(); ++i) {
    if (reach_neighbors(reached_[i], center.position)) connected.boundary = true;
    if ((nearest_of_surfel_[reached_[i]] >> lane & 1) != 0) ++found;
    if (!may_end && found == nearest) return {true, false};
  }
  for (size_t i = 0; i < found_.size(); ++i)
    if (reached_mark_[found_[i]->surfel] != floods_) shown_[i] = static_cast<uint16_t>(shown_[i] & ~(1u << lane));
  return connected;
}

} // namespace paradesc
