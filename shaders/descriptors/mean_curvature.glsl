// H = (k1 + k2)/2 of the shape operator.
DESCRIPTOR_WITHOUT_STATE
float descriptor_finish(State state, Center center, Support support) {
  return 0.5 * (support.k1 + support.k2);
}
