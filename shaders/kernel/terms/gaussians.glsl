// Terms of the means of a map f in two Gaussian windows: the narrower has sigma over GAUSSIANS_RATIO.
struct GaussiansTerms {
  vec4 narrow; // sum of w G: 1, f, x, y
  vec4 wide;
};
void gaussians_init(OUT(GaussiansTerms) terms) {
  terms.narrow = vec4(0.0f);
  terms.wide = vec4(0.0f);
}
void gaussians_add(INOUT(GaussiansTerms) terms, Center center, Neighbor neighbor) {
  vec4 term = neighbor.weight * vec4(1.0f, neighbor.value, neighbor.coordinates.x, neighbor.coordinates.y);
  terms.narrow += gaussian(neighbor.rho, params.map_sigma / float(GAUSSIANS_RATIO)) * term;
  terms.wide += gaussian(neighbor.rho, params.map_sigma) * term;
}
