// A group of centers → what lies around them → for each of them, the samples in its ball that are connected to it there.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "engine/cpu/group_flood.h"
#include "engine/cpu/groups.h"
#include "engine/cpu/surface_samples.h"

namespace paradesc {

// The memory that one thread keeps from group to group.
class Search {
public:
  // by_blocks: whole samples are found as parts of blocks.
  Search(const SurfelSource &source, const Surfels &surfels, const SurfaceSamples &samples, const SumTarget &target,
         bool by_blocks);

  // Looks around these centers.
  void look(const TreeCenters &centers, std::span<const int32_t> group);

  struct Found {
    SelectedSamples samples; // in the ball of a center and connected to it there, over edges that meet it
    bool boundary;           // the mesh's boundary lies in the ball, and belongs to them
  };
  // Around each of these centers, in any order. What is found is valid until use() returns.
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
  std::vector<int32_t> cells_;     // near the group, in their order
  std::vector<int32_t> cell_mark_; // (cells) the last group that it was near
  int32_t groups_ = 0;
  std::vector<int32_t> boundary_; // half-edges of these cells
  std::vector<int32_t> boundary_in_ball_;
  SampleList divided_; // of very large triangles
  std::vector<SampleBlock> divided_blocks_;
  std::vector<const SampleBlock *> blocks_;       // of Candidates
  std::vector<float> spheres_[4];                 // likewise
  std::vector<const FlatSample *> block_samples_; // (blocks_) the first of each
  std::vector<const SampleMap *> block_maps_;     // likewise, where there is one
  std::vector<BlockPart> parts_;                  // of Selection
  std::vector<int32_t> cut_, nearest_;            // likewise
  std::vector<int32_t> whole_;                    // the samples of the parts, if they are asked for one by one
  Selection selection_{};
  std::vector<const FlatSample *> whole_samples_, cut_samples_; // of SampleRun
  std::vector<const SampleMap *> whole_maps_, cut_maps_;        // likewise
  std::vector<int32_t> mark_;                                   // (surfels) the last center to which it is known to be connected
  int32_t walks_ = 0;
  std::vector<int32_t> reached_; // those
  std::vector<int32_t> way_;     // of the last walk
  std::vector<int32_t> unclear_; // centers that only a flood can tell about
  GroupFlood flood_;
  std::vector<std::optional<uint64_t>> missed_; // (blocks_) of the last flood, where it was asked for
};

} // namespace paradesc
