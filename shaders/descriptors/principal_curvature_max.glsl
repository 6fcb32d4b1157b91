// k1, the larger eigenvalue of the shape operator.
DESCRIPTOR_WITHOUT_STATE
float descriptor_finish(State state, Center center, Support support) {
  return support.k1;
}
