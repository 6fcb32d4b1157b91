// Terms of the sphere volume (paper eq. 6, 7, 8), and the mean curvature that follows from it.
struct BallTerms {
  float rho;    // sum of w rho
  float height; // sum of w n.d
#if VARIATE
  vec3 moments; // sum of w rho^2 e e^T
#endif
};
void ball_init(OUT(BallTerms) terms) {
  terms.rho = 0.0f;
  terms.height = 0.0f;
#if VARIATE
  terms.moments = vec3(0.0f);
#endif
}
void ball_add(INOUT(BallTerms) terms, Center center, Neighbor neighbor) {
  terms.rho += neighbor.weight * neighbor.mean_rho;
  terms.height += neighbor.weight * dot(center.normal, neighbor.offset);
#if VARIATE
  terms.moments += neighbor.weight * neighbor.rho * neighbor.rho * outer(neighbor.direction);
#endif
}
// H of eq. (8). With the shape operator as control variate, only the part of a_i that -rho kappa_S(e)/2 does not explain is
// averaged.
float ball_mean_curvature(BallTerms terms, Neighborhood neighborhood) {
  if (!(terms.rho > 0.0f)) return NOT_A_NUMBER;
  float mean = terms.height / terms.rho;
  float exact = 0.0f;
#if VARIATE
  if (neighborhood.variate > 0.0f) {
    mean += neighborhood.variate * 0.5f * normal_curvature(neighborhood.shape, terms.moments) / terms.rho;
    exact = neighborhood.variate * exact_means(neighborhood).y;
  }
#endif
  return exact - 8.0f / (3.0f * neighborhood.radius) * mean;
}
// V_r/(4 pi r^3/3), the share of the ball inside the surface.
float ball_share(BallTerms terms, Neighborhood neighborhood) {
  if (!(terms.rho > 0.0f)) return 0.0f; // no samples; drivers differ in clamp(NaN)
  return clamp(0.5f - 3.0f / 16.0f * ball_mean_curvature(terms, neighborhood) * neighborhood.radius, 0.0f, 1.0f);
}
