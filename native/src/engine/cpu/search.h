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
  Search(const SurfelSource &source, const Surfels &surfels, const SurfaceSamples &samples);

  // Looks around these centers. What follows is about them.
  void look(const std::vector<TreeCenter> &centers, std::span<const int32_t> group);

  // All samples that may lie in the ball of any center: those that are stored, and those of very large triangles. Valid until
  // look() is called again.
  SampleBlocks stored() const { return stored_.of(samples_.samples); }
  SampleBlocks divided() const { return divided_.of(divided_samples_); }

  // Whether the mesh's boundary lies in the center's ball; it may lie on a piece of surface that is not connected there.
  bool near_boundary(const TreeCenter &center) const;

  struct Connected {
    SampleBlocks samples; // valid until the next call
    bool boundary;        // the mesh's boundary lies in the ball, too, and belongs to that
  };
  // What the surface leads to within the center's ball, over edges that meet it.
  Connected connected(const TreeCenter &center);

private:
  // The samples of a very large triangle among those divided.
  struct Range {
    int32_t surfel, begin, end; // the surfel's number here
  };
  // An edge by which the surface goes on.
  struct Link {
    int32_t surfel; // the number here of the one behind it; -1: nothing
    vec3 from, to;
  };

  void find_cells(const std::vector<TreeCenter> &centers, std::span<const int32_t> group, float reach);
  void list_blocks(float reach);
  void list_reached();
  void list_links();
  void link_surfel(int32_t surfel);
  int32_t number_here(int32_t surfel) const;
  bool meets_ball(const Link &link, vec3 center) const;

  const SurfelSource &source_;
  const Surfels &surfels_;
  const SurfaceSamples &samples_;
  vec3 middle_{0.0f};
  std::vector<int32_t> cells_;      // found, in their order
  std::vector<int32_t> mark_;       // (cells) the search that found it last
  std::vector<int32_t> first_here_; // (cells) number of its first surfel here, if it was found
  std::vector<Link> boundary_;      // of the cells found
  bool linked_ = false;
  std::vector<int32_t> link_begin_; // (surfels here + 1) into link_
  std::vector<Link> link_;
  std::vector<int32_t> reached_mark_; // (surfels here)
  std::vector<int32_t> reached_;
  int32_t searches_ = 0, floods_ = 0;
  BlockSet stored_, divided_, connected_;
  Samples divided_samples_, connected_samples_;
  std::vector<Range> divided_surfels_; // by their order
};

} // namespace paradesc
