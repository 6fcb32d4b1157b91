// K = k1 k2 of the shape operator.
DESCRIPTOR_WITHOUT_STATE
float descriptor_finish(State state, Center center, Support support) {
  return support.k1 * support.k2;
}
