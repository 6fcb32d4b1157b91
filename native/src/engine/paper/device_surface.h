// The current mesh → on the device: normals of faces, and the places that a frame is made of.
#pragma once

#include <cstdint>
#include <vector>

#include "bake/distortion.h"
#include "engine/paper/buffer.h"
#include "engine/paper/program.h"
#include "mesh/normals.h"
#include "mesh/triangles.h"

namespace paradesc {

// A list of places, each at a vertex and with a normal; kept for a layout.
class Places {
public:
  // sources: (places) vertex, index into Normals::group.
  Places(const Gl &gl, const std::vector<ivec2> &sources);
  int count() const { return count_; }
  GLuint sources() const { return sources_.id(); }

private:
  BufferTexture sources_;
  int count_;
};

class DeviceSurface {
public:
  // version: of the positions. Does nothing if the device has this version already.
  void set_positions(const Gl &gl, const Triangles &triangles, const BakeSpace &space, uint64_t version);
  void set_normals(const Gl &gl, const Normals &normals);
  // Writes two vectors of four for each place: its position in buffer units, its normal.
  void place(const Gl &gl, ProgramCache &programs, const Places &places, GLuint buffer) const;
  // Unit normals of all triangles, as UNIT_FACES says; measured on first use.
  GLuint faces(const Gl &gl, ProgramCache &programs);

private:
  void bind_mesh(const Gl &gl) const;

  BufferTexture triangles_, positions_, faces_, normals_;
  Buffer space_;
  int triangle_count_ = 0;
  uint64_t positions_version_ = ~uint64_t{0}; // of what is on the device
  bool has_faces_ = false;
};

} // namespace paradesc
