// The convex part of H r, for masks: 0 on a plane and in what is hollow, 1 where the surface bends by r or more tightly.
DESCRIPTOR_WITHOUT_STATE
float descriptor_finish(State state, Center center, Support support) {
  float bend = support.mean * support.radius;
  return isnan(bend) ? bend : clamp(bend, 0.0, 1.0);
}
