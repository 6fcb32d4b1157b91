// A group of centers → the surface around it → for each center, the samples in its ball that are connected to it there.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "engine/cpu/group_flood.h"
#include "engine/cpu/groups.h"
#include "engine/cpu/surface_samples.h"

namespace paradesc {

// The memory that one thread reuses from group to group.
class Search {
public:
  // by_blocks: samples within the ball are found as parts of blocks.
  Search(const SurfelSource &source, const Surfels &surfels, const SurfaceSamples &samples, const SumTarget &target,
         bool by_blocks);

  // Finds the cells and blocks around these centers.
  void look(const TreeCenters &centers, std::span<const int32_t> group);

  struct Found {
    SelectedSamples samples; // in the center's ball and connected to it there, across edges that meet the ball
    bool boundary;           // whether the boundary of the mesh meets the ball at these samples
  };
  // Calls use() for each of these centers, in any order. The found samples are valid until use() returns.
  using UseFound = std::function<void(int32_t center, const Found &found)>;
  void find_each(const TreeCenters &centers, std::span<const int32_t> group, const UseFound &use);

private:
  void find_cells(const TreeCenters &centers, std::span<const int32_t> group, float reach);
  void list_candidates(float reach);
  void add_block(const SampleList &list, size_t first, const SampleBlock &block, vec4 sphere, float reach);
  void add_divided(float reach);
  const FlatSample &candidate(int32_t i) const { return block_samples_[i / block_lanes][i % block_lanes]; }
  void select_around(vec3 center);
  bool may_be_nearest(const FlatSample &sample, vec3 center) const;
  bool is_one_piece(const TreeCenter &center);
  bool walk_to_reached(int32_t surfel, vec3 center);
  void reach(int32_t surfel);
  void reach_neighbors(int32_t surfel, vec3 center);
  bool is_reached(int32_t surfel) const { return mark_[surfel] == walks_; }
  Found found(bool boundary);
  uint64_t missed_of(int32_t block);
  void keep_reached(size_t number);
  int32_t list_wholes();
  SampleRun take(const std::vector<int32_t> &list, int32_t count, std::vector<const FlatSample *> &samples,
                 std::vector<const SampleMap *> &maps) const;

  const SurfelSource &source_;
  const Surfels &surfels_;
  const SurfaceSamples &samples_;
  const SumTarget target_;
  const bool by_blocks_;
  const BallEdges edges_;
  vec3 middle_{0.0f};
  std::vector<int32_t> cells_;     // near the group, in ascending order
  std::vector<int32_t> cell_mark_; // (cells) the last group that found it near
  int32_t groups_ = 0;
  std::vector<int32_t> boundary_; // boundary half-edges of these cells
  std::vector<int32_t> boundary_in_ball_;
  SampleList divided_; // samples of very large triangles
  std::vector<SampleBlock> divided_blocks_;
  std::vector<const SampleBlock *> blocks_;       // see Candidates
  std::vector<float> spheres_[4];                 // see Candidates
  std::vector<const FlatSample *> block_samples_; // (blocks_) the first sample of each
  std::vector<const SampleMap *> block_maps_;     // (blocks_) their maps, if there are any
  std::vector<BlockPart> parts_;                  // see Selection
  std::vector<int32_t> cut_, nearest_;            // see Selection
  std::vector<int32_t> whole_;                    // the samples of the parts, if they are needed one by one
  Selection selection_{};
  std::vector<const FlatSample *> whole_samples_, cut_samples_; // see SampleRun
  std::vector<const SampleMap *> whole_maps_, cut_maps_;        // see SampleRun
  std::vector<int32_t> mark_;                                   // (surfels) the last center that is known to be connected to it
  int32_t walks_ = 0;
  std::vector<int32_t> reached_; // surfels with the current mark
  std::vector<int32_t> way_;     // surfels of the last walk
  std::vector<int32_t> unclear_; // centers whose connection needs a flood
  GroupFlood flood_;
  std::vector<std::optional<uint64_t>> missed_; // (blocks_) results of missed_of() for the last flood
};

} // namespace paradesc
