// Cells and their samples on the device: measurements, lists, and the points that centers fetch.
#pragma once

#include <vector>

#include "engine/opengl/geometry_buffer.h"
#include "engine/opengl/program.h"
#include "sample/cells.h"
#include "sample/texelless.h"

#include "shared.h"

namespace paradesc {

// The largest number of samples whose points are listed separately: 128 MiB.
inline constexpr int max_listed_points = 1 << 22;

// How finely cells are sampled.
struct CellSampling {
  float radius = 0; // in buffer units
  int samples = 0;  // in a disk of that radius
  uint32_t seed = 0;
  bool operator==(const CellSampling &) const = default;
};

// List lengths are known only on the device while a frame is computed. Buffers get the previous lengths plus some slack. The new
// lengths are read with the results; if a list overflowed, make_room() grows it and the frame is computed again.
class CellBuffers {
public:
  CellBuffers(const Gl &gl, const Cells &cells, int buffer_size);
  // Measures the cells in the current geometry buffer, and lists the points of the links.
  void measure(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer);
  // Lists the samples of the measured cells.
  void list_samples(const Gl &gl, ProgramCache &programs, const CellSampling &sampling, const TexellessSamples &texelless);
  // Lists the points of the samples in the current geometry buffer, so that centers fetch these instead of texels. Returns false
  // if that would take too much memory. points: receives them.
  bool list_points(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer, BufferTexture &points) const;

  // Resets the counts of near cells for a new search.
  void begin_lists(const Gl &gl);
  const SearchCounts &room() const { return room_; }
  SearchCounts read_counts(const Gl &gl) const;
  GLuint counts() const { return counts_.id(); } // SearchCounts
  // Returns whether lists of these lengths had room; if not, makes room. anew: the radius has changed, so far too much room
  // counts as wrong, too. list_texels: the limit of a buffer texture.
  bool make_room(const SearchCounts &counts, bool anew, int list_texels);

  void bind(const Gl &gl) const;
  // Binds the inputs of a search: measured cells, links, and where the samples are listed.
  void bind_to_search(const Gl &gl) const;
  // Binds the inputs and outputs of the programs that list near cells.
  void bind_to_lists(const Gl &gl) const;
  GLuint measured() const { return measured_.buffer_id(); } // (cells) CellData
  int cell_count() const { return cell_count_; }
  int node_count() const { return node_count_; } // of the tree of cells
  bool has_texelless() const { return has_texelless_; }
  int64_t bytes_of_lists() const; // lists of cells and samples

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
