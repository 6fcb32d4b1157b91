// |grad f|, of the least-squares quadratic.
float gradient_magnitude(Terms terms, Center center, Neighborhood neighborhood) {
  Jet jet = jet_finish(terms.jet);
  return jet.exists ? length(vec2(jet.plane.y, jet.plane.z)) / neighborhood.radius : NOT_A_NUMBER;
}
