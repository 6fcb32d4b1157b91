// V_r/(4 pi r^3/3), paper eq. (7): 0.5 on a plane.
float sphere_volume_normalized(Terms terms, Center center, Neighborhood neighborhood) {
  return ball_share(terms.ball, neighborhood);
}
