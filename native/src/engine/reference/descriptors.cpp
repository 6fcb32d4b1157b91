// Descriptors of the surface: the plain definitions, one function each.
#include "engine/reference/reference.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernel/limits.h"

namespace paradesc {

static constexpr double undefined = std::numeric_limits<double>::quiet_NaN();

double reference_mean_curvature(const ReferenceNeighborhood &neighborhood) { return neighborhood.mean; }

double reference_gaussian_curvature(const ReferenceNeighborhood &neighborhood) { return neighborhood.gauss; }

double reference_principal_curvature_max(const ReferenceNeighborhood &neighborhood) { return neighborhood.k1; }

double reference_principal_curvature_min(const ReferenceNeighborhood &neighborhood) { return neighborhood.k2; }

double reference_shape_index(const ReferenceNeighborhood &neighborhood) {
  const double k1 = neighborhood.k1, k2 = neighborhood.k2;
  if (!(std::max(std::abs(k1), std::abs(k2)) * neighborhood.radius >= PLANE_THRESHOLD)) return undefined;
  return 2 / pi * std::atan2(k1 + k2, k1 - k2);
}

double reference_curvedness(const ReferenceNeighborhood &neighborhood) {
  return std::sqrt(0.5 * (neighborhood.k1 * neighborhood.k1 + neighborhood.k2 * neighborhood.k2));
}

double reference_local_bending_energy(const ReferenceNeighborhood &neighborhood) {
  return neighborhood.area > 0 ? neighborhood.bending / neighborhood.area : undefined;
}

double reference_sphere_volume(const ReferenceNeighborhood &neighborhood) {
  const double r = neighborhood.radius;
  return reference_sphere_volume_normalized(neighborhood) * 4 * pi / 3 * r * r * r;
}

// V_r = 4 pi r^3/3 - V_o with V_o = (2 pi r^3/3)(1 - height/rho), over 4 pi r^3/3.
double reference_sphere_volume_normalized(const ReferenceNeighborhood &neighborhood) {
  return neighborhood.rho > 0 ? 0.5 * (1 + neighborhood.height / neighborhood.rho) : undefined;
}

double reference_geodesic_area(const ReferenceNeighborhood &neighborhood) {
  return neighborhood.area > 0 ? neighborhood.geodesic_area : undefined;
}

double reference_cavity(const ReferenceNeighborhood &neighborhood) {
  const double bend = -neighborhood.mean * neighborhood.radius;
  return std::isnan(bend) ? bend : std::clamp(bend, 0.0, 1.0);
}

double reference_convexity(const ReferenceNeighborhood &neighborhood) {
  const double bend = neighborhood.mean * neighborhood.radius;
  return std::isnan(bend) ? bend : std::clamp(bend, 0.0, 1.0);
}

double reference_ambient_openness(const ReferenceNeighborhood &neighborhood) {
  return 1.0 - reference_sphere_volume_normalized(neighborhood);
}

static dvec3 positive_direction(dvec3 v) {
  const dvec3 size = glm::abs(v);
  const double largest = size.x >= size.y && size.x >= size.z ? v.x : size.y >= size.z ? v.y : v.z;
  return largest < 0 ? -v : v;
}

dvec3 reference_principal_direction_max(const ReferenceNeighborhood &neighborhood) {
  return positive_direction(neighborhood.direction_max);
}

dvec3 reference_principal_direction_min(const ReferenceNeighborhood &neighborhood) {
  return positive_direction(neighborhood.direction_min);
}

double reference_standard_error(const ReferenceNeighborhood &neighborhood) { return neighborhood.standard_error; }

double reference_euclidean_area(const ReferenceNeighborhood &neighborhood) {
  return neighborhood.area > 0 ? neighborhood.area : undefined;
}

} // namespace paradesc
