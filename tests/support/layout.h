// A TestMesh → its UV map: charts cut from the parameter domain, flattened, each placed in a cell of its own.
#pragma once

#include <cstdint>
#include <vector>

#include "support/surfaces.h"

namespace paradesc::test {

struct Layout {
  int charts = 1;     // blocks of the rectangle, or of the faces of a cube around a sphere; 1 on a sphere: the cube's net
  uint32_t seed = 1;  // of rotation, scale and mirroring
  double offset = 0;  // moves the seams over the surface; 0 to 0.5
  bool rotate = true; // each chart by an angle of its own
  bool mirror = true; // every third chart, never the first
  double smallest_scale = 0.6; // of what fits into its cell; a chart alone is never shrunk
  double anisotropy = 1;       // stretch of every chart along a direction of its own
  double warp = 0;             // bends the charts: largest shear, below 1
  double gutter = 4.0 / 1024;  // around each chart, in UV units
};

// Sets corner_uvs and triangle_chart. No chart overlaps itself or another one.
void lay_out(TestMesh &mesh, const Layout &layout);

// 1 at vertices with more than one wedge, and where such a vertex lies within r.
std::vector<uint8_t> near_seam(const TestMesh &mesh, double r);

// The same surface as exporters write it: one vertex for each wedge. origin[new vertex] is the old one.
struct SplitMesh {
  TestMesh mesh;
  std::vector<int32_t> origin;
};
SplitMesh split_at_seams(const TestMesh &mesh);

} // namespace paradesc::test
