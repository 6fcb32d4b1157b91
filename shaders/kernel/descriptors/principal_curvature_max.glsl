// k1, by the shape operator or by paper eq. (10).
float principal_curvature_max(Terms terms, Center center, Support support) {
  return support.k1;
}
