// Terms of the sphere volume (paper eq. 6, 7, 8), and the mean curvature that belongs to it.
struct BallTerms {
  float rho;    // sum of w rho
  float height; // sum of w n.d
  vec3 moments; // sum of w rho^2 e e^T
};
void ball_init(out BallTerms terms) {
  terms.rho = 0.0;
  terms.height = 0.0;
  terms.moments = vec3(0.0);
}
void ball_add(inout BallTerms terms, Center center, Neighbor neighbor) {
  terms.rho += neighbor.weight * neighbor.rho;
  terms.height += neighbor.weight * dot(center.normal, neighbor.offset);
  terms.moments += neighbor.weight * neighbor.rho * neighbor.rho * outer(neighbor.direction);
}
// H of eq. (8). With the shape operator as control variate only what -rho kappa_S(e)/2 does not explain of a_i is averaged.
float ball_mean_curvature(BallTerms terms, Support support) {
  if (!(terms.rho > 0.0)) return NOT_A_NUMBER;
  float mean = terms.height / terms.rho;
  float exact = 0.0;
  if (support.variate > 0.0) {
    mean += support.variate * 0.5 * normal_curvature(support.shape, terms.moments) / terms.rho;
    exact = support.variate * exact_means(support).y;
  }
  return exact - 8.0 / (3.0 * support.radius) * mean;
}
// V_r/(4 pi r^3/3), the share of the ball inside the surface.
float ball_share(BallTerms terms, Support support) {
  return clamp(0.5 - 3.0 / 16.0 * ball_mean_curvature(terms, support) * support.radius, 0.0, 1.0);
}
