// Cells → measurements, by one invocation per cell → the lists that a radius needs; samples → their points, in the same way.
#include "engine/opengl/cell_buffers.h"

#include <algorithm>
#include <string>

#include "engine/opengl/dispatch.h"
#include "support/error.h"

namespace paradesc {

// The nodes of a level of the tree of cells.
static int nodes_of_level(int cell_count, int level) { return (cell_count + (1 << TREE_BITS * level) - 1) >> TREE_BITS * level; }

CellBuffers::CellBuffers(const Gl &gl, const Cells &cells, int buffer_size)
    : labels_(gl, buffer_size, buffer_size, GL_RG32I), cell_count_(cells.count), buffer_size_(buffer_size),
      link_count_(static_cast<int>(cells.link_begin.size()) - 1), link_texel_count_(static_cast<int>(cells.link_texel.size())) {
  gl.TextureSubImage2D(labels_.id(), 0, 0, 0, buffer_size, buffer_size, GL_RG_INTEGER, GL_INT, cells.label.data());
  boxes_.upload(gl, GL_RGBA32I, cells.box.data(), cells.box.size());
  adjacency_.upload(gl, cells.adjacency);
  std::vector<ivec2> links, texels;
  for (size_t i = 0; i + 1 < cells.link_begin.size(); ++i) links.emplace_back(cells.link_begin[i], cells.link_begin[i + 1]);
  for (const int32_t texel : cells.link_texel) texels.emplace_back(texel % buffer_size | texel / buffer_size << 16, 0);
  links_.upload(gl, links);
  link_texels_.upload(gl, texels);
  std::vector<ivec4> lists;
  for (size_t i = 0; i < static_cast<size_t>(cells.count); ++i)
    lists.emplace_back(cells.adjacency_begin[i], cells.adjacency_begin[i + 1], cells.boundary_begin[i],
                       cells.boundary_begin[i + 1]);
  cell_lists_.upload(gl, GL_RGBA32I, lists, GL_STATIC_DRAW);
  params_.block_size = cells.block_size;
  params_.cell_count = cells.count;
  for (node_count_ = cells.count; nodes_of_level(cells.count, params_.top_level) > 1 << TREE_BITS;)
    node_count_ += nodes_of_level(cells.count, ++params_.top_level);
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

void CellBuffers::measure(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer) {
  const int block = params_.block_size;
  measured_.reserve(gl, GL_RGBA32F, static_cast<size_t>(cell_count_) * CELL_VECTORS);
  use_program(gl, programs, "cells", buffer);
  gl.BindTextureUnit(UNIT_LABELS, labels_.id());
  gl.BindTextureUnit(UNIT_BOXES, boxes_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_CELLS, measured_.buffer_id());
  gl.Uniform1i(LOCATION_BLOCK_SIZE, block);
  dispatch_invocations(gl, cell_count_, (int64_t{1} << 22) / (int64_t{block} * block)); // a cell has up to a block of texels
  gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT);
  check_gl(gl, "cells");
  list_link_points(gl, programs, buffer);
}

// Lists the points of texels, which are given as entries of UNIT_SAMPLES, from the current geometry buffer.
static void list_surface_points(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer, const BufferTexture &texels,
                                int count, BufferTexture &points) {
  points.reserve(gl, GL_RGBA32F, 2 * static_cast<size_t>(count));
  use_program(gl, programs, "points", buffer);
  gl.BindTextureUnit(UNIT_SAMPLES, texels.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_POINTS, points.buffer_id());
  dispatch_invocations(gl, count, int64_t{1} << 22);
  gl.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
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

void CellBuffers::set_params(const Gl &gl) {
  params_.room = room_;
  params_buffer_.fill(gl, &params_, sizeof params_, GL_STREAM_DRAW);
}

// Joins nodes level by level: each level reads the one below.
void CellBuffers::join_nodes(const Gl &gl, ProgramCache &programs) {
  gl.UseProgram(programs.get(gl, "tree", {{GL_COMPUTE_SHADER, "opengl/cells/tree.comp.glsl"}}));
  for (int level = 1; level <= params_.top_level; ++level) {
    gl.Uniform1i(LOCATION_LEVEL, level);
    dispatch_invocations(gl, nodes_of_level(cell_count_, level), int64_t{1} << 20);
    gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  }
}

void CellBuffers::list_samples(const Gl &gl, ProgramCache &programs, const CellSampling &sampling,
                               const TexellessSamples &texelless) {
  const auto cells = static_cast<size_t>(cell_count_);
  const auto size = static_cast<float>(buffer_size_);
  params_.radius = sampling.radius;
  params_.share = static_cast<float>(pi) * sampling.radius * sampling.radius / static_cast<float>(sampling.samples) * size * size;
  params_.seed = static_cast<int32_t>(sampling.seed);
  constexpr SearchCounts nothing{};
  counts_.upload(gl, &nothing, sizeof nothing, GL_DYNAMIC_COPY);
  set_params(gl);
  has_texelless_ = !texelless.samples.empty();
  texelless_.upload(gl, texelless.samples, GL_STREAM_DRAW);
  std::vector<ivec2> ranges;
  for (size_t i = 0; has_texelless_ && i < cells; ++i) ranges.emplace_back(texelless.begin[i], texelless.begin[i + 1]);
  texelless_ranges_.upload(gl, ranges, GL_STREAM_DRAW);
  traits_.reserve(gl, GL_RGBA32I, CELL_TRAITS * cells);
  nodes_.reserve(gl, GL_RGBA32I, 2 * static_cast<size_t>(node_count_));
  strides_.reserve(gl, GL_RG32I, cells);
  leaf_lists_.reserve(gl, GL_RGBA32I, LEAF_LISTS * cells);
  samples_.reserve(gl, GL_RG32I, static_cast<size_t>(std::max(room_.samples, 1)));

  const int64_t first_tile = (int64_t{1} << 22) / (int64_t{params_.block_size} * params_.block_size);
  const std::string variant = define("TEXELLESS", has_texelless_);
  gl.UseProgram(programs.get(gl, "strides " + variant, {{GL_COMPUTE_SHADER, "opengl/cells/strides.comp.glsl"}},
                             {{"variant.glsl", variant}}));
  gl.BindTextureUnit(UNIT_LABELS, labels_.id());
  gl.BindTextureUnit(UNIT_BOXES, boxes_.id());
  gl.BindTextureUnit(UNIT_CELL_LISTS, cell_lists_.id());
  gl.BindTextureUnit(UNIT_TEXELLESS_RANGES, texelless_ranges_.id());
  bind_counts(gl);
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_CELLS, measured_.buffer_id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_TEXELLESS, texelless_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_CELL_TRAITS, traits_.buffer_id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_CELL_NODES, nodes_.buffer_id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_STRIDES, strides_.buffer_id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_LEAF_LISTS, leaf_lists_.buffer_id());
  dispatch_invocations(gl, cell_count_, first_tile);
  gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT);

  gl.UseProgram(programs.get(gl, "samples", {{GL_COMPUTE_SHADER, "opengl/cells/samples.comp.glsl"}}));
  gl.BindTextureUnit(UNIT_STRIDES, strides_.id());
  gl.BindTextureUnit(UNIT_LEAF_LISTS, leaf_lists_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_SAMPLES, samples_.buffer_id());
  dispatch_invocations(gl, cell_count_, first_tile);
  join_nodes(gl, programs);
  gl.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
  check_gl(gl, "samples");
}

bool CellBuffers::list_points(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer, BufferTexture &points) const {
  const size_t texels = 2 * static_cast<size_t>(room_.samples);
  if (room_.samples > max_listed_points || texels > static_cast<size_t>(gl.limits.list_texels) ||
      texels * sizeof(vec4) > static_cast<size_t>(gl.limits.storage_bytes))
    return false;
  list_surface_points(gl, programs, buffer, samples_, room_.samples, points);
  check_gl(gl, "points of samples");
  return true;
}

void CellBuffers::begin_lists(const Gl &gl) {
  set_params(gl);
  constexpr int32_t nothing[3] = {}; // cells, neighbors, longest
  gl.NamedBufferSubData(counts_.id(), offsetof(SearchCounts, cells), sizeof nothing, nothing);
}

SearchCounts CellBuffers::read_counts(const Gl &gl) const {
  SearchCounts counts{};
  gl.GetNamedBufferSubData(counts_.id(), 0, sizeof counts, &counts);
  check_gl(gl, "read-back");
  return counts;
}

bool CellBuffers::make_room(const SearchCounts &counts, bool anew, int list_texels) {
  if (std::min({counts.samples, counts.cells, counts.neighbors}) < 0 || counts.longest >= MAX_ITERATIONS)
    throw Error(
        PDESC_ERROR_UNSUPPORTED,
        "The neighborhoods have too many pieces for this device; use a smaller radius, fewer charts, or another backend.");
  const SearchCounts before = room_;
  const auto make = [&](int32_t &room, int32_t count) {
    if (count <= room && !(anew && count < room / 2)) return;
    room = static_cast<int32_t>(std::min<int64_t>(int64_t{count} + count / 8, std::max(count, list_texels)));
  };
  make(room_.samples, counts.samples);
  make(room_.cells, counts.cells);
  make(room_.neighbors, counts.neighbors);
  const int32_t longest = (counts.longest + 31) / 32 * 32; // one bit each, rounded up to whole words
  if (longest > room_.longest || (anew && longest <= room_.longest / 2)) room_.longest = longest;
  room_.fine = std::max(room_.fine, counts.fine);
  return room_ == before;
}

int64_t CellBuffers::bytes_of_lists() const {
  constexpr auto of_cell = static_cast<int64_t>(sizeof(CellData) + (CELL_TRAITS + LEAF_LISTS) * sizeof(ivec4) + sizeof(ivec2));
  return cell_count_ * of_cell + room_.samples * static_cast<int64_t>(sizeof(ivec2));
}

void CellBuffers::bind_counts(const Gl &gl) const {
  gl.BindBufferBase(GL_UNIFORM_BUFFER, BLOCK_SEARCH, params_buffer_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_COUNTS, counts_.id());
}

void CellBuffers::bind_to_search(const Gl &gl) const {
  bind_counts(gl);
  gl.BindTextureUnit(UNIT_CELLS, measured_.id());
  gl.BindTextureUnit(UNIT_CELL_LISTS, cell_lists_.id());
  gl.BindTextureUnit(UNIT_ADJACENCY, adjacency_.id());
  gl.BindTextureUnit(UNIT_CELL_LINKS, links_.id());
  gl.BindTextureUnit(UNIT_LINK_POINTS, link_points_.id());
  gl.BindTextureUnit(UNIT_LINK_SPHERES, link_spheres_.id());
  gl.BindTextureUnit(UNIT_LEAF_LISTS, leaf_lists_.id());
  gl.BindTextureUnit(UNIT_TEXELLESS_RANGES, texelless_ranges_.id());
}

void CellBuffers::bind_to_lists(const Gl &gl) const {
  gl.BindTextureUnit(UNIT_CELL_LISTS, cell_lists_.id());
  gl.BindTextureUnit(UNIT_CELL_TRAITS, traits_.id());
  gl.BindTextureUnit(UNIT_CELL_NODES, nodes_.id());
  gl.BindTextureUnit(UNIT_ADJACENCY, adjacency_.id());
  bind_counts(gl);
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_CELLS, measured_.buffer_id());
}

void CellBuffers::bind(const Gl &gl) const {
  gl.BindTextureUnit(UNIT_SAMPLES, samples_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_TEXELLESS, texelless_.id());
}

} // namespace paradesc
