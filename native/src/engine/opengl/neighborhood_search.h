// Centers → the neighborhood of each, found on the device just before it is computed.
#pragma once

#include <span>
#include <vector>

#include "engine/opengl/cell_buffers.h"
#include "sample/starts.h"

#include "shared.h"

namespace paradesc {

// The inputs of the search in one frame.
struct SearchSpace {
  GLuint centers;                 // CenterData
  std::span<const vec4> boundary; // (cells.boundary, 2) ends of the half-edges, in buffer units
  bool halves;                    // samples in two turns: black squares, then white ones
};

// The choices that select the text of the search program.
struct SearchVariant {
  bool over_links, exact, halves, texelless, fine;
  int words; // 32-bit words of a mask with one bit per near cell
};

GLuint neighborhoods_program(const Gl &gl, ProgramCache &programs, const SearchVariant &variant);

class NeighborhoodSearch {
public:
  // version: of the starts. Does nothing if the device has this version already.
  void set_starts(const Gl &gl, const Starts &starts, uint64_t version);
  // Lists what is near the cells that centers start in. Throws Error if a neighborhood may have more ranges than the device can
  // list.
  void set(const Gl &gl, ProgramCache &programs, CellBuffers &cells, const SearchSpace &space);
  // Finds the neighborhoods of at most `count` centers; if exact is true, of centers that are computed again. Their parameters
  // and lists must be bound. These neighborhoods replace those of the last call.
  void run(const Gl &gl, ProgramCache &programs, const CellBuffers &cells, bool exact, int count) const;
  // Binds the lists that samples read.
  void bind(const Gl &gl) const;
  int most_centers() const { return most_centers_; } // of one dispatch

private:
  void list_near_cells(const Gl &gl, ProgramCache &programs, const CellBuffers &cells, GLuint centers);
  void make_room(const Gl &gl, const CellBuffers &cells);
  void use(const Gl &gl, ProgramCache &programs, const CellBuffers &cells, bool over_links, bool exact) const;

  BufferTexture near_ranges_, near_cells_, near_lists_, near_normals_, near_balls_, near_spheres_, near_traits_, near_neighbors_,
      boundary_, starts_, start_cells_, start_lists_, ranges_;
  Buffer found_cells_, neighborhoods_, walks_;
  bool halves_ = false;
  uint64_t starts_version_ = 0; // of the starts on the device
  int center_count_ = 0, list_count_ = 0, near_words_ = 1, ranges_of_center_ = 1, most_centers_ = 1;
};

} // namespace paradesc
