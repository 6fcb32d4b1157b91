// Solids with flat faces and sharp edges, as triangles with outward winding.
#pragma once

#include <cstdint>
#include <vector>

#include "mesh/triangles.h"

namespace paradesc::test {

// These triangles, no edge of which is sharp.
Triangles shape(std::vector<vec3> positions, std::vector<int32_t> corners);

// From an apex at (0, 0, 1) to a regular polygon in the unit circle; no base.
Triangles cone(int sides);

// [-1, 1]³, each side as a grid of cells by cells.
Triangles box(int cells);

// A box of one quad a side, [-1, 1]³, whose edges and corners are cut off `width` before they meet: a bevel of one segment.
Triangles bevelled_box(double width);

// A regular polygon in the unit circle, from z = -1 to 1, in `rows` rows; caps of `rings` rings around their middle. With many
// sides it is a cylinder.
Triangles prism(int sides, int rows = 1, int rings = 1);

// Returns the diagonal of the bounding box.
double diagonal_of(const Triangles &triangles);

} // namespace paradesc::test
