// The least-squares quadratic of the map over the neighborhood, f ~ c + g.x + x^T Q x/2 with x the tangent coordinates in units of r: at p,
// where the Christoffel symbols of these coordinates vanish, g is the gradient and the trace of Q the Laplace-Beltrami operator. What a
// quadratic explains leaves no noise, wherever the samples lie.
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
  vec3 plane;     // c, g
  vec3 quadratic; // of xx, xy, yy
};
void jet_init(out JetTerms terms) { terms = JetTerms(vec3(0.0), vec3(0.0), vec4(0.0), vec4(0.0), 0.0, vec3(0.0), vec3(0.0)); }
void jet_add(inout JetTerms terms, Neighbor neighbor) {
  vec2 x = neighbor.place;
  vec3 s = outer(x);
  float w = neighbor.weight;
  terms.first += w * vec3(1.0, x);
  terms.second += w * s;
  terms.third += w * vec4(s.x * x, s.z * x);
  terms.fourth += w * vec4(s.x * s, s.y * s.z);
  terms.yyyy += w * s.z * s.z;
  terms.f_first += w * neighbor.value * vec3(1.0, x);
  terms.f_second += w * neighbor.value * s;
}
// NaN where the samples do not determine a quadratic.
Jet jet_finish(JetTerms terms) {
  vec3 first = terms.first, second = terms.second;
  vec4 third = terms.third, fourth = terms.fourth;
  float area = first.x;
  Jet jet = Jet(vec3(NOT_A_NUMBER), vec3(NOT_A_NUMBER));
  if (!(area > 0.0)) return jet;
  mat3 a = mat3(first, vec3(first.y, second.xy), vec3(first.z, second.yz)) / area;
  mat3 b = mat3(vec3(second.x, third.xy), vec3(second.y, third.yz), vec3(second.z, third.zw)) / area;
  mat3 d = mat3(fourth.xyz, fourth.yzw, vec3(fourth.zw, terms.yyyy)) / area;
  if (!(determinant(a) > JET_LEAST_PLANE)) return jet;
  mat3 inverse_a = inverse(a);
  mat3 reduce = transpose(b) * inverse_a;
  mat3 rest = d - reduce * b;
  if (!(determinant(rest) > JET_LEAST_QUADRATIC)) return jet;
  jet.quadratic = inverse(rest) * (terms.f_second - reduce * terms.f_first) / area;
  jet.plane = inverse_a * (terms.f_first / area - b * jet.quadratic);
  return jet;
}
