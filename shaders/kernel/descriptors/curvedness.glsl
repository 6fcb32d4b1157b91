// sqrt((k1^2 + k2^2)/2).
float curvedness(Terms terms, Center center, Neighborhood neighborhood) {
  return sqrt(0.5f * (neighborhood.k1 * neighborhood.k1 + neighborhood.k2 * neighborhood.k2));
}
