// Searches lists of cells in buffer textures, by dispatches over centers.
#include "engine/opengl/neighborhood_search.h"

#include <algorithm>
#include <bit>
#include <string>

#include "engine/opengl/dispatch.h"

namespace paradesc {

void NeighborhoodSearch::set_starts(const Gl &gl, const Starts &starts, uint64_t version) {
  if (starts_version_ == version) return;
  starts_.upload(gl, starts.range);
  start_cells_.upload(gl, starts.cell);
  start_lists_.upload(gl, starts.list);
  list_count_ = static_cast<int>(starts.list.size());
  center_count_ = static_cast<int>(starts.order.size());
  check_gl(gl, "upload of starts");
  starts_version_ = version;
}

// Gives the lists of ranges of a dispatch their largest possible length, so that nothing has to be counted first.
void NeighborhoodSearch::make_room(const Gl &gl, const CellBuffers &cells) {
  const size_t of_cell = (halves_ ? 2 * CELL_LEAVES : CELL_LEAVES) + (cells.has_texelless() ? 1 : 0);
  const auto group = static_cast<size_t>(gl.limits.group_size), longest = static_cast<size_t>(cells.room().longest);
  const size_t centers = in_whole_groups(gl, static_cast<size_t>(center_count_));
  const size_t of_center = std::max<size_t>(1, longest * of_cell);
  const size_t fit = static_cast<size_t>(gl.limits.ranges) / of_center;
  const size_t most = std::clamp(fit / group * group, group, std::max(centers, group));
  const size_t words = std::max<size_t>(1, longest / 32);
  near_words_ = static_cast<int>(words > 8 ? std::bit_ceil(words) : words); // each number of words is a program
  ranges_of_center_ = static_cast<int>(of_center);
  most_centers_ = static_cast<int>(most);
  ranges_.reserve(gl, GL_RG32I, most * of_center);
  walks_.repeat(gl, 0, WALKS_HEADER + 2 * static_cast<size_t>(list_count_) + most, GL_DYNAMIC_COPY);
  neighborhoods_.reserve(gl, most * sizeof(NeighborhoodRanges));
}

// Counts the near cells, then lists them, then copies the data that centers read; centers that start in one cell share a list.
void NeighborhoodSearch::list_near_cells(const Gl &gl, ProgramCache &programs, const CellBuffers &cells, GLuint centers) {
  const auto room = static_cast<size_t>(std::max(cells.room().cells, 1)),
             neighbors = static_cast<size_t>(std::max(cells.room().neighbors, 1)),
             lists = static_cast<size_t>(std::max(list_count_, 1));
  near_ranges_.reserve(gl, GL_RGBA32I, lists);
  near_normals_.reserve(gl, GL_RGBA32F, lists);
  near_balls_.reserve(gl, GL_RGBA32F, lists);
  near_cells_.reserve(gl, GL_R32I, room);
  near_lists_.reserve(gl, GL_RG32I, room);
  found_cells_.reserve(gl, lists * static_cast<size_t>(cells.room().longest) * sizeof(int32_t));
  near_spheres_.reserve(gl, GL_RGBA32F, room);
  near_traits_.reserve(gl, GL_RGBA32I, NEAR_TRAITS * room);
  near_neighbors_.reserve(gl, GL_RGBA32I, neighbors);
  cells.bind_to_lists(gl);
  gl.BindTextureUnit(UNIT_START_LISTS, start_lists_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_CENTERS, centers);
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_NEAR_CELLS, near_cells_.buffer_id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_NEAR_LISTS, near_lists_.buffer_id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_NEAR_RANGES, near_ranges_.buffer_id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_NEAR_NORMALS, near_normals_.buffer_id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_NEAR_BALLS, near_balls_.buffer_id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_FOUND_CELLS, found_cells_.id());
  gl.UseProgram(programs.get(gl, "lists", {{GL_COMPUTE_SHADER, "opengl/cells/lists.comp.glsl"}}));
  gl.Uniform1i(LOCATION_NODES, cells.node_count());
  dispatch_invocations(gl, list_count_, int64_t{1} << 14);
  gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  gl.UseProgram(programs.get(gl, "fill", {{GL_COMPUTE_SHADER, "opengl/cells/fill.comp.glsl"}}));
  dispatch_invocations(gl, list_count_, int64_t{1} << 14);
  gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT);
  gl.UseProgram(programs.get(gl, "near", {{GL_COMPUTE_SHADER, "opengl/cells/near.comp.glsl"}}));
  gl.BindTextureUnit(UNIT_NEAR_CELLS, near_cells_.id());
  gl.BindTextureUnit(UNIT_NEAR_LISTS, near_lists_.id());
  gl.BindTextureUnit(UNIT_NEAR_NORMALS, near_normals_.id());
  gl.BindTextureUnit(UNIT_NEAR_BALLS, near_balls_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_NEAR_RANGES, near_ranges_.buffer_id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_NEAR_SPHERES, near_spheres_.buffer_id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_NEAR_TRAITS, near_traits_.buffer_id());
  dispatch_invocations(gl, static_cast<int>(room), int64_t{1} << 20);
  gl.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
}

void NeighborhoodSearch::set(const Gl &gl, ProgramCache &programs, CellBuffers &cells, const SearchSpace &space) {
  halves_ = space.halves;
  boundary_.upload(gl, GL_RGBA32F, space.boundary.data(), space.boundary.size(), GL_STREAM_DRAW);
  cells.begin_lists(gl);
  list_near_cells(gl, programs, cells, space.centers);
  make_room(gl, cells);
  check_gl(gl, "neighborhood lists");
}

GLuint neighborhoods_program(const Gl &gl, ProgramCache &programs, const SearchVariant &variant) {
  const std::string text = define("OVER_LINKS", variant.over_links) + define("EXACT", variant.exact) +
                           define("ADAPTIVE", variant.halves) + define("TEXELLESS", variant.texelless) +
                           define("FINE", variant.fine) + define("NEAR_WORDS", variant.words);
  return programs.get(gl, "neighborhoods " + text, {{GL_COMPUTE_SHADER, "opengl/cells/neighborhoods.comp.glsl"}},
                      {{"variant.glsl", text}});
}

void NeighborhoodSearch::use(const Gl &gl, ProgramCache &programs, const CellBuffers &cells, bool over_links, bool exact) const {
  gl.UseProgram(neighborhoods_program(gl, programs,
                                      {over_links, exact, halves_, cells.has_texelless(), cells.room().fine != 0, near_words_}));
  gl.Uniform1i(LOCATION_RANGES, ranges_of_center_);
  gl.Uniform1i(LOCATION_LISTS, list_count_);
}

void NeighborhoodSearch::run(const Gl &gl, ProgramCache &programs, const CellBuffers &cells, bool exact, int count) const {
  cells.bind_to_search(gl);
  gl.BindTextureUnit(UNIT_NEAR_RANGES, near_ranges_.id());
  gl.BindTextureUnit(UNIT_NEAR_CELLS, near_cells_.id());
  gl.BindTextureUnit(UNIT_NEAR_LISTS, near_lists_.id());
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
  use(gl, programs, cells, false, exact);
  gl.DispatchCompute(group_count(gl, count), 1, 1);
  gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
  gl.UseProgram(programs.get(gl, "near neighbors", {{GL_COMPUTE_SHADER, "opengl/cells/near_neighbors.comp.glsl"}}));
  gl.Uniform1i(LOCATION_LISTS, list_count_);
  gl.DispatchComputeIndirect(WALKS_LISTS_GROUPS * sizeof(int32_t));
  gl.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
  use(gl, programs, cells, true, exact);
  gl.DispatchComputeIndirect(WALKS_CENTERS_GROUPS * sizeof(int32_t));
  gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
  check_gl(gl, "neighborhoods");
}

void NeighborhoodSearch::bind(const Gl &gl) const {
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_NEIGHBORHOODS, neighborhoods_.id());
  gl.BindTextureUnit(UNIT_RANGES, ranges_.id());
}

} // namespace paradesc
