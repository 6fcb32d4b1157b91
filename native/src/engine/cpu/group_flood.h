// Several centers → the set of centers from which each surfel is reached within their balls. One flood serves all, with one bit
// each.
#pragma once

#include <span>
#include <vector>

#include "engine/cpu/add_samples.h"
#include "engine/cpu/ball_edges.h"
#include "engine/cpu/groups.h"

namespace paradesc {

// The memory that one thread reuses from group to group.
class GroupFlood {
public:
  GroupFlood(BallEdges edges, const SumTarget &target) : edges_(edges), target_(target), mark_(edges.surfels.surfel.size()) {}

  // Floods from the triangles of these centers, across edges that meet their balls.
  void run(const TreeCenters &centers, std::span<const int32_t> chosen);
  bool is_reached(int32_t surfel, size_t i) const { // from the center chosen[i]
    const Mark mark = mark_[surfel];
    return mark.flood == floods_ && (met_[mark.place].reached >> i & 1) != 0;
  }
  // Returns the set of centers whose balls the surfel may touch, although it is not reached from them.
  uint64_t missed(int32_t surfel) const {
    const Mark mark = mark_[surfel];
    return mark.flood == floods_ ? met_[mark.place].touched & ~met_[mark.place].reached : ~uint64_t{0};
  }

private:
  // A surfel that the flood has examined. The sets have one bit per center.
  struct Met {
    int32_t surfel;
    bool waits;               // its neighbors must be visited (again)
    uint64_t within, touched; // balls that it lies in, and balls that it touches
    uint64_t reached;
  };
  struct Rim {
    size_t from;
    int32_t neighbor; // index into Surfels::neighbor
  };

  size_t meet(int32_t surfel);
  void reach(size_t place, uint64_t centers);
  void leave(size_t place);
  void cross_rim(const Rim &rim);

  BallEdges edges_;
  SumTarget target_;
  Balls balls_{};
  struct Mark {
    int32_t flood = 0; // the last flood that examined the surfel
    int32_t place = 0; // index into met_
  };
  std::vector<Mark> mark_; // (surfels)
  int32_t floods_ = 0;
  std::vector<Met> met_;
  std::vector<size_t> waiting_; // indices into met_
  std::vector<Rim> rim_;
};

} // namespace paradesc
