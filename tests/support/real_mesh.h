// A Wavefront file of ../shared/meshes → a TestMesh without closed forms; those files are not ours, and tests skip where they are
// absent.
#pragma once

#include <optional>
#include <string>

#include "support/surfaces.h"

namespace paradesc::test {

// Positions and UVs of the file; without UVs in it, each face is thrown onto the side of a cube that it looks at, six cells side
// by side. Vertices without a face are left out.
std::optional<TestMesh> read_real_mesh(const std::string &name);

// Skips the test where the mesh is absent.
#define PDESC_REAL_MESH(mesh, name)                                                                                              \
  const std::optional<TestMesh> mesh##_or_none = read_real_mesh(name);                                                           \
  if (!mesh##_or_none) GTEST_SKIP() << "real meshes are not at ../shared/meshes (" << (name) << ".obj)";                         \
  const TestMesh &mesh = *mesh##_or_none

} // namespace paradesc::test
