// Terms of the geodesic area GA (paper eq. 11 to 14), and the Gaussian curvature that follows from GA. The Euclidean area is
// Moments::area of sums.glsl.

// The rim of the neighborhood's projection to the tangent plane, |x|^2 = r^2 (1 - RIM_BEND (kappa r)^2).
#if GEODESIC_BALL
#define RIM_BEND (1.0f / 3.0f)
#else
#define RIM_BEND (1.0f / 4.0f)
#endif

struct AreaTerms {
  float inside;     // area within r along the surface
#if VARIATE
  float projected;  // area of the neighborhood's projection to the tangent plane
  float bend;       // sum of w (q^2 - |x|^2), q the bounding distance: how far the surface leaves the tangent plane
  float moment;     // sum of w q^4
  vec4 moments;     // sum of w q^4: e1^4, e1^3 e2, e1^2 e2^2, e1 e2^3 (e2^4 is the remainder)
#endif
};
void area_init(OUT(AreaTerms) terms) {
  terms.inside = 0.0f;
#if VARIATE
  terms.projected = 0.0f;
  terms.bend = 0.0f;
  terms.moment = 0.0f;
  terms.moments = vec4(0.0f);
#endif
}
void area_add(INOUT(AreaTerms) terms, Center center, Neighbor neighbor) {
  terms.inside += neighbor.inside;
#if VARIATE
#if FACES
  terms.projected += neighbor.weight * dot(center.normal, neighbor.face);
#else
  terms.projected += neighbor.weight * dot(center.normal, neighbor.normal);
#endif
  float height = dot(center.normal, neighbor.offset);
  float flat_square = neighbor.rho * neighbor.rho - height * height;
  float square = neighbor.distance * neighbor.distance;
  float outer = square / (params.radius * params.radius);
  float share = neighbor.weight * outer * outer * outer * outer; // emphasizes the rim
  float weight = share * square * square;
  vec2 e = neighbor.direction;
  terms.bend += share * (square - flat_square);
  terms.moment += weight;
  terms.moments += weight * vec4(e.x * e.x * e.x * e.x, e.x * e.x * e.x * e.y, e.x * e.x * e.y * e.y, e.x * e.y * e.y * e.y);
#endif
}
#if VARIATE
// Sum of w q^4 kappa_S(e)^2.
float area_explained(AreaTerms terms, vec3 s) {
  float last = terms.moment - terms.moments.x - 2.0f * terms.moments.z; // (e1^2 + e2^2)^2 = 1
  return dot(terms.moments, vec4(s.x * s.x, 4.0f * s.x * s.y, 2.0f * s.x * s.z + 4.0f * s.y * s.y, 4.0f * s.y * s.z)) + s.z * s.z * last;
}
#endif
// area: terms.inside, or any sum over the neighborhood that grows with its area. Only its difference to the projected area comes
// from samples, whose noise both share. The projection itself is a disk with the rim |x|^2 = r^2 (1 - c r^2); c is measured over
// all samples, with RIM_BEND kappa^2 of the shape operator as control variate.
float area_finish(AreaTerms terms, float area, Neighborhood neighborhood) {
#if VARIATE
  if (!(neighborhood.variate > 0.0f) || !(terms.moment > 0.0f)) return neighborhood.scale * area;
  vec2 k = neighborhood.eigenvalues;
  float mean = 0.125f * (3.0f * k.x * k.x + 2.0f * k.x * k.y + 3.0f * k.y * k.y); // of kappa^2
  float c = RIM_BEND * mean + (terms.bend - RIM_BEND * area_explained(terms, neighborhood.shape)) / terms.moment;
  float square = neighborhood.radius * neighborhood.radius;
  float exact = PI * square * (1.0f - c * square);
  // Sampled areas are off by about one per cent, rarely by three. A larger difference means that the projection is not such a
  // disk, or that the normals of a displaced surface do not match its shape.
  float correction = neighborhood.variate * (exact - neighborhood.scale * terms.projected);
  return neighborhood.scale * area + correction * (1.0f - smoothstep(0.04f, 0.07f, abs(correction) / (PI * square)));
#else
  return neighborhood.scale * area;
#endif
}
float area_gaussian_curvature(float area, float radius) {
  float square = radius * radius;
  return 12.0f * (PI * square - area) / (PI * square * square);
}
