// k1, by the shape operator or by paper eq. (10).
float principal_curvature_max(Terms terms, Center center, Neighborhood neighborhood) {
  return neighborhood.k1;
}
