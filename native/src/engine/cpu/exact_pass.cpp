// For each group: nearby patches → points in each ball → points connected to each center → sums → values.
#include "engine/cpu/exact_pass.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <string_view>

#include "descriptor/registry.h"
#include "engine/cpu/point_flood.h"
#include "support/parallel.h"
#include "support/pool.h"

namespace paradesc {

namespace {

// Samples with the sets of centers whose balls they meet → the samples of each center. Samples are given by index.
class SamplesOfCenters {
public:
  void clear() {
    for (Sets *const sets : {&first_, &rest_}) {
      sets->item.clear();
      sets->centers.clear();
    }
  }
  // first: those of the centers in whose lists the sample comes before all others.
  void append(size_t item, uint32_t centers, uint32_t first) {
    first_.append(item, centers & first);
    rest_.append(item, centers & ~first);
  }
  void distribute(const BallTarget &target, int32_t centers);
  // Returns the samples of a center, filled up with sample 0.
  SampleRun of(int32_t center) const { return {lists_.of_center[center], (count_[center] + block_lanes - 1) / block_lanes}; }

private:
  struct Sets {
    std::vector<int32_t> item, centers;
    void append(size_t sample, uint32_t of_centers) {
      if (of_centers == 0) return;
      item.push_back(static_cast<int32_t>(sample));
      centers.push_back(static_cast<int32_t>(of_centers));
    }
  };
  Sets first_, rest_;
  UnsetVector<int32_t> room_;
  CenterLists lists_{};
  int32_t count_[group_lanes] = {};
};

// The memory that one thread reuses from group to group.
class GroupWork {
public:
  explicit GroupWork(const ExactPass &pass);
  void evaluate(std::span<const int32_t> group, CenterResults &results);

private:
  FloodStart start_of(const CenterPoint &center) const;
  void place_centers(std::span<const int32_t> group);
  void find_patches();
  SphereSets sets_of(int32_t item) const;
  bool is_beyond(const FlatSample &sample, float reach) const;
  SphereSets sets_of_part(const FlatSample &part, uint32_t centers) const;
  uint32_t centers_beside(const FlatSample &sample) const;
  uint32_t clusters_at_boundary() const;
  void divide_large();
  void list_samples();
  void finish_center(int32_t lane, int32_t index, bool boundary, CenterResults &results);
  void add_samples(int32_t lane, const SumCenter &center, float *sums);
  void divide(int32_t triangle);
  void forget();

  const ExactPass &pass_;
  const PatchArrays &surface_;
  bool with_noise_, with_moments_;
  CenterLanes centers_{}, places_{}; // places_: with the radius 0
  FloodStart start_[group_lanes] = {};
  std::vector<int32_t> pieces_; // components that the centers lie on
  PointFlood flood_;
  std::vector<NearPatch> patch_;
  std::vector<uint16_t> in_, reached_; // (nodes + 1) 0 between groups
  std::vector<int32_t> node_;
  std::vector<uint16_t> cluster_whole_, cluster_part_;
  NearPatches near_{};
  UnsetVector<int32_t> list_items_;
  GroupLists lists_{};
  alignas(64) BallSums sums_{};
  std::vector<float> values_;
  SamplesOfCenters whole_, cut_;           // indices in sample_ and map_; cut: what may lie partly within a ball
  std::vector<const FlatSample *> sample_; // those in some ball, after one that is nothing
  std::vector<const SampleMap *> map_;
  SampleList divided_;                    // of very large triangles, which each group divides where they are near
  std::vector<int32_t> divided_begin_{0}; // (divided triangles + 1)
};

} // namespace

static void place_list(int32_t *&next, int32_t *&list, size_t size) { next = (list = next) + size; }

bool asks_for_noise(std::span<const int> rows) {
  return std::ranges::any_of(rows, [](int row) { return std::string_view(descriptor_row(row).name) == "standard_error"; });
}

GroupWork::GroupWork(const ExactPass &pass)
    : pass_(pass), surface_(pass.surface.arrays()), with_noise_(asks_for_noise(pass.rows)),
      with_moments_(pass.plan.kind == SumKind::fit), flood_(pass.patches, surface_, pass.target),
      patch_(static_cast<size_t>(pass.patches.patches())), in_(static_cast<size_t>(pass.patches.nodes()) + 1),
      reached_(in_.size()), node_(in_.size()), cluster_whole_(static_cast<size_t>(pass.patches.clusters())),
      cluster_part_(cluster_whole_.size()) {
  near_ = {patch_.data(), 0, in_.data(), reached_.data(), node_.data(), 0, cluster_whole_.data(), cluster_part_.data()};
  centers_.radius = pass.params.radius;
}

FloodStart GroupWork::start_of(const CenterPoint &center) const {
  const PointPatches &patches = pass_.patches;
  if (center.point >= 0) return {patches.node_of_point[center.point], -1};
  const int32_t triangle = patches.place[center.triangle];
  return {triangle < 0 ? patches.node_of_triangle[center.triangle] : -1, triangle};
}

void GroupWork::place_centers(std::span<const int32_t> group) {
  constexpr float nowhere = 1e15f;
  Bounds<vec3> bounds;
  centers_.count = static_cast<int32_t>(group.size());
  pieces_.clear();
  for (size_t i = 0; i < group_lanes; ++i) {
    const bool is_used = i < group.size();
    const CenterPoint center = is_used ? pass_.centers[group[i]] : CenterPoint{vec3(nowhere), vec3(0.0f), -1, -1};
    for (int axis = 0; axis < 3; ++axis) {
      centers_.position[axis][i] = center.position[axis];
      centers_.normal[axis][i] = center.normal[axis];
    }
    if (!is_used) continue;
    start_[i] = start_of(center);
    const int32_t piece = pass_.piece_of_triangle[center.triangle];
    if (std::ranges::find(pieces_, piece) == pieces_.end()) pieces_.push_back(piece);
    bounds.add(center.position);
  }
  for (int axis = 0; axis < 3; ++axis) centers_.middle[axis] = 0.5f * (bounds.low[axis] + bounds.high[axis]);
  centers_.spread = 0.5f * length(bounds.size());
  places_ = centers_;
  places_.radius = 0.0f;
}

static void place(int32_t *&next, CenterLists &lists, size_t size) {
  place_list(next, lists.item, size);
  place_list(next, lists.centers, size);
  for (int32_t *&list : lists.of_center) place_list(next, list, size);
}

// Also allocates the lists for as many items as these patches may lead to.
void GroupWork::find_patches() {
  near_.patches = pass_.target.find(surface_, centers_, patch_.data());
  const auto is_of_others = [&](const NearPatch &near) {
    return std::ranges::find(pieces_, pass_.patches.piece[near.patch]) == pieces_.end();
  };
  near_.patches =
      static_cast<int32_t>(std::remove_if(patch_.data(), patch_.data() + near_.patches, is_of_others) - patch_.data());
  if (!with_moments_) return;
  size_t triangles = 0;
  for (int32_t i = 0; i < near_.patches; ++i)
    for (const int32_t *const begin : {surface_.triangle_begin, surface_.cluster_begin})
      triangles += static_cast<size_t>(begin[patch_[i].patch + 1] - begin[patch_[i].patch]);
  const size_t wholes = triangles + static_cast<size_t>(near_.patches) + 2 * group_lanes,
               corners = 3 * triangles + 2 * group_lanes;
  const size_t room = 5 * wholes + (2 + group_lanes) * (wholes + 2 * corners);
  if (room > list_items_.size()) list_items_.resize(2 * room);
  int32_t *next = list_items_.data();
  place_list(next, lists_.touched.triangle, wholes);
  place_list(next, lists_.touched.turning, wholes);
  for (int32_t *&list : lists_.touched.corner) place_list(next, list, wholes);
  place(next, lists_.wholes, wholes);
  place(next, lists_.corners, corners);
  place(next, lists_.turning_corners, corners);
}

void SamplesOfCenters::distribute(const BallTarget &target, int32_t centers) {
  std::vector<int32_t> &item = first_.item, &sets = first_.centers;
  item.insert(item.end(), rest_.item.begin(), rest_.item.end());
  sets.insert(sets.end(), rest_.centers.begin(), rest_.centers.end());
  lists_.count = static_cast<int32_t>(item.size());
  const size_t room = item.size() + group_lanes;
  item.resize(room);
  sets.resize(room);
  lists_.item = item.data();
  lists_.centers = sets.data();
  if (room_.size() < group_lanes * room) room_.resize(2 * group_lanes * room);
  int32_t *next = room_.data();
  for (int32_t *&list : lists_.of_center) place_list(next, list, room);
  target.list(lists_, centers, count_);
  for (int32_t i = 0; i < centers; ++i) std::fill_n(lists_.of_center[i] + count_[i], block_lanes - 1, 0);
}

void GroupWork::evaluate(std::span<const int32_t> group, CenterResults &results) {
  place_centers(group);
  find_patches();
  pass_.target.look(surface_, centers_, near_);
  const uint32_t boundary = flood_.run(centers_, start_, near_) | clusters_at_boundary();
  if (with_moments_) pass_.target.add(surface_, centers_, near_, with_noise_, lists_, sums_);
  list_samples();
  for (size_t i = 0; i < group.size(); ++i) finish_center(static_cast<int32_t>(i), group[i], (boundary >> i & 1) != 0, results);
  forget();
}

// Returns the set of centers whose balls meet the mesh's boundary at clusters that they reach.
uint32_t GroupWork::clusters_at_boundary() const {
  const PointPatches &patches = pass_.patches;
  if (patches.rim.empty()) return 0;
  uint32_t found = 0;
  for (int32_t i = 0; i < near_.patches; ++i)
    for (int32_t k = patches.cluster_begin[near_.patch[i].patch]; k < patches.cluster_begin[near_.patch[i].patch + 1]; ++k)
      for (int32_t edge = patches.rim_begin[k]; edge < patches.rim_begin[k + 1]; ++edge) {
        found |= near_.whole[k];
        for (uint32_t bits = near_.part[k] & ~found; bits != 0; bits &= bits - 1) {
          const int lane = std::countr_zero(bits);
          const dvec3 center(centers_.position[0][lane], centers_.position[1][lane], centers_.position[2][lane]);
          const auto &[a, b] = pass_.surface.rim()[edge];
          const double square = segment_distance2(dvec3(a) - center, dvec3(b) - center), radius = centers_.radius;
          if (square < radius * radius) found |= uint32_t{1} << lane;
        }
      }
  return found;
}

// Returns the sets of centers whose balls contain all of a triangle or cluster, and a part of it. Whole clusters have moments.
SphereSets GroupWork::sets_of(int32_t item) const {
  if (item < 0) return {with_moments_ ? 0u : near_.whole[~item], near_.part[~item]};
  const int32_t *const corner = surface_.corner + 3 * static_cast<ptrdiff_t>(item);
  const uint32_t a = reached_[corner[0]], b = reached_[corner[1]], c = reached_[corner[2]], whole = a & b & c;
  return {whole, (a | b | c | flood_.dipped(item)) & ~whole};
}

// Divides the very large triangles that some ball may meet.
void GroupWork::divide_large() {
  for (int32_t i = 0; i < near_.patches; ++i)
    for_each_item(pass_.samples, near_.patch[i].patch, [&](const SampleBlock &block, int32_t k) {
      if (!block.is_divided(k)) return;
      if (const auto [whole, part] = sets_of(block.item[k]); (whole | part) != 0) divide(block.item[k]);
    });
}

// Lists the samples of what is summed one by one for each center, in its order.
void GroupWork::list_samples() {
  static const FlatSample nothing{};
  static const SampleMap no_map{};
  const bool has_map = pass_.sampled.map != nullptr;
  divide_large();
  whole_.clear();
  cut_.clear();
  sample_.assign(1, &nothing);
  map_.assign(has_map ? 1 : 0, &no_map);
  const auto add = [&](const SampleList &list, int32_t i, const SphereSets &sets) {
    if ((sets.within | sets.touched) == 0) return;
    // The kernel that adds to moments takes single samples as cut ones only.
    whole_.append(sample_.size(), with_moments_ ? 0 : sets.within, centers_beside(list.sample[i]));
    cut_.append(sample_.size(), with_moments_ ? sets.within | sets.touched : sets.touched, 0);
    sample_.push_back(&list.sample[i]);
    if (has_map) map_.push_back(&list.map[i]);
  };
  size_t next_divided = 0;
  const auto add_item = [&](const SampleBlock &block, int32_t k) {
    const SphereSets sets = sets_of(block.item[k]);
    if ((sets.within | sets.touched) == 0) return;
    const bool divided = block.is_divided(k);
    const SampleList &list = divided ? divided_ : block.list;
    const int32_t first = divided ? divided_begin_[next_divided] : block.first[k],
                  last = divided ? divided_begin_[next_divided + 1] : block.first[k + 1];
    next_divided += divided;
    if (last - first == 1) return add(list, first, sets);
    for (int32_t run = first; run < last; run += samples_of_run) {
      if (!divided && is_beyond(list.sample[run], list.sample[run].run_reach)) continue;
      for (int32_t part = run; part < std::min(run + samples_of_run, last); ++part)
        add(list, part, sets_of_part(list.sample[part], sets.within | sets.touched));
    }
  };
  for (int32_t i = 0; i < near_.patches; ++i) for_each_item(pass_.samples, near_.patch[i].patch, add_item);
  whole_.distribute(pass_.target, centers_.count);
  cut_.distribute(pass_.target, centers_.count);
}

// Returns the centers that lie beside a sample, where turning normals take more places. Blocks of such samples are fewest if they
// come first.
uint32_t GroupWork::centers_beside(const FlatSample &sample) const {
  constexpr float beside = 1.75f; // of the reach
  return pass_.plan.bending ? pass_.target.sphere(places_, sample.position, beside * sample.reach).touched : 0;
}

// Returns whether no ball meets what lies within `reach` of the sample's position.
bool GroupWork::is_beyond(const FlatSample &sample, float reach) const {
  float square = 0.0f;
  for (int axis = 0; axis < 3; ++axis) {
    const float gap = sample.position[axis] - centers_.middle[axis];
    square += gap * gap;
  }
  const float far = centers_.spread + centers_.radius + reach;
  return square > far * far;
}

// Returns the centers whose balls contain this part of a triangle, and those whose balls may cut it. centers: those from which
// the triangle is reached.
SphereSets GroupWork::sets_of_part(const FlatSample &part, uint32_t centers) const {
  if (is_beyond(part, part.reach)) return {};
  const auto [within, touched] = pass_.target.sphere(centers_, part.position, part.reach);
  return {within & centers, touched & ~within & centers};
}

// Divides a very large triangle where it is near the group.
void GroupWork::divide(int32_t triangle) {
  const vec3 middle(centers_.middle[0], centers_.middle[1], centers_.middle[2]);
  divide_triangle(pass_.sampled.triangle(triangle), pass_.limit, {middle, centers_.spread + centers_.radius},
                  pass_.sampled.map != nullptr, divided_);
  divided_begin_.push_back(static_cast<int32_t>(divided_.sample.size()));
}

// Adds the sums over the samples of the center.
void GroupWork::add_samples(int32_t lane, const SumCenter &center, float *sums) {
  const SelectedSamples selected{sample_.data(), map_.data(), whole_.of(lane), cut_.of(lane), pass_.plan.bending};
  if (selected.whole.blocks + selected.cut.blocks == 0) return;
  float listed[max_sums] = {};
  pass_.sum_target.by_kind[static_cast<size_t>(pass_.plan.kind)](pass_.params, selected, center, listed);
  for (size_t k = 0; k < max_sums; ++k) sums[k] += listed[k];
}

void GroupWork::finish_center(int32_t lane, int32_t index, bool boundary, CenterResults &results) {
  const auto at = static_cast<size_t>(index);
  SumCenter center{};
  for (int axis = 0; axis < 3; ++axis) {
    center.position[axis] = centers_.position[axis][lane];
    center.normal[axis] = centers_.normal[axis][lane];
  }
  if (!pass_.map.empty()) center.value = pass_.map[at].w;
  float sums[max_sums] = {};
  if (with_moments_) { // The order is that of the kernel's Moments.
    constexpr size_t places[ball_sums] = {0, 1, 2, 3, 4, 5, 6, 9, 10};
    for (size_t k = 0; k < ball_sums; ++k) sums[places[k]] = sums_[k][lane];
  }
  add_samples(lane, center, sums);
  results.boundary[at] = boundary;
  values_.clear();
  finish(pass_.plan, pass_.params, center, sums, boundary, pass_.rows, values_);
  for (size_t k = 0, next = 0; k < pass_.rows.size(); ++k) {
    const auto components = static_cast<size_t>(descriptor_row(pass_.rows[k]).components);
    std::copy_n(&values_[next], components, &results.values[k][at * components]);
    next += components;
  }
}

void GroupWork::forget() {
  for (int32_t i = 0; i < near_.patches; ++i) {
    const auto begin = surface_.patch_begin[patch_[i].patch], end = surface_.patch_begin[patch_[i].patch + 1];
    std::fill(&in_[begin], &in_[end], uint16_t{0});
    std::fill(&reached_[begin], &reached_[end], uint16_t{0});
  }
  flood_.forget();
  divided_begin_.resize(1);
  divided_.sample.clear();
  divided_.map.clear();
}

void evaluate_exactly(const ExactPass &pass, CenterResults &results) {
  constexpr int groups_of_block = 8;
  const auto groups = static_cast<int>(pass.groups.begin.size()) - 1;
  std::atomic<int> done{0};
  const CancelScope cancel([&] { pass.progress(static_cast<double>(done) / std::max(groups, 1)); });
  Pool<GroupWork> works;
  parallel_blocks(groups, pass.threads, groups_of_block, [&](int begin, int end) {
    works.with_one([&] { return GroupWork(pass); },
                   [&](GroupWork &work) {
                     for (int g = begin; g < end; ++g) {
                       checkpoint(); // One group alone may take milliseconds.
                       const auto first = static_cast<size_t>(pass.groups.begin[g]);
                       work.evaluate(std::span(pass.groups.center).subspan(first, pass.groups.begin[g + 1] - first), results);
                       ++done;
                     }
                   });
  });
}

} // namespace paradesc
