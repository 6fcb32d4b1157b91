// det A - k tr^2 A (paper eq. 15, 16). A is the mean of (r grad f)(r grad f)^T in a Gaussian window, with each gradient turned
// into the tangent plane of the center.
float harris(Terms terms, Center center, Neighborhood neighborhood) {
  if (!(terms.tensor.weight > 0.0f) || isnan(center.value)) return NOT_A_NUMBER;
  vec3 a = terms.tensor.tensor / terms.tensor.weight;
  float trace = a.x + a.z;
  return a.x * a.z - a.y * a.y - params.harris_k * trace * trace;
}
