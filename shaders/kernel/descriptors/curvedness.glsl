// sqrt((k1^2 + k2^2)/2).
float curvedness(Terms terms, Center center, Support support) {
  return sqrt(0.5f * (support.k1 * support.k1 + support.k2 * support.k2));
}
