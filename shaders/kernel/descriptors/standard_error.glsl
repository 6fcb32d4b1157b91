// The standard error of H that noise of the positions makes, by the shape operator.
float standard_error(Terms terms, Center center, Neighborhood neighborhood) {
  return neighborhood.standard_error;
}
