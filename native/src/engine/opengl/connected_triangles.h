// Ambiguous centers, whose samples do not look like one sheet of surface → those that have to be computed again, on exactly the
// triangles that are connected to them within the ball: found on the device, by floods over patches (mesh/patches.h).
//
// Cells resolve what is connected only to the size of a cell. Where a neighborhood is no disk, a neighboring finger may have come
// in with a cell that holds both. Where its area is that of the connected triangles, none did.
#pragma once

#include <span>
#include <vector>

#include "engine/opengl/device_surface.h"
#include "mesh/patches.h"

#include "shared.h"

namespace paradesc {

// How many patches a flood may come to if balls hold about so many triangles.
int expected_patches(double triangles);
// Bytes that are kept of so many centers.
int64_t bytes_of_floods(int64_t centers, int patches);

// How many patches floods may have room for: each number is a program.
std::span<const int> flood_rooms();
GLuint flood_program(const Gl &gl, ProgramCache &programs, int patches);

class ConnectedTriangles {
public:
  // Uploads what depends on how the mesh hangs together.
  void set_mesh(const Gl &gl, const Triangles &triangles, const HalfEdges &half_edges, const Patches &patches);
  // Measures the patches where the surface lies now.
  void measure(const Gl &gl, ProgramCache &programs, const DeviceSurface &surface);
  // codes: of a triangle that each center lies on.
  void set_starts(const Gl &gl, std::span<const int32_t> codes);
  // Floods have room for so many patches, until they ask for more or less.
  void expect(int patches);
  // From here on no center is ambiguous. most_centers: centers that are computed again side by side.
  void begin(const Gl &gl, int centers, int most_centers);
  // Whether floods that came to so many patches had room; makes as much of it as they need from here on.
  bool make_room(int patches);

  int slots() const { return slots_; } // for centers that are computed again side by side
  int room() const { return room_; }   // in patches
  int flood_table() const;             // as EvaluateParams has it
  GLuint list() const { return list_.id(); }
  // Binds what programs read that compute centers again.
  void bind(const Gl &gl) const;
  // Looks at so many ambiguous centers, slots() at most, whose parameters, centers and results are bound. Those to be computed
  // again are the next ones.
  void flood(const Gl &gl, ProgramCache &programs, const DeviceSurface &surface, int count) const;

private:
  BufferTexture triangles_, codes_, ranges_, neighbors_, spheres_, starts_;
  Buffer list_;
  int patch_count_ = 0, slots_ = 1, room_ = 0;
};

} // namespace paradesc
