// det A - k tr^2 A (paper eq. 15, 16), A the mean of (r grad f)(r grad f)^T in a Gaussian window, each
// turned into the tangent plane of the center.
#include "kernel/terms/gaussian.glsl"
struct State {
  float weight; // sum of w G
  vec3 tensor;  // of w G (r grad f)(r grad f)^T
};
void descriptor_init(out State state) {
  state.weight = 0.0;
  state.tensor = vec3(0.0);
}
void descriptor_add(inout State state, Center center, Neighbor neighbor) {
  if (isnan(neighbor.slope.x)) return;
  float weight = neighbor.weight * gaussian(neighbor.rho, sigma);
  state.weight += weight;
  state.tensor += weight * outer(neighbor.slope);
}
float descriptor_finish(State state, Center center, Support support) {
  if (!(state.weight > 0.0) || isnan(center.value)) return NOT_A_NUMBER;
  vec3 a = state.tensor / state.weight;
  float trace = a.x + a.z;
  return a.x * a.z - a.y * a.y - harris_k * trace * trace;
}
