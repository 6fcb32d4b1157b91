// Cells → what was measured of them, by one invocation each; samples → their points, likewise.
#include "engine/opengl/cell_buffers.h"

#include <algorithm>
#include <string>

#include "engine/opengl/dispatch.h"

namespace paradesc {

CellBuffers::CellBuffers(const Gl &gl, const Cells &cells, int buffer_size)
    : labels_(gl, buffer_size, buffer_size, GL_RG32I), cell_count_(cells.count), block_size_(cells.block_size),
      link_count_(static_cast<int>(cells.link_begin.size()) - 1), link_texel_count_(static_cast<int>(cells.link_texel.size())) {
  gl.TextureSubImage2D(labels_.id(), 0, 0, 0, buffer_size, buffer_size, GL_RG_INTEGER, GL_INT, cells.label.data());
  boxes_.upload(gl, GL_RGBA32I, cells.box.data(), cells.box.size());
  adjacency_.upload(gl, cells.adjacency);
  std::vector<ivec2> links, texels;
  for (size_t i = 0; i + 1 < cells.link_begin.size(); ++i) links.emplace_back(cells.link_begin[i], cells.link_begin[i + 1]);
  for (const int32_t texel : cells.link_texel) texels.emplace_back(texel % buffer_size | texel / buffer_size << 16, 0);
  links_.upload(gl, links);
  link_texels_.upload(gl, texels);
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
  measured_.reserve(gl, GL_RGBA32F, cells.size() * CELL_VECTORS);
  use_program(gl, programs, "cells", buffer);
  gl.BindTextureUnit(UNIT_LABELS, labels_.id());
  gl.BindTextureUnit(UNIT_BOXES, boxes_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_CELLS, measured_.buffer_id());
  gl.Uniform1i(LOCATION_BLOCK_SIZE, block_size_);
  dispatch_invocations(gl, cell_count_,
                       (int64_t{1} << 22) / (int64_t{block_size_} * block_size_)); // a cell has up to a block of texels
  gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT);
  gl.GetNamedBufferSubData(measured_.buffer_id(), 0, static_cast<GLsizeiptr>(cells.size() * sizeof(CellData)), cells.data());
  check_gl(gl, "cells");
  return cells;
}

// The points of texels, as entries of UNIT_SAMPLES name them, in the geometry buffer as it is now.
static void list_surface_points(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer, const BufferTexture &texels,
                                int count, BufferTexture &points) {
  points.reserve(gl, GL_RGBA32F, 2 * static_cast<size_t>(count));
  use_program(gl, programs, "points", buffer);
  gl.BindTextureUnit(UNIT_SAMPLES, texels.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_POINTS, points.buffer_id());
  dispatch_invocations(gl, count, int64_t{1} << 22);
  gl.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
}

void CellBuffers::set_samples(const Gl &gl, const CellSamples &samples) {
  samples_.upload(gl, samples.list);
  std::vector<ivec4> lists;
  constexpr size_t of_cell = 2 * CELL_LEAVES; // halves
  for (size_t i = 0; i + of_cell < samples.coarse.size(); i += of_cell)
    for (const std::vector<int32_t> *begin : {&samples.coarse, &samples.fine})
      for (const size_t halves : {2, 1}) {
        const auto size = [&](size_t leaf) { return (*begin)[i + 2 * leaf + halves] - (*begin)[i + 2 * leaf]; };
        lists.emplace_back((*begin)[i], size(0) | size(1) << 16, size(2) | size(3) << 16, 0);
      }
  leaf_lists_.upload(gl, GL_RGBA32I, lists.data(), lists.size(), GL_STATIC_DRAW);
  sample_count_ = static_cast<int>(samples.list.size());
  check_gl(gl, "sample upload");
}

bool CellBuffers::list_points(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer, BufferTexture &points) const {
  const size_t texels = 2 * static_cast<size_t>(sample_count_);
  if (sample_count_ > max_listed_points || texels > static_cast<size_t>(gl.limits.list_texels) ||
      texels * sizeof(vec4) > static_cast<size_t>(gl.limits.storage_bytes))
    return false;
  list_surface_points(gl, programs, buffer, samples_, sample_count_, points);
  check_gl(gl, "points of samples");
  return true;
}

void CellBuffers::list_link_points(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer) {
  list_surface_points(gl, programs, buffer, link_texels_, link_texel_count_, link_points_);
  link_spheres_.reserve(gl, GL_RGBA32F, static_cast<size_t>(link_count_));
  gl.UseProgram(programs.get(gl, "links", {{GL_COMPUTE_SHADER, "opengl/cells/links.comp.glsl"}}));
  gl.BindTextureUnit(UNIT_CELL_LINKS, links_.id());
  gl.BindTextureUnit(UNIT_LINK_POINTS, link_points_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_POINTS, link_spheres_.buffer_id());
  dispatch_invocations(gl, link_count_, int64_t{1} << 20);
  gl.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
  check_gl(gl, "points of links");
}

void CellBuffers::bind_to_search(const Gl &gl) const {
  gl.BindTextureUnit(UNIT_CELLS, measured_.id());
  gl.BindTextureUnit(UNIT_ADJACENCY, adjacency_.id());
  gl.BindTextureUnit(UNIT_CELL_LINKS, links_.id());
  gl.BindTextureUnit(UNIT_LINK_POINTS, link_points_.id());
  gl.BindTextureUnit(UNIT_LINK_SPHERES, link_spheres_.id());
  gl.BindTextureUnit(UNIT_LEAF_LISTS, leaf_lists_.id());
}

void CellBuffers::bind(const Gl &gl) const { gl.BindTextureUnit(UNIT_SAMPLES, samples_.id()); }

} // namespace paradesc
