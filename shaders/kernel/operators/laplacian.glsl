// The Laplace-Beltrami operator of f: the trace of the least-squares quadratic's Hessian.
float laplacian(Terms terms, Center center, Neighborhood neighborhood) {
  Jet jet = jet_finish(terms.jet);
  return jet.exists ? 2.0f * (jet.quadratic.x + jet.quadratic.z) / (neighborhood.radius * neighborhood.radius) : NOT_A_NUMBER;
}
