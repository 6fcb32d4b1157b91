// The convex part of H r, for masks: 0 on flat and concave surface, 1 where the surface bends by r or more tightly.
float convexity(Terms terms, Center center, Neighborhood neighborhood) {
  float bend = neighborhood.mean * neighborhood.radius;
  return isnan(bend) ? bend : clamp(bend, 0.0f, 1.0f);
}
