// grad f of the least-squares quadratic, as a vector in object space; operators on gradients read it as a map.
vec3 map_gradient(Terms terms, Center center, Neighborhood neighborhood) {
  Jet jet = jet_finish(terms.jet);
  if (!jet.exists) return vec3(NOT_A_NUMBER);
  return (center.t1 * jet.plane.y + center.t2 * jet.plane.z) / neighborhood.radius;
}
