// K, by the shape operator or by paper eq. (11).
float gaussian_curvature(Terms terms, Center center, Neighborhood neighborhood) {
  return neighborhood.gauss;
}
