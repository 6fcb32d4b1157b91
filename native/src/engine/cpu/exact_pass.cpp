// For each group: nearby patches → points in each ball → points connected to each center → sums → values.
#include "engine/cpu/exact_pass.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string_view>

#include "descriptor/registry.h"
#include "engine/cpu/point_flood.h"
#include "support/parallel.h"
#include "support/pool.h"

namespace paradesc {

namespace {

// The memory that one thread reuses from group to group.
class GroupWork {
public:
  explicit GroupWork(const ExactPass &pass);
  void evaluate(int32_t group, CenterResults &results);

private:
  void place_centers(int32_t first, int32_t count);
  void find_patches();
  void finish_center(int32_t lane, int32_t point, bool boundary, CenterResults &results);
  void forget();

  const ExactPass &pass_;
  const PatchArrays &surface_;
  bool with_noise_;
  CenterLanes centers_{};
  PointFlood flood_;
  std::vector<int32_t> patch_;
  std::vector<Nearness> nearness_;
  std::vector<uint16_t> in_, reached_; // (points + 1) 0 between groups
  std::vector<int32_t> point_;
  NearPatches near_{};
  UnsetVector<int32_t> list_items_;
  GroupLists lists_{};
  alignas(64) BallSums sums_{};
  std::vector<float> values_;
};

} // namespace

bool asks_for_noise(std::span<const int> rows) {
  return std::ranges::any_of(rows, [](int row) { return std::string_view(descriptor_row(row).name) == "standard_error"; });
}

GroupWork::GroupWork(const ExactPass &pass)
    : pass_(pass), surface_(pass.surface.arrays()), with_noise_(asks_for_noise(pass.rows)),
      flood_(pass.patches, surface_, pass.target), patch_(static_cast<size_t>(pass.patches.patches())), nearness_(patch_.size()),
      in_(static_cast<size_t>(pass.patches.points()) + 1), reached_(in_.size()), point_(in_.size()) {
  near_ = {patch_.data(), nearness_.data(), 0, in_.data(), reached_.data(), point_.data(), 0};
  centers_.radius = pass.params.radius;
}

void GroupWork::place_centers(int32_t first, int32_t count) {
  constexpr float nowhere = 1e15f;
  vec3 low(nowhere), high(-nowhere);
  centers_.count = count;
  for (int axis = 0; axis < 3; ++axis)
    for (int32_t i = 0; i < group_lanes; ++i) {
      const float position = surface_.position[axis][first + i];
      centers_.position[axis][i] = i < count ? position : nowhere;
      centers_.normal[axis][i] = i < count ? pass_.surface.normal(axis)[first + i] : 0.0f;
      if (i >= count) continue;
      low[axis] = std::min(low[axis], position);
      high[axis] = std::max(high[axis], position);
    }
  for (int axis = 0; axis < 3; ++axis) centers_.middle[axis] = 0.5f * (low[axis] + high[axis]);
  centers_.spread = 0.5f * length(high - low);
}

// Also allocates the lists for as many items as these patches may lead to.
void GroupWork::find_patches() {
  near_.patches = pass_.target.find(surface_, centers_, patch_.data());
  size_t triangles = 0;
  for (int32_t i = 0; i < near_.patches; ++i)
    triangles += static_cast<size_t>(surface_.triangle_begin[patch_[i] + 1] - surface_.triangle_begin[patch_[i]]);
  const size_t wholes = triangles + static_cast<size_t>(near_.patches) + 2 * group_lanes,
               corners = 3 * triangles + 2 * group_lanes;
  const size_t room = 4 * wholes + (2 + group_lanes) * (wholes + corners);
  if (room > list_items_.size()) list_items_.resize(2 * room);
  int32_t *next = list_items_.data();
  const auto place_list = [&](int32_t *&list, size_t size) { next = (list = next) + size; };
  const auto place = [&](CenterLists &of, size_t size) {
    place_list(of.item, size);
    place_list(of.centers, size);
    for (int32_t *&list : of.of_center) place_list(list, size);
  };
  place_list(lists_.touched.triangle, wholes);
  for (int32_t *&list : lists_.touched.corner) place_list(list, wholes);
  place(lists_.wholes, wholes);
  place(lists_.corners, corners);
}

void GroupWork::evaluate(int32_t group, CenterResults &results) {
  const int32_t first = pass_.patches.group_begin[group], count = pass_.patches.group_begin[group + 1] - first;
  place_centers(first, count);
  find_patches();
  pass_.target.look(surface_, centers_, near_);
  const uint32_t boundary = flood_.run(centers_, first, near_);
  pass_.target.add(surface_, centers_, near_, with_noise_, lists_, sums_);
  for (int32_t i = 0; i < count; ++i) finish_center(i, pass_.patches.point[first + i], (boundary >> i & 1) != 0, results);
  forget();
}

void GroupWork::finish_center(int32_t lane, int32_t point, bool boundary, CenterResults &results) {
  SumCenter center{};
  for (int axis = 0; axis < 3; ++axis) {
    center.position[axis] = centers_.position[axis][lane];
    center.normal[axis] = centers_.normal[axis][lane];
  }
  // The order is that of the kernel's Moments.
  const auto sum = [&](int k) { return sums_[k][lane]; };
  const float sums[max_sums] = {sum(0), sum(1), sum(2), sum(3), sum(4), sum(5), sum(6), 0.0f, 0.0f, sum(7), sum(8)};
  const auto index = static_cast<size_t>(point);
  results.boundary[index] = boundary;
  values_.clear();
  finish(pass_.plan, pass_.params, center, sums, boundary, pass_.rows, values_);
  for (size_t k = 0, next = 0; k < pass_.rows.size(); ++k) {
    const auto components = static_cast<size_t>(descriptor_row(pass_.rows[k]).components);
    std::copy_n(&values_[next], components, &results.values[k][index * components]);
    next += components;
  }
}

void GroupWork::forget() {
  for (int32_t i = 0; i < near_.patches; ++i) {
    const auto begin = surface_.patch_begin[patch_[i]], end = surface_.patch_begin[patch_[i] + 1];
    std::fill(&in_[begin], &in_[end], uint16_t{0});
    std::fill(&reached_[begin], &reached_[end], uint16_t{0});
  }
}

void evaluate_exactly(const ExactPass &pass, CenterResults &results) {
  constexpr int groups_of_block = 8;
  const int32_t groups = pass.patches.groups();
  std::atomic<int> done{0};
  const CancelScope cancel([&] { pass.progress(static_cast<double>(done) / std::max(groups, 1)); });
  Pool<GroupWork> works;
  parallel_blocks(groups, pass.threads, groups_of_block, [&](int begin, int end) {
    works.with_one([&] { return GroupWork(pass); },
                   [&](GroupWork &work) {
                     for (int g = begin; g < end; ++g) {
                       checkpoint(); // One group alone may take milliseconds.
                       work.evaluate(g, results);
                       ++done;
                     }
                   });
  });
}

} // namespace paradesc
