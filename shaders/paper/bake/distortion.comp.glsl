#version 450 core
// E, F, G of a texel's triangle → stretch and angle (paper eq. 1): sigma_u, sigma_v, theta_e, area element. theta_e is the angle
// from the u axis to the direction of the larger stretch: a right-singular vector of the Jacobian, in (u, v). Only for reading the
// buffer: samples take native/src/bake/distortion.cpp.
#include "paper/bake/metric.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = UNIT_IDS) uniform isampler2D ids;
layout(binding = IMAGE_DISTORTION, rgba32f) writeonly restrict uniform image2D distortion;
layout(location = LOCATION_FIRST) uniform int first_row;

void main() {
  ivec2 texel = ivec2(gl_GlobalInvocationID.x, first_row + int(gl_GlobalInvocationID.y));
  if (any(greaterThanEqual(texel, imageSize(distortion)))) return;
  ivec2 id = texelFetch(ids, texel, 0).xy;
  vec4 result = vec4(0.0);
  if (id.x >= 0) {
    vec4 form = form_of(id.y < 0 ? -1 - id.y : id.y);
    float mean = 0.5 * (form.x + form.z);
    float difference = 0.5 * (form.x - form.z);
    float radius = sqrt(difference * difference + form.y * form.y);
    float angle = radius > 0.0 ? 0.5 * atan(form.y, difference) : 0.0;
    result = vec4(sqrt(mean + radius), sqrt(max(mean - radius, 0.0)), angle, form.w);
  }
  imageStore(distortion, texel, result);
}
