// Ambiguous centers, whose samples do not look like one sheet of surface → those that must be computed again, on exactly the
// triangles that are connected to them within the ball. Floods over patches on the device find them (mesh/patches.h).
//
// Cells resolve connectivity only to the size of a cell. If a neighborhood is not a disk, samples of a neighboring finger may
// have come in with a cell that holds both. If its area equals that of the connected triangles, none did.
#pragma once

#include <span>
#include <vector>

#include "engine/opengl/device_surface.h"
#include "mesh/patches.h"

#include "shared.h"

namespace paradesc {

// The number of patches that a flood may need if balls hold about this many triangles.
int expected_patches(double triangles);
// Bytes of the floods of so many centers.
int64_t bytes_of_floods(int64_t centers, int patches);

// The capacities, in patches, that floods may have: each capacity is a program of its own.
std::span<const int> flood_rooms();
GLuint flood_program(const Gl &gl, ProgramCache &programs, int patches);

class ConnectedTriangles {
public:
  // Uploads everything that depends on connectivity alone.
  void set_mesh(const Gl &gl, const Triangles &triangles, const HalfEdges &half_edges, const Patches &patches);
  // Measures the patches of the current surface.
  void measure(const Gl &gl, ProgramCache &programs, const DeviceSurface &surface);
  // codes: the code of one triangle per center, on which the center lies.
  void set_starts(const Gl &gl, std::span<const int32_t> codes);
  // Gives floods room for so many patches, until make_room() changes it.
  void expect(int patches);
  // Resets the list of ambiguous centers. most_centers: how many centers can be computed again side by side.
  void begin(const Gl &gl, int centers, int most_centers);
  // Returns whether floods that needed so many patches had room; later floods get as much room as these needed.
  bool make_room(int patches);

  int slots() const { return slots_; } // for centers that are computed again side by side
  int room() const { return room_; }   // in patches
  int flood_table() const;             // as in EvaluateParams
  GLuint list() const { return list_.id(); }
  // Binds the inputs of programs that compute centers again.
  void bind(const Gl &gl) const;
  // Checks up to `count` ambiguous centers, at most slots() of them, whose parameters, centers and results are bound. Those that
  // fail the check are the next ones to be computed again.
  void flood(const Gl &gl, ProgramCache &programs, const DeviceSurface &surface, int count) const;

private:
  BufferTexture triangles_, codes_, ranges_, neighbors_, spheres_, starts_;
  Buffer list_;
  int patch_count_ = 0, slots_ = 1, room_ = 0;
};

} // namespace paradesc
