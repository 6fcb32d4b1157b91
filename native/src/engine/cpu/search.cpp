// Finds cells by their links, blocks by their bounding spheres, and then surfels by the edges between them.
#include "engine/cpu/search.h"

#include <algorithm>
#include <bit>
#include <functional>
#include <iterator>
#include <limits>

namespace paradesc {

Search::Search(const SurfelSource &source, const Surfels &surfels, const SurfaceSamples &samples, const SumTarget &target,
               bool by_blocks)
    : source_(source), surfels_(surfels), samples_(samples), target_(target), by_blocks_(by_blocks), edges_{source, surfels},
      cell_mark_(surfels.cell_sphere.size(), 0), mark_(surfels.surfel.size(), 0), flood_(edges_, target) {}

void Search::look(const TreeCenters &centers, std::span<const int32_t> group) {
  vec3 low(std::numeric_limits<float>::max()), high(-low);
  for (const int32_t i : group) {
    low = glm::min(low, centers[i].position);
    high = glm::max(high, centers[i].position);
  }
  middle_ = 0.5f * (low + high);
  const float reach = surfels_.radius + 0.5f * length(high - low);
  find_cells(centers, group, reach);
  list_candidates(reach);
}

// Finds all cells that are linked to the group's own cells via cells that may meet the balls of its centers.
void Search::find_cells(const TreeCenters &centers, std::span<const int32_t> group, float reach) {
  ++groups_;
  cells_.clear();
  const auto add = [&](int32_t cell) {
    if (std::exchange(cell_mark_[cell], groups_) != groups_) cells_.push_back(cell);
  };
  for (const int32_t i : group) add(surfels_.triangle_cell[centers[i].triangle]);
  for (size_t i = 0; i < cells_.size(); ++i)
    for (int32_t k = surfels_.link_begin[cells_[i]]; k < surfels_.link_begin[cells_[i] + 1]; ++k) {
      const int32_t other = surfels_.link[k];
      if (cell_mark_[other] == groups_) continue;
      const vec4 sphere = surfels_.cell_sphere[other];
      const vec3 gap = vec3(sphere) - middle_;
      const float limit = reach + sphere.w;
      if (dot(gap, gap) < limit * limit) add(other);
    }
  std::sort(cells_.begin(), cells_.end()); // The order of summation is independent of where the search began.
}

void Search::list_candidates(float reach) {
  blocks_.clear();
  block_samples_.clear();
  block_maps_.clear();
  boundary_.clear();
  for (auto &column : spheres_) column.clear();
  for (const int32_t cell : cells_) {
    for (int32_t i = samples_.cell_block[cell]; i < samples_.cell_block[cell + 1]; ++i)
      add_block(samples_.list, static_cast<size_t>(samples_.block_begin[i]), samples_.block[i], samples_.sphere[i], reach);
    boundary_.insert(boundary_.end(), surfels_.boundary.begin() + surfels_.boundary_begin[cell],
                     surfels_.boundary.begin() + surfels_.boundary_begin[cell + 1]);
  }
  add_divided(reach);
  const size_t padded = (blocks_.size() + block_lanes - 1) / block_lanes * block_lanes;
  constexpr float nowhere = 1e18f;
  for (auto &column : spheres_) column.resize(padded, nowhere);
  spheres_[3].resize(blocks_.size());
  spheres_[3].resize(padded, 0.0f);
  parts_.resize(blocks_.size());
  for (auto *list : {&whole_, &cut_, &nearest_}) list->resize(blocks_.size() * block_lanes);
  for (auto *list : {&whole_samples_, &cut_samples_}) list->resize(blocks_.size() * block_lanes);
  for (auto *list : {&whole_maps_, &cut_maps_}) list->resize(block_maps_.size() * block_lanes);
}

// Adds a block unless it is too far away.
void Search::add_block(const SampleList &list, size_t first, const SampleBlock &block, vec4 sphere, float reach) {
  const vec3 gap = vec3(sphere) - middle_;
  const float limit = reach + sphere.w;
  if (!(dot(gap, gap) < limit * limit)) return;
  blocks_.push_back(&block);
  block_samples_.push_back(&list.sample[first]);
  if (!list.map.empty()) block_maps_.push_back(&list.map[first]);
  for (int i = 0; i < 4; ++i) spheres_[i].push_back(sphere[i]);
}

// Divides very large triangles, each of which is a cell of its own.
void Search::add_divided(float reach) {
  divided_ = {};
  divided_blocks_.clear();
  for (const int32_t cell : cells_) {
    const int32_t first = surfels_.cell_begin[cell];
    if (surfels_.surfel[first].samples > max_stored_samples) divide_triangle(source_, surfels_, first, middle_, reach, divided_);
  }
  const auto of_block = [&](size_t first) {
    return std::span(divided_.sample).subspan(first, std::min<size_t>(block_lanes, divided_.sample.size() - first));
  };
  for (size_t first = 0; first < divided_.sample.size(); first += block_lanes)
    divided_blocks_.push_back(block_of(of_block(first)));
  for (size_t first = 0; first < divided_.sample.size(); first += block_lanes)
    add_block(divided_, first, divided_blocks_[first / block_lanes], sphere_of(of_block(first)), reach);
}

// Most centers can prove quickly that all surface in their balls is connected. The others share one flood. If most of the first
// centers need the flood, all later ones use it, too.
void Search::find_each(const TreeCenters &centers, std::span<const int32_t> group, const UseFound &use) {
  static_assert(max_centers <= max_balls);
  constexpr size_t enough = 4;
  unclear_.clear();
  for (size_t k = 0; k < group.size(); ++k) {
    const TreeCenter &center = centers[group[k]];
    const bool most_are_unclear = k >= enough && 2 * unclear_.size() > k;
    if (!most_are_unclear) select_around(center.position);
    if (!most_are_unclear && boundary_in_ball_.empty() && is_one_piece(center))
      use(group[k], found(false));
    else
      unclear_.push_back(group[k]);
  }
  if (unclear_.empty()) return;
  flood_.run(centers, unclear_);
  missed_.assign(blocks_.size(), std::nullopt);
  for (size_t k = 0; k < unclear_.size(); ++k) {
    select_around(centers[unclear_[k]].position);
    keep_reached(k);
    use(unclear_[k], found(std::ranges::any_of(boundary_in_ball_, [&](int32_t half_edge) {
          return flood_.is_reached(surfels_.triangle_surfel[half_edge / 3], k);
        })));
  }
}

void Search::select_around(vec3 center) {
  const auto column = [&](size_t i) { return spheres_[i].data(); };
  const Candidates candidates{
      blocks_.data(), {column(0), column(1), column(2), column(3)}, static_cast<int32_t>(spheres_[0].size())};
  selection_ = {parts_.data(), cut_.data(), nearest_.data(), 0, 0, 0};
  target_.select(candidates, &center.x, surfels_.radius, selection_);
  boundary_in_ball_.clear();
  std::ranges::copy_if(boundary_, std::back_inserter(boundary_in_ball_),
                       [&](int32_t edge) { return edges_.meets(edge, center); });
}

// Returns the current selection.
Search::Found Search::found(bool boundary) {
  Found found{{}, boundary};
  if (by_blocks_)
    found.samples.parts = std::span(parts_).first(static_cast<size_t>(selection_.wholes));
  else
    found.samples.whole = take(whole_, list_wholes(), whole_samples_, whole_maps_);
  found.samples.block = blocks_.data();
  found.samples.cut = take(cut_, selection_.cuts, cut_samples_, cut_maps_);
  return found;
}

// Returns GroupFlood::missed() for all samples of a block together.
uint64_t Search::missed_of(int32_t block) {
  std::optional<uint64_t> &missed = missed_[block];
  if (missed) return *missed;
  missed = 0;
  for (int32_t i = 0; i < block_lanes; ++i)
    if (blocks_[block]->area[i] > 0.0f) *missed |= flood_.missed(candidate(block * block_lanes + i).surfel);
  return *missed;
}

// Removes samples from the selection that the flood did not reach from the center with this number.
void Search::keep_reached(size_t number) {
  const auto misses = [&](int32_t block) { return (missed_of(block) >> number & 1) != 0; };
  const auto is_kept = [&](int32_t sample) {
    return !misses(sample / block_lanes) || flood_.is_reached(candidate(sample).surfel, number);
  };
  for (int32_t i = 0; i < selection_.wholes; ++i) {
    if (!misses(parts_[i].block)) continue;
    for (uint32_t bits = parts_[i].samples; bits != 0; bits &= bits - 1)
      if (!is_kept(parts_[i].block * block_lanes + std::countr_zero(bits))) parts_[i].samples &= ~(bits & -bits);
  }
  const auto end = std::remove_if(cut_.begin(), cut_.begin() + selection_.cuts, std::not_fn(is_kept));
  selection_.cuts = static_cast<int32_t>(end - cut_.begin());
}

// Lists the samples of all parts one by one, and returns their number.
int32_t Search::list_wholes() {
  int32_t count = 0;
  for (int32_t i = 0; i < selection_.wholes; ++i)
    for (uint32_t bits = parts_[i].samples; bits != 0; bits &= bits - 1)
      whole_[count++] = parts_[i].block * block_lanes + std::countr_zero(bits);
  return count;
}

SampleRun Search::take(const std::vector<int32_t> &list, int32_t count, std::vector<const FlatSample *> &samples,
                       std::vector<const SampleMap *> &maps) const {
  static const FlatSample nothing{};
  static const SampleMap no_map{};
  const int32_t blocks = (count + block_lanes - 1) / block_lanes;
  for (int32_t i = 0; i < count; ++i) samples[i] = &candidate(list[i]);
  std::fill(samples.begin() + count, samples.begin() + blocks * block_lanes, &nothing);
  if (block_maps_.empty()) return {samples.data(), nullptr, blocks};
  for (int32_t i = 0; i < count; ++i) maps[i] = block_maps_[list[i] / block_lanes] + list[i] % block_lanes;
  std::fill(maps.begin() + count, maps.begin() + blocks * block_lanes, &no_map);
  return {samples.data(), maps.data(), blocks};
}

// Returns the squared distance of a triangle from the origin, measured within the triangle's plane only.
static float square_in_plane(const std::array<vec3, 3> &corners, vec3 normal) {
  float nearest = std::numeric_limits<float>::max();
  bool over = true;
  for (int k = 0; k < 3; ++k) {
    const vec3 a = corners[k], way = corners[next_corner(k)] - a, across = cross(way, normal);
    const float length = dot(way, way), along = -dot(a, way), outside = -dot(a, across);
    over = over && outside <= 0.0f;
    const vec3 gap = a + way * (length > 0.0f ? std::clamp(along / length, 0.0f, 1.0f) : 0.0f);
    const float height = dot(gap, normal);
    nearest = std::min(nearest, dot(gap, gap) - height * height);
  }
  return over ? 0.0f : std::max(nearest, 0.0f);
}

// This test is more precise than that of select(), which considers the sample's bounding circle only.
bool Search::may_be_nearest(const FlatSample &sample, vec3 center) const {
  const Surfel &surfel = surfels_.surfel[sample.surfel];
  if (surfel.cluster >= 0 || edges_.lies_within(sample.surfel, center)) return true;
  const vec3 normal(sample.face[0], sample.face[1], sample.face[2]);
  const std::array<vec3, 3> corners = corners_of(sample, center);
  const float height = dot(corners[0], normal), across = square_in_plane(corners, normal);
  const float turned = sample.turn * std::abs(height) + 0.001f * sample.reach;
  return across <= turned * turned && across + height * height < 1.0001f * surfels_.radius * surfels_.radius;
}

void Search::reach(int32_t surfel) {
  if (std::exchange(mark_[surfel], walks_) != walks_) reached_.push_back(surfel);
}

// A piece of surface that is not connected to the center has a point nearest to it. So no such piece exists if all samples that
// may contain such a point are connected to the center. Returns false if that cannot be proved quickly.
bool Search::is_one_piece(const TreeCenter &center) {
  ++walks_;
  reached_.assign(1, surfels_.triangle_surfel[center.triangle]);
  mark_[reached_[0]] = walks_;
  size_t left = 0;
  // Expands from the center's surfel by up to two rings of neighbors, only as far as needed.
  auto is_around = [&, rings = 0](int32_t surfel) mutable {
    for (; !is_reached(surfel) && rings < 2; ++rings)
      for (const size_t end = reached_.size(); left < end; ++left) reach_neighbors(reached_[left], center.position);
    return is_reached(surfel);
  };
  for (int32_t i = 0; i < selection_.nearests; ++i) {
    const FlatSample &sample = candidate(nearest_[i]);
    if (is_around(sample.surfel) || !may_be_nearest(sample, center.position)) continue;
    if (!walk_to_reached(sample.surfel, center.position)) return false;
  }
  return true;
}

// Walks across edges that meet the ball to neighbors that are nearer and nearer to the center, until one is reached. Then marks
// the whole way as reached. Returns false if no neighbor is nearer.
bool Search::walk_to_reached(int32_t surfel, vec3 center) {
  way_.assign(1, surfel);
  for (float least = edges_.square_to(surfel, center);;) {
    const int32_t at = way_.back();
    const bool is_inside = edges_.lies_within(at, center);
    int32_t nearest = -1;
    for (int32_t k = surfels_.neighbor_begin[at]; k < surfels_.neighbor_begin[at + 1]; ++k) {
      const int32_t next = surfels_.neighbor[k];
      const float square = edges_.square_to(next, center);
      if (!is_reached(next) && !(square < least)) continue;
      if (!is_inside && !edges_.lies_within(next, center) && !edges_.meets_between(k, center)) continue;
      if (is_reached(next)) {
        for (const int32_t passed : way_) reach(passed);
        return true;
      }
      least = square;
      nearest = next;
    }
    if (nearest < 0) return false;
    way_.push_back(nearest);
  }
}

void Search::reach_neighbors(int32_t surfel, vec3 center) {
  const bool is_inside = edges_.lies_within(surfel, center);
  for (int32_t k = surfels_.neighbor_begin[surfel]; k < surfels_.neighbor_begin[surfel + 1]; ++k) {
    const int32_t behind = surfels_.neighbor[k];
    if (is_reached(behind)) continue;
    if (is_inside || edges_.lies_within(behind, center) || edges_.meets_between(k, center)) reach(behind);
  }
}

} // namespace paradesc
