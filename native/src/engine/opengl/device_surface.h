// The current mesh → on the device: normals of faces and fans, and the places that a frame is made of.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "bake/distortion.h"
#include "engine/opengl/buffer.h"
#include "engine/opengl/program.h"
#include "mesh/normals.h"
#include "mesh/triangles.h"

namespace paradesc {

// A list of places, each at a vertex and with a normal; kept for a layout.
class Places {
public:
  // sources: (places) vertex, normal.
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
  // displaced: the same vertices where maps displace them, or null.
  void set_displaced(const Gl &gl, const Triangles *displaced);
  // Takes normals from the processor: those of groups, then those of points.
  void set_normals(const Gl &gl, const Normals &normals);
  // Compute fitted or Max's normals in steps, between which a run may be cancelled: uploads, then some fans at a time. Rings are
  // uploaded if rings_version has changed.
  void begin_normals(const Gl &gl, const NormalRings &rings, uint64_t rings_version);
  int fan_count() const { return fan_count_; }
  void fit_normals(const Gl &gl, ProgramCache &programs, bool fitted, int first, int last);
  // Writes positions and normals in buffer units: three floats each, the normal four floats after the position, with `stride`
  // floats from place to place.
  void place(const Gl &gl, ProgramCache &programs, const Places &places, GLuint buffer, int stride) const;
  // Unit normals of all triangles, laid out as UNIT_FACES says; measured on first use.
  GLuint faces(const Gl &gl, ProgramCache &programs);

  // Binds the positions of vertices on the surface that is measured, displaced if maps displace it, and the transform to the
  // buffers' units.
  void bind_measured(const Gl &gl) const;

private:
  void bind_mesh(const Gl &gl) const;
  void upload_rings(const Gl &gl, const NormalRings &rings);

  BufferTexture triangles_, positions_, displaced_, faces_, normals_, rings_, fan_vertices_, ring_vertices_, ring_faces_;
  Buffer space_;
  int triangle_count_ = 0, fan_count_ = 0;
  uint64_t positions_version_ = ~uint64_t{0}, rings_version_ = 0; // of what is on the device
  bool has_faces_ = false, is_displaced_ = false;
};

} // namespace paradesc
