// The flood spreads within balls first, where no edge needs a test. Then it crosses edges that the rims of balls cut.
#include "engine/cpu/group_flood.h"

#include <limits>
#include <utility>

namespace paradesc {

void GroupFlood::run(const TreeCenters &centers, std::span<const int32_t> chosen) {
  ++floods_;
  met_.clear();
  balls_.count = 0;
  constexpr float nowhere = 1e18f;
  for (auto &column : balls_.center) std::fill_n(column, max_balls, nowhere);
  for (const int32_t i : chosen) {
    for (int axis = 0; axis < 3; ++axis) balls_.center[axis][balls_.count] = centers[i].position[axis];
    ++balls_.count;
  }
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

// Returns the index of the surfel in met_.
size_t GroupFlood::meet(int32_t surfel) {
  Mark &mark = mark_[surfel];
  if (std::exchange(mark.flood, floods_) == floods_) return static_cast<size_t>(mark.place);
  mark.place = static_cast<int32_t>(met_.size());
  const Surfel &of = edges_.surfels.surfel[surfel];
  const BallBits bits = target_.find_balls(balls_, &of.position.x, of.reach);
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
  const uint64_t open = met_[rim.from].reached & ~met_[behind].reached & met_[behind].touched;
  uint64_t over = 0;
  for (int32_t k = edges_.surfels.edge_begin[rim.neighbor];
       k < edges_.surfels.edge_begin[rim.neighbor + 1] && (open & ~over) != 0; ++k) {
    const int32_t half_edge = edges_.surfels.edge[k];
    const vec3 from = edges_.source.position(half_edge), to = edges_.source.position(next_corner(half_edge));
    over |= open & target_.balls_of_edge(balls_, &from.x, &to.x);
  }
  if (over != 0) reach(behind, over);
}

} // namespace paradesc
