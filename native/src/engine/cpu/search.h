// A group of centers → the samples around them; and for a center whose ball may hold other pieces of surface, the samples of what
// is connected to it within the ball.
#pragma once

#include <span>
#include <vector>

#include "engine/cpu/groups.h"
#include "engine/cpu/surface_samples.h"

namespace paradesc {

// What one thread keeps from group to group.
class Search {
public:
  Search(const SurfelSource &source, const Surfels &surfels, const SurfaceSamples &samples, CountNearest count_nearest);

  // Looks around these centers. What follows is about them.
  void look(const std::vector<TreeCenter> &centers, std::span<const int32_t> group);

  // All samples that may lie in the ball of any center: those that are stored, and those of very large triangles. Valid until
  // look() is called again.
  SampleBlocks stored() const { return stored_.of(samples_.samples); }
  SampleBlocks divided() const { return divided_.of(divided_samples_); }

  struct Connected {
    bool all;      // all samples in the ball; if not, stored() and divided() have those alone until the next center
    bool boundary; // the mesh's boundary lies in the ball, and belongs to them
  };
  // What is connected to the center within its ball, over edges that meet it. nearest: on how many samples in the ball the
  // surface may come nearer to the center than around them.
  Connected find_connected(const TreeCenter &center, const SumCenter &at, int32_t nearest);
  // All samples again.
  void forget_connected();

private:
  // The samples of a very large triangle among those divided.
  struct Range {
    int32_t surfel, begin, end;
  };
  void find_cells(const std::vector<TreeCenter> &centers, std::span<const int32_t> group, float reach);
  void list_blocks(float reach);
  bool meets_ball(int32_t half_edge, vec3 center) const;
  bool near_boundary(vec3 center) const;
  const Range *find_divided(int32_t surfel) const;
  int32_t count_nearest_of(int32_t surfel, const SumCenter &at) const;
  void start_flood(int32_t triangle);
  void reach(int32_t surfel);
  bool reach_neighbors(int32_t surfel, vec3 center);
  bool is_one_piece(const TreeCenter &center, const SumCenter &at, int32_t nearest);

  const SurfelSource &source_;
  const Surfels &surfels_;
  const SurfaceSamples &samples_;
  CountNearest count_nearest_;
  vec3 middle_{0.0f};
  std::vector<int32_t> cells_;        // found, in their order
  std::vector<int32_t> mark_;         // (cells) the search that found it last
  std::vector<int32_t> boundary_;     // half-edges of the cells found
  std::vector<int32_t> reached_mark_; // (surfels) the flood that reached it last
  std::vector<int32_t> reached_;
  int32_t searches_ = 0, floods_ = 0;
  BlockSet stored_, divided_;
  Samples divided_samples_;
  std::vector<Range> divided_surfels_; // by their order
};

} // namespace paradesc
