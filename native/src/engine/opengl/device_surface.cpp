// Arrays in the order of the mesh, in buffer textures; one dispatch each for faces, fans and places.
#include "engine/opengl/device_surface.h"

#include "engine/opengl/dispatch.h"

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

void DeviceSurface::set_displaced(const Gl &gl, const Triangles *displaced) {
  is_displaced_ = displaced != nullptr;
  if (displaced) displaced_.upload(gl, GL_RGB32F, displaced->positions, GL_STREAM_DRAW);
}

void DeviceSurface::set_normals(const Gl &gl, const Normals &normals) {
  std::vector<vec3> all = normals.group;
  all.insert(all.end(), normals.point.begin(), normals.point.end());
  normals_.upload(gl, GL_RGB32F, all, GL_STREAM_DRAW);
  check_gl(gl, "upload of normals");
}

void DeviceSurface::upload_rings(const Gl &gl, const NormalRings &rings) {
  std::vector<ivec4> begins;
  for (size_t fan = 0; fan <= static_cast<size_t>(rings.fan_count); ++fan)
    begins.emplace_back(static_cast<int>(rings.fan_begin[fan]), static_cast<int>(rings.ring_begin[fan]),
                        static_cast<int>(rings.face_begin[fan]), 0);
  rings_.upload(gl, GL_RGBA32I, begins, GL_STATIC_DRAW);
  fan_vertices_.upload(gl, GL_R32I, rings.fan_vertex, GL_STATIC_DRAW);
  ring_vertices_.upload(gl, GL_R32I, rings.ring_vertex, GL_STATIC_DRAW);
  ring_faces_.upload(gl, GL_R32I, rings.face, GL_STATIC_DRAW);
  fan_count_ = rings.fan_count;
}

void DeviceSurface::bind_mesh(const Gl &gl) const {
  gl.BindTextureUnit(UNIT_MESH_POSITIONS, positions_.id());
  gl.BindTextureUnit(UNIT_TRIANGLES, triangles_.id());
}

void DeviceSurface::bind_measured(const Gl &gl) const {
  gl.BindTextureUnit(UNIT_MESH_POSITIONS, (is_displaced_ ? displaced_ : positions_).id());
  gl.BindBufferBase(GL_UNIFORM_BUFFER, BLOCK_SPACE, space_.id());
}

GLuint DeviceSurface::faces(const Gl &gl, ProgramCache &programs) {
  if (!has_faces_) {
    faces_.reserve(gl, GL_RGBA32F, static_cast<size_t>(triangle_count_));
    gl.UseProgram(programs.get(gl, "faces", {{GL_COMPUTE_SHADER, "opengl/surface/faces.comp.glsl"}}));
    bind_mesh(gl);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_FACES, faces_.buffer_id());
    dispatch_invocations(gl, triangle_count_, int64_t{1} << 20);
    gl.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    check_gl(gl, "faces");
    has_faces_ = true;
  }
  return faces_.id();
}

void DeviceSurface::begin_normals(const Gl &gl, const NormalRings &rings, uint64_t rings_version) {
  if (rings_version_ != rings_version) upload_rings(gl, rings);
  rings_version_ = rings_version;
  normals_.reserve(gl, GL_RGB32F, static_cast<size_t>(fan_count_));
  check_gl(gl, "upload of rings");
}

// Two programs instead of a uniform: zink of Mesa 25 compiles uniforms into programs, and kept an outdated value.
static GLuint normals_program(const Gl &gl, ProgramCache &programs, bool fitted) {
  return programs.get(gl, fitted ? "fitted normals" : "normals", {{GL_COMPUTE_SHADER, "opengl/surface/normals.comp.glsl"}},
                      {{"variant.glsl", define("FITTED", fitted)}});
}

void DeviceSurface::fit_normals(const Gl &gl, ProgramCache &programs, bool fitted, int first, int last) {
  if (fitted) faces(gl, programs);
  gl.UseProgram(normals_program(gl, programs, fitted));
  bind_mesh(gl);
  gl.BindTextureUnit(UNIT_FACES, faces_.id());
  gl.BindTextureUnit(UNIT_RINGS, rings_.id());
  gl.BindTextureUnit(UNIT_FAN_VERTICES, fan_vertices_.id());
  gl.BindTextureUnit(UNIT_RING_VERTICES, ring_vertices_.id());
  gl.BindTextureUnit(UNIT_RING_FACES, ring_faces_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_NORMALS, normals_.buffer_id());
  dispatch_once(gl, first, last);
  gl.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
  check_gl(gl, "normals");
}

void DeviceSurface::place(const Gl &gl, ProgramCache &programs, const Places &places, GLuint buffer, int stride) const {
  gl.UseProgram(programs.get(gl, "places", {{GL_COMPUTE_SHADER, "opengl/surface/places.comp.glsl"}}));
  bind_mesh(gl);
  gl.BindTextureUnit(UNIT_MESH_NORMALS, normals_.id());
  gl.BindTextureUnit(UNIT_SOURCES, places.sources());
  gl.BindBufferBase(GL_UNIFORM_BUFFER, BLOCK_SPACE, space_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_PLACES, buffer);
  gl.Uniform1i(LOCATION_STRIDE, stride);
  dispatch_invocations(gl, places.count(), int64_t{1} << 20);
  gl.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT);
  check_gl(gl, "places");
}

} // namespace paradesc
