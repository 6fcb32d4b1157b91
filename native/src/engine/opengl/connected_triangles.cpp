// The mesh's lists are in buffer textures; one storage buffer has the state of floods.
#include "engine/opengl/connected_triangles.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <string>

#include "engine/opengl/dispatch.h"

namespace paradesc {

static_assert(Patches::max_triangles == PATCH_TRIANGLES);

// The last number is room for some 10,000 triangles. Centers with larger floods keep the results that their samples gave.
static constexpr int rooms[] = {20, 32, 128, 512};
static_assert(rooms[1] <= MOST_FEW_PATCHES && rooms[2] > MOST_FEW_PATCHES);
static constexpr int64_t most_bytes = int64_t{1} << 26;

std::span<const int> flood_rooms() { return rooms; }

static int room_for(int patches) {
  for (const int room : rooms)
    if (patches <= room) return room;
  return rooms[std::size(rooms) - 1];
}

int expected_patches(double triangles) {
  // A disk of patches that are nearly full, with half a patch more around it; the factor allows for balls that hold more.
  constexpr double of_patch = 25.0, spread = 1.5;
  const double across = std::sqrt(std::min(triangles, 1e6)) + 2.0 * std::sqrt(of_patch);
  return static_cast<int>(spread * across * across / of_patch);
}

static int table_of(int room) { return static_cast<int>(std::bit_ceil(2 * static_cast<uint32_t>(room))); }

// Integers per center, for the centers that are computed again side by side.
static size_t size_of_slot(int room) { return static_cast<size_t>(2 * table_of(room) + 1); }

int64_t bytes_of_floods(int64_t centers, int patches) {
  return std::min(centers * static_cast<int64_t>(size_of_slot(room_for(patches)) * sizeof(int32_t)), most_bytes);
}

int ConnectedTriangles::flood_table() const { return table_of(room_); }

void ConnectedTriangles::expect(int patches) { room_ = room_for(patches); }

bool ConnectedTriangles::make_room(int patches) {
  const int before = room_;
  room_ = std::max(room_for(patches), std::min(room_, room_for(patches + patches / 8))); // a smaller room is faster
  return room_ <= before;
}

GLuint flood_program(const Gl &gl, ProgramCache &programs, int patches) {
  const std::string text = define("FLOOD_PATCHES", patches);
  return programs.get(gl, "flood " + text, {{GL_COMPUTE_SHADER, "opengl/connected/flood.comp.glsl"}}, {{"variant.glsl", text}});
}

void ConnectedTriangles::set_mesh(const Gl &gl, const Triangles &triangles, const HalfEdges &half_edges, const Patches &patches) {
  std::vector<ivec4> rows;
  rows.reserve(2 * patches.triangle.size());
  for (const int32_t triangle : patches.triangle) {
    ivec4 corners(-1), across(-1);
    for (int i = 0; triangle >= 0 && i < 3; ++i) {
      corners[i] = triangles.corner_vertex[3 * triangle + i];
      across[i] = patches.across(half_edges, 3 * triangle + i);
    }
    rows.insert(rows.end(), {corners, across});
  }
  std::vector<ivec2> ranges;
  for (int32_t i = 0; i < patches.count(); ++i) ranges.emplace_back(patches.neighbor_begin[i], patches.neighbor_begin[i + 1]);
  patch_count_ = patches.count();
  triangles_.upload(gl, GL_RGBA32I, rows, GL_STATIC_DRAW);
  codes_.upload(gl, GL_R32I, patches.code, GL_STATIC_DRAW);
  ranges_.upload(gl, ranges);
  neighbors_.upload(gl, patches.neighbor);
  check_gl(gl, "upload of patches");
}

void ConnectedTriangles::measure(const Gl &gl, ProgramCache &programs, const DeviceSurface &surface) {
  spheres_.reserve(gl, GL_RGBA32F, 2 * static_cast<size_t>(patch_count_));
  gl.UseProgram(programs.get(gl, "patches", {{GL_COMPUTE_SHADER, "opengl/connected/patches.comp.glsl"}}));
  surface.bind_measured(gl);
  gl.BindTextureUnit(UNIT_PATCH_TRIANGLES, triangles_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_PATCH_SPHERES, spheres_.buffer_id());
  dispatch_invocations(gl, patch_count_, int64_t{1} << 16);
  gl.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
  check_gl(gl, "patches");
}

void ConnectedTriangles::set_starts(const Gl &gl, std::span<const int32_t> codes) {
  starts_.upload(gl, GL_R32I, codes.data(), codes.size(), GL_STATIC_DRAW);
  check_gl(gl, "upload of starts");
}

void ConnectedTriangles::begin(const Gl &gl, int centers, int most_centers) {
  const auto group = static_cast<size_t>(gl.limits.group_size), one = size_of_slot(room_);
  const size_t all = in_whole_groups(gl, static_cast<size_t>(centers));
  const size_t fit =
      std::min(static_cast<size_t>(most_bytes) / sizeof(int32_t) / one, static_cast<size_t>(most_centers)) / group * group;
  const size_t slots = std::clamp(fit, group, std::max(all, group));
  const size_t bytes = (CONNECTED_HEADER + static_cast<size_t>(centers) + slots * one) * sizeof(int32_t);
  slots_ = static_cast<int>(slots);
  list_.reserve(gl, bytes);
  constexpr int32_t nothing[CONNECTED_AGAIN_GROUPS] = {}; // the number of ambiguous centers; the largest number of patches
  gl.NamedBufferSubData(list_.id(), 0, sizeof nothing, nothing);
}

void ConnectedTriangles::bind(const Gl &gl) const {
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_CONNECTED, list_.id());
  gl.BindTextureUnit(UNIT_TRIANGLE_CODES, codes_.id());
}

void ConnectedTriangles::flood(const Gl &gl, ProgramCache &programs, const DeviceSurface &surface, int count) const {
  constexpr int32_t nothing[] = {0, 1, 1, 0};
  gl.NamedBufferSubData(list_.id(), CONNECTED_AGAIN_GROUPS * sizeof(int32_t), sizeof nothing, nothing);
  gl.UseProgram(flood_program(gl, programs, room_));
  bind(gl);
  surface.bind_measured(gl);
  gl.BindTextureUnit(UNIT_START_CODES, starts_.id());
  gl.BindTextureUnit(UNIT_PATCH_TRIANGLES, triangles_.id());
  gl.BindTextureUnit(UNIT_PATCH_RANGES, ranges_.id());
  gl.BindTextureUnit(UNIT_PATCH_NEIGHBORS, neighbors_.id());
  gl.BindTextureUnit(UNIT_PATCH_SPHERES, spheres_.id());
  gl.DispatchCompute(group_count(gl, count), 1, 1);
  gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
  check_gl(gl, "floods");
}

} // namespace paradesc
