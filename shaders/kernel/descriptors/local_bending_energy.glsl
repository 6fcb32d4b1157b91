// Paper eq. (5): the mean of |n - n_i|^2/rho^2. With the shape operator as control variate only what |S e|^2 does not explain is
// averaged, and its exact mean (k1^2 + k2^2)/2 is added.
struct State {
  float bending; // sum of w |n - n_i|^2/rho^2
  vec3 moments;  // sum of w e e^T
};
void descriptor_init(out State state) {
  state.bending = 0.0;
  state.moments = vec3(0.0);
}
void descriptor_add(inout State state, Center center, Neighbor neighbor) {
  if (neighbor.near) return;
  vec3 turn = center.normal - neighbor.normal;
  state.bending += neighbor.weight * dot(turn, turn) / (neighbor.rho * neighbor.rho);
  state.moments += neighbor.weight * outer(neighbor.direction);
}
float descriptor_finish(State state, Center center, Support support) {
  float weight = state.moments.x + state.moments.z;
  if (!(weight > 0.0)) return NOT_A_NUMBER;
  if (!(support.variate > 0.0)) return state.bending / weight;
  float explained = normal_curvature(square(support.shape), state.moments) / weight;
  float exact = exact_means(support).x;
  return max(state.bending / weight + support.variate * (exact - explained), 0.0);
}
