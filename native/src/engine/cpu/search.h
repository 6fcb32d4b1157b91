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

  // All samples that may lie in the ball of any center, in their order. Valid until look() is called again, as is what follows.
  std::span<const FlatSample *const> samples() const { return found_; }
  // Of each of them, the bits of the centers that it counts for; and, to be filled in, as AddSamples does.
  uint16_t *shown() { return shown_.data(); }
  uint16_t *nearest() { return nearest_.data(); }

  struct Connected {
    bool all;      // all samples in the ball; if not, the others are no longer shown to the center
    bool boundary; // the mesh's boundary lies in the ball, and belongs to them
  };
  // What is connected to a center within its ball, over edges that meet it. nearest() is known. lane: of the center.
  Connected find_connected(const TreeCenter &center, int lane);

private:
  void find_cells(const std::vector<TreeCenter> &centers, std::span<const int32_t> group, float reach);
  void list_samples(float reach);
  void add_sample(const FlatSample &sample, float reach);
  bool meets_ball(int32_t half_edge, vec3 center) const;
  bool near_boundary(vec3 center) const;
  void note_nearest();
  int32_t count_nearest(int lane) const;
  void start_flood(int32_t triangle);
  void reach(int32_t surfel);
  bool reach_neighbors(int32_t surfel, vec3 center);
  bool is_one_piece(const TreeCenter &center, int lane, int32_t nearest);

  const SurfelSource &source_;
  const Surfels &surfels_;
  const SurfaceSamples &samples_;
  vec3 middle_{0.0f};
  std::vector<int32_t> cells_;    // found, in their order
  std::vector<int32_t> mark_;     // (cells) the search that found it last
  std::vector<int32_t> boundary_; // half-edges of the cells found
  std::vector<const FlatSample *> found_;
  std::vector<uint16_t> shown_, nearest_; // (found)
  std::vector<FlatSample> divided_;       // of very large triangles
  bool noted_ = false;
  std::vector<int32_t> nearest_surfels_;
  std::vector<uint16_t> nearest_of_surfel_; // (surfels) the bits of the centers to which it may come nearest
  std::vector<int32_t> reached_mark_;       // (surfels) the flood that reached it last
  std::vector<int32_t> reached_;
  int32_t searches_ = 0, floods_ = 0;
};

} // namespace paradesc
