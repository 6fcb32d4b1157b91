// Arrays in the order of the mesh, in buffer textures; one dispatch each for faces and places.
#include "engine/paper/device_surface.h"

#include "engine/paper/dispatch.h"

#include "shared.h"

namespace paradesc {

Places::Places(const Gl &gl, const std::vector<ivec2> &sources) : count_(static_cast<int>(sources.size())) {
  sources_.upload(gl, sources);
}

void DeviceSurface::set_positions(const Gl &gl, const Triangles &triangles, const BakeSpace &space, uint64_t version) {
  if (positions_version_ == version) return;
  if (triangle_count_ != triangles.triangle_count) triangles_.upload(gl, GL_RGB32I, triangles.corner_vertex, GL_STATIC_DRAW);
  triangle_count_ = triangles.triangle_count;
  positions_.upload(gl, GL_RGB32F, triangles.positions, GL_STREAM_DRAW);
  const dvec4 center_and_scale(space.center, space.scale);
  space_.fill(gl, &center_and_scale, sizeof center_and_scale, GL_STREAM_DRAW);
  has_faces_ = false;
  check_gl(gl, "upload");
  positions_version_ = version;
}

void DeviceSurface::set_normals(const Gl &gl, const Normals &normals) {
  normals_.upload(gl, GL_RGB32F, normals.group, GL_STREAM_DRAW);
  check_gl(gl, "upload of normals");
}

void DeviceSurface::bind_mesh(const Gl &gl) const {
  gl.BindTextureUnit(UNIT_MESH_POSITIONS, positions_.id());
  gl.BindTextureUnit(UNIT_TRIANGLES, triangles_.id());
}

GLuint DeviceSurface::faces(const Gl &gl, ProgramCache &programs) {
  if (!has_faces_) {
    faces_.reserve(gl, GL_RGBA32F, static_cast<size_t>(triangle_count_));
    gl.UseProgram(programs.get(gl, "faces", {{GL_COMPUTE_SHADER, "paper/surface/faces.comp.glsl"}}));
    bind_mesh(gl);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_FACES, faces_.buffer_id());
    dispatch_invocations(gl, triangle_count_, int64_t{1} << 20);
    gl.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    check_gl(gl, "faces");
    has_faces_ = true;
  }
  return faces_.id();
}

void DeviceSurface::place(const Gl &gl, ProgramCache &programs, const Places &places, GLuint buffer) const {
  gl.UseProgram(programs.get(gl, "places", {{GL_COMPUTE_SHADER, "paper/surface/places.comp.glsl"}}));
  bind_mesh(gl);
  gl.BindTextureUnit(UNIT_MESH_NORMALS, normals_.id());
  gl.BindTextureUnit(UNIT_SOURCES, places.sources());
  gl.BindBufferBase(GL_UNIFORM_BUFFER, BLOCK_SPACE, space_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_PLACES, buffer);
  dispatch_invocations(gl, places.count(), int64_t{1} << 20);
  gl.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT);
  check_gl(gl, "places");
}

} // namespace paradesc
