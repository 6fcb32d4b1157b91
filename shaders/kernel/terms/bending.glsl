// Terms of the bending energy (paper eq. 5): how far normals turn, and the directions of neighbors.
struct BendingTerms {
  float energy; // sum of w |n - n_i|^2/rho^2
#if VARIATE
  vec3 moments; // sum of w e e^T
#else
  float weight; // sum of w
#endif
};
void bending_init(OUT(BendingTerms) terms) {
  terms.energy = 0.0f;
#if VARIATE
  terms.moments = vec3(0.0f);
#else
  terms.weight = 0.0f;
#endif
}
void bending_add(INOUT(BendingTerms) terms, Center center, Neighbor neighbor) {
  float weight = mix(neighbor.weight, 0.0f, neighbor.near);
  terms.energy += weight * neighbor.turning;
#if VARIATE
  terms.moments += weight * neighbor.directions;
#else
  terms.weight += weight;
#endif
}
