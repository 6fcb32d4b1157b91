// Operators on a map: the plain definitions.
#include "engine/reference/reference.h"

namespace paradesc {

double reference_gradient_magnitude(const ReferenceNeighborhood &neighborhood) {
  return glm::length(neighborhood.window.gradient);
}

double reference_laplacian(const ReferenceNeighborhood &neighborhood) { return neighborhood.window.laplacian; }

double reference_difference_of_gaussians(const ReferenceNeighborhood &neighborhood) {
  return neighborhood.window.narrow - neighborhood.window.wide;
}

double reference_harris(const ReferenceNeighborhood &neighborhood) {
  const dvec3 a = neighborhood.window.tensor;
  const double trace = a.x + a.z;
  return a.x * a.z - a.y * a.y - neighborhood.window.harris_k * trace * trace;
}

dvec3 reference_map_gradient(const ReferenceNeighborhood &neighborhood) { return neighborhood.window.gradient; }

} // namespace paradesc
