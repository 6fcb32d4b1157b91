// Terms of the structure tensor of a map f in a Gaussian window, with gradients turned into the tangent plane of the center.
struct TensorTerms {
  float weight; // sum of w G
  vec3 tensor;  // of w G (r grad f)(r grad f)^T
};
void tensor_init(OUT(TensorTerms) terms) {
  terms.weight = 0.0f;
  terms.tensor = vec3(0.0f);
}
void tensor_add(INOUT(TensorTerms) terms, Center center, Neighbor neighbor) {
  bool unknown = isnan(neighbor.slope.x);
  float weight = mix(neighbor.weight * gaussian(neighbor.rho, params.map_sigma), 0.0f, unknown);
  terms.weight += weight;
  terms.tensor += weight * outer(vec2(mix(neighbor.slope.x, 0.0f, unknown), mix(neighbor.slope.y, 0.0f, unknown)));
}
