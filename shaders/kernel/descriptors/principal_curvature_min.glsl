// k2, by the shape operator or by paper eq. (10).
float principal_curvature_min(Terms terms, Center center, Neighborhood neighborhood) {
  return neighborhood.k2;
}
