// Cells → what was measured of them, by one invocation each; samples → their points, likewise.
#include "engine/opengl/cell_buffers.h"

#include <algorithm>
#include <string>

#include "engine/opengl/dispatch.h"

namespace paradesc {

CellBuffers::CellBuffers(const Gl &gl, const Cells &cells, int buffer_size)
    : labels_(gl, buffer_size, buffer_size, GL_RG32I), cell_count_(cells.count), block_size_(cells.block_size) {
  gl.TextureSubImage2D(labels_.id(), 0, 0, 0, buffer_size, buffer_size, GL_RG_INTEGER, GL_INT, cells.label.data());
  boxes_.upload(gl, GL_RGBA32I, cells.box.data(), cells.box.size());
  check_gl(gl, "cell upload");
}

static void use_program(const Gl &gl, ProgramCache &programs, const char *name, const GeometryBuffer &buffer) {
  const char *variant = buffer.variant();
  gl.UseProgram(programs.get(gl, std::string(name) + variant,
                             {{GL_COMPUTE_SHADER, std::string("opengl/cells/") + name + ".comp.glsl"}},
                             {{"variant.glsl", variant}}));
  buffer.bind();
  gl.Uniform1i(LOCATION_BUFFER_SIZE, buffer.size());
  gl.Uniform1f(LOCATION_AREA_UNIT, buffer.area_unit());
}

std::vector<CellData> CellBuffers::measure(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer) {
  std::vector<CellData> cells(static_cast<size_t>(cell_count_));
  if (cells.empty()) return cells;
  measured_.upload(gl, nullptr, cells.size() * sizeof(CellData), GL_STREAM_READ);
  use_program(gl, programs, "cells", buffer);
  gl.BindTextureUnit(UNIT_LABELS, labels_.id());
  gl.BindTextureUnit(UNIT_BOXES, boxes_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_CELLS, measured_.id());
  gl.Uniform1i(LOCATION_BLOCK_SIZE, block_size_);
  dispatch_invocations(gl, cell_count_,
                       (int64_t{1} << 22) / (int64_t{block_size_} * block_size_)); // a cell has up to a block of texels
  gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  gl.GetNamedBufferSubData(measured_.id(), 0, static_cast<GLsizeiptr>(cells.size() * sizeof(CellData)), cells.data());
  check_gl(gl, "cells");
  return cells;
}

std::vector<vec3> read_points(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer,
                              std::span<const int32_t> texels) {
  constexpr size_t max_texels = size_t{1} << 17;
  const int size = buffer.size();
  std::vector<vec3> points;
  points.reserve(texels.size());
  std::vector<ivec2> entries;
  std::vector<vec4> read;
  BufferTexture list;
  Buffer found;
  for (; !texels.empty(); texels = texels.subspan(entries.size())) {
    entries.clear();
    for (const int32_t texel : texels.first(std::min(texels.size(), max_texels)))
      entries.emplace_back(texel % size | texel / size << 16, 0);
    read.resize(2 * entries.size());
    list.upload(gl, entries);
    found.upload(gl, nullptr, read.size() * sizeof(vec4), GL_STREAM_READ);
    use_program(gl, programs, "points", buffer);
    gl.BindTextureUnit(UNIT_SAMPLES, list.id());
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_POINTS, found.id());
    dispatch_invocations(gl, static_cast<int>(entries.size()), int64_t{1} << 22);
    gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl.GetNamedBufferSubData(found.id(), 0, static_cast<GLsizeiptr>(read.size() * sizeof(vec4)), read.data());
    for (size_t i = 0; i < read.size(); i += 2) points.emplace_back(read[i]);
  }
  check_gl(gl, "points of links");
  return points;
}

void CellBuffers::set_samples(const Gl &gl, const CellSamples &samples) {
  samples_.upload(gl, samples.list);
  sample_count_ = static_cast<int>(samples.list.size());
  check_gl(gl, "sample upload");
}

bool CellBuffers::list_points(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer, BufferTexture &points) const {
  const size_t texels = 2 * static_cast<size_t>(sample_count_);
  if (sample_count_ > max_listed_points || texels > static_cast<size_t>(gl.limits.list_texels) ||
      texels * sizeof(vec4) > static_cast<size_t>(gl.limits.storage_bytes))
    return false;
  points.upload(gl, GL_RGBA32F, nullptr, texels, GL_STREAM_COPY);
  use_program(gl, programs, "points", buffer);
  gl.BindTextureUnit(UNIT_SAMPLES, samples_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_POINTS, points.buffer_id());
  dispatch_invocations(gl, sample_count_, int64_t{1} << 22);
  gl.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
  check_gl(gl, "points of samples");
  return true;
}

void CellBuffers::bind(const Gl &gl) const { gl.BindTextureUnit(UNIT_SAMPLES, samples_.id()); }

} // namespace paradesc
