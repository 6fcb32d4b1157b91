// The mean of f in a Gaussian window of sigma/1.6 less that in one of sigma. On a full disk the slope of f adds nothing to either: what it
// adds to the sums over samples is taken out.
#include "kernel/terms/gaussian.glsl"
#include "kernel/terms/jet.glsl"
struct State {
  vec4 narrow; // sum of w G: 1, f, x, y
  vec4 wide;
  JetTerms terms;
};
void descriptor_init(out State state) {
  state.narrow = vec4(0.0);
  state.wide = vec4(0.0);
  jet_init(state.terms);
}
void descriptor_add(inout State state, Center center, Neighbor neighbor) {
  vec4 term = neighbor.weight * vec4(1.0, neighbor.value, neighbor.place);
  state.narrow += gaussian(neighbor.rho, sigma / GAUSSIANS_RATIO) * term;
  state.wide += gaussian(neighbor.rho, sigma) * term;
  jet_add(state.terms, neighbor);
}
float descriptor_finish(State state, Center center, Support support) {
  if (!(state.narrow.x > 0.0) || !(state.wide.x > 0.0)) return NOT_A_NUMBER;
  vec3 difference = state.narrow.yzw / state.narrow.x - state.wide.yzw / state.wide.x;
  vec2 slope = jet_finish(state.terms).plane.yz;
  if (support.variate > 0.0 && !isnan(slope.x)) difference.x -= support.variate * dot(slope, difference.yz);
  return difference.x;
}
