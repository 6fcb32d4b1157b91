// H, by the shape operator or by paper eq. (8): find_curvatures() of sums.glsl chooses, ball.glsl has eq. (8).
float mean_curvature(Terms terms, Center center, Neighborhood neighborhood) {
  return neighborhood.mean;
}
