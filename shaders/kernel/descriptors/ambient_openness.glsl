// V_o/(4 pi r^3/3), paper eq. (6): the share of the ball outside the surface.
float ambient_openness(Terms terms, Center center, Neighborhood neighborhood) {
  return 1.0f - ball_share(terms.ball, neighborhood);
}
