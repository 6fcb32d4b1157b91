// Terms of the least-squares quadratic of a map over the neighborhood, f ~ c + g.x + x^T Q x/2, with x the tangent coordinates in
// units of r. At p the Christoffel symbols of these coordinates vanish, so g is the gradient and the trace of Q the
// Laplace-Beltrami operator. The part of f that a quadratic explains causes no noise, wherever the samples lie.
struct JetTerms {
  vec3 first;   // sum of w (1, x, y)
  vec3 second;  // of w (xx, xy, yy)
  vec4 third;   // of w (xxx, xxy, xyy, yyy)
  vec4 fourth;  // of w (xxxx, xxxy, xxyy, xyyy)
  float yyyy;
  vec3 f_first; // of w f (1, x, y)
  vec3 f_second;
};
struct Jet {
  bool exists;    // the samples determine a quadratic
  vec3 plane;     // c, g
  vec3 quadratic; // of xx, xy, yy
};
void jet_init(OUT(JetTerms) terms) {
  terms.first = vec3(0.0f);
  terms.second = vec3(0.0f);
  terms.third = vec4(0.0f);
  terms.fourth = vec4(0.0f);
  terms.yyyy = 0.0f;
  terms.f_first = vec3(0.0f);
  terms.f_second = vec3(0.0f);
}
void jet_add(INOUT(JetTerms) terms, Center center, Neighbor neighbor) {
  vec2 x = neighbor.coordinates;
  vec3 s = outer(x);
  float w = neighbor.weight;
  terms.first += w * vec3(1.0f, x.x, x.y);
  terms.second += w * s;
  terms.third += w * vec4(s.x * x.x, s.x * x.y, s.z * x.x, s.z * x.y);
  terms.fourth += w * vec4(s.x * s.x, s.x * s.y, s.x * s.z, s.y * s.z);
  terms.yyyy += w * s.z * s.z;
  terms.f_first += w * neighbor.value * vec3(1.0f, x.x, x.y);
  terms.f_second += w * neighbor.value * s;
}
Jet jet_finish(JetTerms terms) {
  vec3 first = terms.first, second = terms.second;
  vec4 third = terms.third, fourth = terms.fourth;
  float area = first.x;
  Jet jet;
  jet.exists = false;
  jet.plane = vec3(0.0f);
  jet.quadratic = vec3(0.0f);
  if (!(area > 0.0f)) return jet;
  mat3 a = mat3(first, vec3(first.y, second.x, second.y), vec3(first.z, second.y, second.z)) / area;
  mat3 b = mat3(vec3(second.x, third.x, third.y), vec3(second.y, third.y, third.z), vec3(second.z, third.z, third.w)) / area;
  mat3 d = mat3(vec3(fourth.x, fourth.y, fourth.z), vec3(fourth.y, fourth.z, fourth.w), vec3(fourth.z, fourth.w, terms.yyyy)) / area;
  if (!(determinant(a) > float(JET_LEAST_PLANE))) return jet;
  mat3 inverse_a = inverse(a);
  mat3 reduce = transpose(b) * inverse_a;
  mat3 rest = d - reduce * b;
  if (!(determinant(rest) > float(JET_LEAST_QUADRATIC))) return jet;
  jet.exists = true;
  jet.quadratic = inverse(rest) * (terms.f_second - reduce * terms.f_first) / area;
  jet.plane = inverse_a * (terms.f_first / area - b * jet.quadratic);
  return jet;
}
