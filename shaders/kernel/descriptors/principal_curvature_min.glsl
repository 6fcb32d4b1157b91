// k2, by the shape operator or by paper eq. (10).
float principal_curvature_min(Terms terms, Center center, Support support) {
  return support.k2;
}
