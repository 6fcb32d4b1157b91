// Lists of cells in buffer textures, which one dispatch a tile looks through.
#include "engine/opengl/neighborhood_search.h"

#include <algorithm>
#include <bit>
#include <string>

#include "engine/opengl/dispatch.h"
#include "support/error.h"

namespace paradesc {

// Two a cell: where its own parts of four lists lie.
void NeighborhoodSearch::list_cells(const Gl &gl, const SearchSpace &space) {
  const Cells &cells = space.cells;
  std::vector<ivec4> lists;
  lists.reserve(2 * static_cast<size_t>(cells.count));
  for (size_t i = 0; i < static_cast<size_t>(cells.count); ++i) {
    const ivec2 near = space.near.range[i];
    const ivec2 texelless = has_texelless_ ? ivec2(space.texelless.begin[i], space.texelless.begin[i + 1]) : ivec2(0);
    lists.emplace_back(near.x, near.y, cells.adjacency_begin[i], cells.adjacency_begin[i + 1]);
    lists.emplace_back(cells.boundary_begin[i], cells.boundary_begin[i + 1], texelless.x, texelless.y);
  }
  cell_lists_.upload(gl, GL_RGBA32I, lists.data(), lists.size(), GL_STREAM_DRAW);
}

// A tile's lists of ranges have room for as many as there may be: none has to be counted before.
void NeighborhoodSearch::make_room(const Gl &gl, const SearchSpace &space) {
  constexpr size_t most_texels = size_t{1} << 23;
  const size_t of_cell = (halves_ ? 2 * CELL_LEAVES : CELL_LEAVES) + (has_texelless_ ? 1 : 0);
  const size_t group = static_cast<size_t>(gl.limits.group_size);
  const size_t centers = (space.starts.order.size() + group - 1) / group * group;
  const size_t of_center = std::max<size_t>(1, space.near.most * of_cell);
  const size_t fit = std::min(most_texels, static_cast<size_t>(gl.limits.list_texels)) / of_center;
  const size_t tile = std::clamp(fit / group * group, group, std::max(centers, group));
  const size_t words = std::max<size_t>(1, (space.near.most + 31) / 32);
  near_words_ = static_cast<int>(words > 8 ? std::bit_ceil(words) : words); // each number of words is a program
  ranges_of_center_ = static_cast<int>(of_center);
  largest_tile_ = static_cast<int>(tile);
  ranges_.reserve(gl, GL_RG32I, tile * of_center);
  cell_count_ = space.cells.count;
  walks_.upload(gl, std::vector<int32_t>(WALKS_HEADER + 2 * static_cast<size_t>(cell_count_) + tile, 0), GL_DYNAMIC_COPY);
  neighborhoods_.upload(gl, nullptr, tile * sizeof(NeighborhoodRanges), GL_STREAM_COPY);
}

// What centers look at, made once for all that start in a cell.
void NeighborhoodSearch::list_near_cells(const Gl &gl, ProgramCache &programs, const CellBuffers &cells, const NearCells &near) {
  near_spheres_.reserve(gl, GL_RGBA32F, near.cell.size());
  near_traits_.reserve(gl, GL_RGBA32I, NEAR_TRAITS * near.cell.size());
  near_neighbors_.reserve(gl, GL_RGBA32I, near.neighbors);
  gl.UseProgram(programs.get(gl, "near", {{GL_COMPUTE_SHADER, "opengl/cells/near.comp.glsl"}}));
  cells.bind_to_search(gl);
  gl.BindTextureUnit(UNIT_CELL_LISTS, cell_lists_.id());
  gl.BindTextureUnit(UNIT_NEAR_CELLS, near_cells_.id());
  gl.BindTextureUnit(UNIT_NEAR_NORMALS, near_normals_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_CELLS, has_texelless_ ? measured_.buffer_id() : cells.measured());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_NEAR_SPHERES, near_spheres_.buffer_id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_NEAR_TRAITS, near_traits_.buffer_id());
  dispatch_invocations(gl, static_cast<int>(near.cell.size()), int64_t{1} << 20);
  gl.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
}

void NeighborhoodSearch::set(const Gl &gl, ProgramCache &programs, const CellBuffers &cells, const SearchSpace &space) {
  has_texelless_ = !space.texelless.samples.empty();
  halves_ = space.halves;
  fine_ = space.near.any_fine;
  texelless_.upload(gl, space.texelless.samples, GL_STREAM_DRAW);
  measured_.upload(gl, GL_RGBA32F, space.measured.data(), space.measured.size() * CELL_VECTORS, GL_STREAM_DRAW);
  list_cells(gl, space);
  near_cells_.upload(gl, GL_RGBA32I, space.near.cell.data(), space.near.cell.size(), GL_STREAM_DRAW);
  near_normals_.upload(gl, GL_RGBA32F, space.near.normal.data(), space.near.normal.size(), GL_STREAM_DRAW);
  boundary_.upload(gl, GL_RGBA32F, space.boundary.data(), space.boundary.size(), GL_STREAM_DRAW);
  starts_.upload(gl, space.starts.range, GL_STREAM_DRAW);
  start_cells_.upload(gl, space.starts.cell, GL_STREAM_DRAW);
  list_near_cells(gl, programs, cells, space.near);
  make_room(gl, space);
  check_gl(gl, "neighborhood upload");
}

GLuint neighborhoods_program(const Gl &gl, ProgramCache &programs, const SearchVariant &variant) {
  const auto define = [](const char *name, bool value) { return std::string("#define ") + name + (value ? " 1\n" : " 0\n"); };
  const std::string text = define("OVER_LINKS", variant.over_links) + define("EXACT", variant.exact) +
                           define("ADAPTIVE", variant.halves) + define("TEXELLESS", variant.texelless) +
                           define("FINE", variant.fine) + "#define NEAR_WORDS " + std::to_string(variant.words) + "\n";
  return programs.get(gl, "neighborhoods " + text, {{GL_COMPUTE_SHADER, "opengl/cells/neighborhoods.comp.glsl"}},
                      {{"variant.glsl", text}});
}

void NeighborhoodSearch::use(const Gl &gl, ProgramCache &programs, bool over_links, bool exact) const {
  gl.UseProgram(neighborhoods_program(gl, programs, {over_links, exact, halves_, has_texelless_, fine_, near_words_}));
  gl.Uniform1i(LOCATION_RANGES, ranges_of_center_);
  gl.Uniform1i(LOCATION_CELLS, cell_count_);
}

void NeighborhoodSearch::run(const Gl &gl, ProgramCache &programs, const CellBuffers &cells, bool exact, int first,
                             int last) const {
  cells.bind_to_search(gl);
  if (has_texelless_) gl.BindTextureUnit(UNIT_CELLS, measured_.id());
  gl.BindTextureUnit(UNIT_CELL_LISTS, cell_lists_.id());
  gl.BindTextureUnit(UNIT_NEAR_CELLS, near_cells_.id());
  gl.BindTextureUnit(UNIT_NEAR_SPHERES, near_spheres_.id());
  gl.BindTextureUnit(UNIT_NEAR_TRAITS, near_traits_.id());
  gl.BindTextureUnit(UNIT_NEAR_NEIGHBORS, near_neighbors_.id());
  gl.BindTextureUnit(UNIT_BOUNDARY, boundary_.id());
  gl.BindTextureUnit(UNIT_STARTS, starts_.id());
  gl.BindTextureUnit(UNIT_START_CELLS, start_cells_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_NEIGHBORHOODS, neighborhoods_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_RANGES, ranges_.buffer_id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_WALKS, walks_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_NEAR_NEIGHBORS, near_neighbors_.buffer_id());
  gl.BindBuffer(GL_DISPATCH_INDIRECT_BUFFER, walks_.id());
  constexpr int32_t nothing[WALKS_HEADER] = {0, 1, 1, 0, 0, 1, 1, 0};
  gl.NamedBufferSubData(walks_.id(), 0, sizeof nothing, nothing);
  use(gl, programs, false, exact);
  gl.DispatchCompute(group_count(gl, last - first), 1, 1);
  gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
  gl.UseProgram(programs.get(gl, "near neighbors", {{GL_COMPUTE_SHADER, "opengl/cells/near_neighbors.comp.glsl"}}));
  gl.Uniform1i(LOCATION_CELLS, cell_count_);
  gl.DispatchComputeIndirect(WALKS_LISTS_GROUPS * sizeof(int32_t));
  gl.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
  use(gl, programs, true, exact);
  gl.DispatchComputeIndirect(WALKS_CENTERS_GROUPS * sizeof(int32_t));
  gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
  check_gl(gl, "neighborhoods");
}

void NeighborhoodSearch::bind(const Gl &gl) const {
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_NEIGHBORHOODS, neighborhoods_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_TEXELLESS, texelless_.id());
  gl.BindTextureUnit(UNIT_RANGES, ranges_.id());
}

} // namespace paradesc
