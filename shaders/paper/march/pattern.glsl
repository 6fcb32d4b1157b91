// The disk pattern of a center (paper 4.1), turned by the center's angle and, if DIRECTIONAL, stretched by direction.
layout(std430, binding = BINDING_PATTERN) readonly restrict buffer Pattern { vec2 pattern[]; };
#if DIRECTIONAL
layout(std430, binding = BINDING_STRETCHES) readonly restrict buffer Stretches { float stretches[]; };
#endif

// The factor by which the pattern is stretched along a direction of the unit disk, interpolated between STRETCH_DIRECTIONS.
float stretch_along(vec2 direction, int index) {
#if DIRECTIONAL
  float turn = fract(atan(direction.y, direction.x) / (2.0 * PI) + 1.0) * float(STRETCH_DIRECTIONS);
  int low = min(int(turn), STRETCH_DIRECTIONS - 1);
  float before = stretches[index * STRETCH_DIRECTIONS + low];
  float after = stretches[index * STRETCH_DIRECTIONS + (low + 1) % STRETCH_DIRECTIONS];
  return mix(before, after, turn - float(low));
#else
  return 1.0;
#endif
}

struct PatternSample {
  vec2 disk;     // in the unit disk
  float stretch; // of the disk at this sample; areas grow by its square
  bool inside;   // within the ball if the metric were that of the center
};

PatternSample pattern_sample(int i, mat2 rotation, int index) {
  vec2 disk = rotation * pattern[i];
  float stretch = stretch_along(disk, index);
  return PatternSample(disk * stretch, stretch, length(disk) * stretch * params.enlargement <= 1.0);
}
