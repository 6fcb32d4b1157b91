// Cells and their samples on the device: where they are measured and listed, and the points that centers fetch.
#pragma once

#include <vector>

#include "engine/opengl/geometry_buffer.h"
#include "engine/opengl/program.h"
#include "sample/cells.h"
#include "sample/texelless.h"

#include "shared.h"

namespace paradesc {

// The largest number of samples whose points are listed beside the buffers: 128 MiB.
inline constexpr int max_listed_points = 1 << 22;

// How finely cells are sampled.
struct CellSampling {
  float radius = 0; // in buffer units
  int samples = 0;  // in a disk of that radius
  uint32_t seed = 0;
  bool operator==(const CellSampling &) const = default;
};

// How long lists are, or may be, the device alone knows while a frame goes on: they have as much room as they took before and
// some more. What they took is read with the results; where it was more, make_room() comes and all of it is done again.
class CellBuffers {
public:
  CellBuffers(const Gl &gl, const Cells &cells, int buffer_size);
  // Measures the cells in the geometry buffer as it is now, and lists the points of the links.
  void measure(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer);
  // Lists the samples of cells that were measured.
  void list_samples(const Gl &gl, ProgramCache &programs, const CellSampling &sampling, const TexellessSamples &texelless);
  // Lists the points of the samples in the geometry buffer as it is now, for centers to fetch instead of its texels. Returns
  // false if that would take too much memory. points: where they go.
  bool list_points(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer, BufferTexture &points) const;

  // What is counted of near cells from here on is of another search.
  void begin_lists(const Gl &gl);
  const SearchCounts &room() const { return room_; }
  SearchCounts read_counts(const Gl &gl) const;
  GLuint counts() const { return counts_.id(); } // SearchCounts
  // Whether lists as long as that had room; makes it otherwise. anew: for another radius, after which far too much room is as
  // bad as too little. list_texels: that a buffer texture may have.
  bool make_room(const SearchCounts &counts, bool anew, int list_texels);

  void bind(const Gl &gl) const;
  // Binds what neighborhoods are found in: cells as they were measured, links, and where samples are listed.
  void bind_to_search(const Gl &gl) const;
  // Binds what lists of near cells are made from and with.
  void bind_to_lists(const Gl &gl) const;
  GLuint measured() const { return measured_.buffer_id(); } // (cells) CellData
  int cell_count() const { return cell_count_; }
  int node_count() const { return node_count_; } // of the tree of cells
  bool has_texelless() const { return has_texelless_; }
  int64_t bytes_of_lists() const; // of cells and samples

private:
  void list_link_points(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer);
  void set_params(const Gl &gl);
  void bind_counts(const Gl &gl) const;
  void join_nodes(const Gl &gl, ProgramCache &programs);

  Texture labels_;
  ListTexture boxes_;
  BufferTexture cell_lists_, measured_, adjacency_, links_, link_texels_, link_points_, link_spheres_, traits_, nodes_, strides_,
      leaf_lists_, samples_, texelless_ranges_;
  Buffer texelless_, params_buffer_, counts_;
  SearchParams params_{};
  SearchCounts room_{};
  bool has_texelless_ = false;
  int cell_count_ = 0, node_count_ = 0, buffer_size_ = 0, link_count_ = 0, link_texel_count_ = 0;
};

} // namespace paradesc
