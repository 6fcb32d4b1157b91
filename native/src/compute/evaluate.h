// A surface and options → values at its points, and images over its UV map: everything that is the same for all engines.
#pragma once

#include <vector>

#include "compute/mesh.h"

namespace paradesc {

struct Computed {
  CenterResults results; // at the points of the mesh
  pdesc_field_report report{};
  std::vector<std::vector<float>> images; // from images_of, if texels were evaluated
  int image_size = 0;
};

// Throws Error: CANCELLED, or the failure. The mesh's session stays usable.
Computed evaluate(Mesh &mesh, const Surface &surface, const Request &request, const Progress &progress);

} // namespace paradesc
