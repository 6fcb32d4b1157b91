// Within balls first, where no edge has to be looked at; then over the edges that the rims of balls cut.
#include "engine/cpu/group_flood.h"

#include <bit>
#include <limits>
#include <utility>

namespace paradesc {

void GroupFlood::run(const TreeCenters &centers, std::span<const int32_t> chosen) {
  ++floods_;
  met_.clear();
  centers_.clear();
  constexpr float nowhere = 1e18f;
  for (auto &column : balls_.center) std::fill_n(column, max_balls, nowhere);
  for (const int32_t i : chosen) {
    for (int axis = 0; axis < 3; ++axis) balls_.center[axis][centers_.size()] = centers[i].position[axis];
    centers_.push_back(centers[i].position);
  }
  balls_.count = static_cast<int32_t>(centers_.size());
  balls_.radius = edges_.surfels.radius;
  for (size_t i = 0; i < chosen.size(); ++i)
    reach(meet(edges_.surfels.triangle_surfel[centers[chosen[i]].triangle]), uint64_t{1} << i);
  for (std::vector<Rim> rim; !waiting_.empty(); rim.clear()) {
    for (size_t i = 0; i < waiting_.size(); ++i) leave(waiting_[i]);
    waiting_.clear();
    rim.swap(rim_);
    for (const Rim &one : rim) cross_rim(one);
  }
}

// Returns its place.
size_t GroupFlood::meet(int32_t surfel) {
  Mark &mark = mark_[surfel];
  if (std::exchange(mark.flood, floods_) == floods_) return static_cast<size_t>(mark.place);
  mark.place = static_cast<int32_t>(met_.size());
  const Surfel &of = edges_.surfels.surfel[surfel];
  const BallBits bits = find_balls_(balls_, &of.position.x, of.reach);
  met_.push_back({surfel, false, bits.within, bits.touched, 0});
  return met_.size() - 1;
}

void GroupFlood::reach(size_t place, uint64_t centers) {
  Met &met = met_[place];
  met.reached |= centers;
  if (!std::exchange(met.waits, true)) waiting_.push_back(place);
}

void GroupFlood::leave(size_t place) {
  met_[place].waits = false;
  const auto [surfel, waits, within, touched, reached] = met_[place];
  for (int32_t k = edges_.surfels.neighbor_begin[surfel]; k < edges_.surfels.neighbor_begin[surfel + 1]; ++k) {
    const size_t behind = meet(edges_.surfels.neighbor[k]);
    const Met &other = met_[behind];
    const uint64_t open = reached & ~other.reached, over = open & (within | other.within);
    if ((open & ~over & other.touched) != 0) rim_.push_back({place, k});
    if (over != 0) reach(behind, over);
  }
}

void GroupFlood::cross_rim(const Rim &rim) {
  const size_t behind = meet(edges_.surfels.neighbor[rim.neighbor]);
  uint64_t over = 0;
  for (uint64_t open = met_[rim.from].reached & ~met_[behind].reached & met_[behind].touched; open != 0; open &= open - 1)
    if (edges_.meets_between(rim.neighbor, centers_[static_cast<size_t>(std::countr_zero(open))])) over |= open & -open;
  if (over != 0) reach(behind, over);
}

} // namespace paradesc
