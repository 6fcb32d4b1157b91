// K, by the shape operator or by paper eq. (11).
DESCRIPTOR_WITHOUT_STATE
float descriptor_finish(State state, Center center, Support support) {
  return support.gauss;
}
