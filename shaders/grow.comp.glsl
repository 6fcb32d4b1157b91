#version 450 core
// One invocation, one center → its windows, each widened while the ball shows on a side.
#include "window.glsl"
layout(local_size_x = GROUP_SIZE) in;

// Windows are wider than what was found by this, in units of the ellipse: the distance that scouts leave between them.
const float GAP = 0.16;
const int SIDE_POINTS = 8; // on each side of a window that look whether it should grow
const int MAX_GROWTH = 12;

// Which sides (low x, low y, high x, high y) show the ball.
vec4 sides_in_ball(WindowData window, vec3 ball) {
  vec4 seen = vec4(0.0);
  mat2 frame = frame_of(window);
  for (int i = 0; i < 4 * SIDE_POINTS; ++i) {
    int side = i & 3;
    vec2 local = mix(window.box.xy, window.box.zw, (float(i / 4) + 0.5) / float(SIDE_POINTS));
    if (side == 0) local.x = window.box.x;
    if (side == 1) local.y = window.box.y;
    if (side == 2) local.x = window.box.z;
    if (side == 3) local.y = window.box.w;
    if (in_ball(window.center_chart.xy + frame * local, int(window.center_chart.z), ball))
      seen += vec4(side == 0, side == 1, side == 2, side == 3);
  }
  return min(seen, 1.0);
}

void grow(int k, vec3 ball) {
  WindowData window = windows[k];
  window.box += vec4(-GAP, -GAP, GAP, GAP);
  for (int i = 0; i < MAX_GROWTH; ++i) {
    vec4 seen = sides_in_ball(window, ball);
    if (seen == vec4(0.0)) break;
    vec2 by = max(vec2(0.1), 0.15 * (window.box.zw - window.box.xy));
    window.box += seen * vec4(-by, by);
  }
  windows[k].box = window.box;
}

void main() {
  int index = first + int(gl_GlobalInvocationID.x);
  if (index >= last) return;
  for (int k = 0; k < int(searches[index].x); ++k) grow(index * MAX_WINDOWS + k, centers[index].position_chart.xyz);
}
