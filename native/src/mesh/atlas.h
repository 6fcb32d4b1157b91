// Charts + texel counts of a bake → the layout in use: the caller's UV map, or a private one. A private layout is made if parts
// of the surface share texture space, or if it gives the radius more texels.
#pragma once

#include <optional>

#include "mesh/charts.h"
#include "mesh/halfedge.h"
#include "mesh/triangles.h"

namespace paradesc {

struct Atlas {
  Charts charts;
  int32_t layout = PDESC_LAYOUT_GIVEN; // pdesc_layout
  int32_t cut_charts = 0;              // charts that overlapped themselves, and were cut for a layout of their own
  int version = 0;                     // differs from that of every other atlas of the mesh
};

struct TexelCounts {
  int covered = 0;     // texels with at least one owner
  int overlapping = 0; // texels that several triangles claim
};

// The atlas that a mesh currently has. A private layout is made at most once and then kept: whether one helps depends neither on
// the buffer's size nor on the radius.
class Atlases {
public:
  Atlases() = default;
  explicit Atlases(Charts charts) { atlas_.charts = std::move(charts); }

  const Atlas &current() const { return atlas_; }
  // Separates overlaps if the charts have more area than the unit square: drawing takes as many times longer. The comparison is
  // made once; later calls cost nothing.
  void repack_if_overfull(const Triangles &triangles, const HalfEdges &half_edges, int threads);
  // Returns true if the atlas was replaced. Overlapping texels only raise the suspicion, because rasterizers round, and small
  // triangles of a sound map may share a texel too. radius_in_texels: in the direction that has the fewest.
  bool repack_if_needed(const Triangles &triangles, const HalfEdges &half_edges, const TexelCounts &counts, int buffer_size,
                        double radius_in_texels, int threads);

  // True once a search has found that no two triangles of the layout overlap. (A texel may still be claimed twice by rounding.)
  bool known_free_of_overlaps() const { return known_free_of_overlaps_; }

private:
  bool separate_overlaps(const Triangles &triangles, const HalfEdges &half_edges, int threads);
  void replace(Charts charts, int32_t layout, int32_t cut_charts);

  Atlas atlas_;
  bool area_was_compared_ = false; // with that of the square
  bool known_free_of_overlaps_ = false;
  bool filling_was_tried_ = false;
};

} // namespace paradesc
