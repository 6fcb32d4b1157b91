// The mesh as it lies now → on the device: normals of faces and fans, and the places that a frame is made of.
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

// What lies at a vertex and has a normal there; kept for a layout.
class Places {
public:
  // sources: vertex, normal.
  Places(const Gl &gl, const std::vector<ivec2> &sources);
  int count() const { return count_; }
  GLuint sources() const { return sources_.id(); }

private:
  BufferTexture sources_;
  int count_;
};

class DeviceSurface {
public:
  // version: of the positions. Does nothing if they are there already.
  void set_positions(const Gl &gl, const Triangles &triangles, const BakeSpace &space, uint64_t version);
  // Where maps displace the same vertices, or null.
  void set_displaced(const Gl &gl, const Triangles *displaced);
  // Normals as the processor has them: of groups, then of points.
  void set_normals(const Gl &gl, const Normals &normals);
  // Fit normals, or take Max's, in steps between which a run may be cancelled: uploads, some fans at a time. rings_version: they
  // are uploaded where it has changed.
  void begin_normals(const Gl &gl, const NormalRings &rings, uint64_t rings_version);
  int fan_count() const { return fan_count_; }
  void fit_normals(const Gl &gl, ProgramCache &programs, bool fitted, int first, int last);
  // Writes positions and normals in buffer units: three floats each, the normal's four after the position's, stride floats from
  // place to place.
  void place(const Gl &gl, ProgramCache &programs, const Places &places, GLuint buffer, int stride) const;
  // Unit normals of all triangles, as UNIT_FACES says; measured unless they are there.
  GLuint faces(const Gl &gl, ProgramCache &programs);

  // Binds positions of vertices on the surface that is measured, displaced if maps displace it, and what brings them to the
  // buffers' units.
  void bind_measured(const Gl &gl) const;

private:
  void bind_mesh(const Gl &gl) const;
  void upload_rings(const Gl &gl, const NormalRings &rings);

  BufferTexture triangles_, positions_, displaced_, faces_, normals_, rings_, fan_vertices_, ring_vertices_, ring_faces_;
  Buffer space_;
  int triangle_count_ = 0, fan_count_ = 0;
  uint64_t positions_version_ = ~uint64_t{0}, rings_version_ = 0; // of what is there
  bool has_faces_ = false, is_displaced_ = false;
};

} // namespace paradesc
