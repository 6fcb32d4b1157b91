// EA (paper eq. 13, 14): the area of the surface within the ball.
DESCRIPTOR_WITHOUT_STATE
float descriptor_finish(State state, Center center, Support support) {
  return support.area;
}
