// |grad f|, of the least-squares quadratic.
float gradient_magnitude(Terms terms, Center center, Support support) {
  Jet jet = jet_finish(terms.jet);
  return jet.exists ? length(vec2(jet.plane.y, jet.plane.z)) / support.radius : NOT_A_NUMBER;
}
