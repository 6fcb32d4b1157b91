// Terms of the bending energy (paper eq. 5): how far normals turn, and the directions of neighbors.
struct BendingTerms {
  float energy; // sum of w |n - n_i|^2/rho^2
  vec3 moments; // sum of w e e^T
};
void bending_init(OUT(BendingTerms) terms) {
  terms.energy = 0.0f;
  terms.moments = vec3(0.0f);
}
void bending_add(INOUT(BendingTerms) terms, Center center, Neighbor neighbor) {
  float weight = mix(neighbor.weight, 0.0f, neighbor.near);
  terms.energy += weight * neighbor.turning;
  terms.moments += weight * neighbor.directions;
}
