// Centers → the neighborhood of each, found on the device in the tile that is computed next.
#pragma once

#include <span>
#include <vector>

#include "engine/opengl/cell_buffers.h"
#include "sample/neighborhoods.h"

#include "shared.h"

namespace paradesc {

// What centers search in, of one frame.
struct SearchSpace {
  const Cells &cells;
  const NearCells &near;
  const Starts &starts;
  const TexellessSamples &texelless;
  std::span<const CellData> measured; // with_texelless_samples; empty: as the device has them
  std::span<const vec4> boundary;     // (cells.boundary, 2) ends of the half-edges, in buffer units
  bool halves;                        // samples in two turns, black squares and white ones
};

// What chooses the text of the program that searches.
struct SearchVariant {
  bool over_links, exact, halves, texelless, fine;
  int words; // of 32 bits, with one for each cell that is near
};

GLuint neighborhoods_program(const Gl &gl, ProgramCache &programs, const SearchVariant &variant);

class NeighborhoodSearch {
public:
  // Throws Error where a neighborhood may have more ranges than the device lists.
  void set(const Gl &gl, ProgramCache &programs, const CellBuffers &cells, const SearchSpace &space);
  // Finds the neighborhoods of centers [first, last), or of those that are computed again where exact is true. Their
  // parameters and lists are bound. These neighborhoods replace those of the last call.
  void run(const Gl &gl, ProgramCache &programs, const CellBuffers &cells, bool exact, int first, int last) const;
  // Binds what samples read.
  void bind(const Gl &gl) const;
  bool has_texelless() const { return has_texelless_; }
  int largest_tile() const { return largest_tile_; } // of centers

private:
  void list_cells(const Gl &gl, const SearchSpace &space);
  void list_near_cells(const Gl &gl, ProgramCache &programs, const CellBuffers &cells, const NearCells &near);
  void make_room(const Gl &gl, const SearchSpace &space);
  void use(const Gl &gl, ProgramCache &programs, bool over_links, bool exact) const;

  BufferTexture measured_, cell_lists_, near_cells_, near_normals_, near_spheres_, near_traits_, near_neighbors_, boundary_,
      starts_, start_cells_, ranges_;
  Buffer neighborhoods_, texelless_, walks_;
  bool has_texelless_ = false, halves_ = false, fine_ = false;
  int cell_count_ = 0, near_words_ = 1, ranges_of_center_ = 1, largest_tile_ = 1;
};

} // namespace paradesc
