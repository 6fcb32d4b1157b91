// V_r, paper eq. (6, 7): the part of the ball that lies inside the surface.
float sphere_volume(Terms terms, Center center, Neighborhood neighborhood) {
  float radius = neighborhood.radius;
  return ball_share(terms.ball, neighborhood) * 4.0f / 3.0f * PI * radius * radius * radius;
}
