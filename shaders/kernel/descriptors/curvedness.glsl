// sqrt((k1^2 + k2^2)/2).
DESCRIPTOR_WITHOUT_STATE
float descriptor_finish(State state, Center center, Support support) {
  return sqrt(0.5 * (support.k1 * support.k1 + support.k2 * support.k2));
}
