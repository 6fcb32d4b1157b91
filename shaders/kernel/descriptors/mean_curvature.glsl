// H, by the shape operator or by paper eq. (8).
float mean_curvature(Terms terms, Center center, Support support) {
  return support.mean;
}
