// The standard error of H caused by noise of the positions, for H by the shape operator.
float standard_error(Terms terms, Center center, Neighborhood neighborhood) {
  return neighborhood.standard_error;
}
