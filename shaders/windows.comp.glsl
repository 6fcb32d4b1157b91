#version 450 core
// One invocation, one center near a border → the windows of the UV map that hold its support.
//
// Scouts of the pattern are carried over the seams one by one. Where they land within the ball they stake out a window: a box on that
// chart, in the frame of the ellipse as the maps brought it there. Evaluation then samples each window evenly and keeps what lies on its
// chart and in the ball. So the maps of the seam edges, which fit each other only to first order, decide where to look and not what a
// sample weighs: neighboring edges leave no gaps and no overlaps. (The paper's whole pattern around the transformed center, 4.1, with
// the window measured instead of guessed.)
#include "neighborhood.glsl"
layout(local_size_x = GROUP_SIZE) in;
layout(std430, binding = BINDING_CENTERS) readonly restrict buffer Centers { CenterData centers[]; };
layout(std430, binding = BINDING_PATTERN) readonly restrict buffer Pattern { vec2 pattern[]; };
layout(std430, binding = BINDING_WINDOWS) writeonly restrict buffer Windows { WindowData windows[]; };
layout(std430, binding = BINDING_LOSSES) writeonly restrict buffer Losses { vec4 losses[]; };
layout(location = 2) uniform int first;
layout(location = 3) uniform int last;
layout(location = 6) uniform float radius;
layout(location = 7) uniform float enlargement;

// Scouts leave this share of the ball's radius between them; windows are widened by it.
const float GAP = 1.2 * sqrt(3.14159265 / float(SCOUTS)) * 0.5;

struct Window {
  int chart;
  vec2 center; // of the frame, texels
  mat2 frame;  // unit disk to texels
  vec2 low;    // box in the frame
  vec2 high;
};

void main() {
  int index = first + int(gl_GlobalInvocationID.x);
  if (index >= last) return;
  CenterData data = centers[index];
  float size = float(buffer_size);
  mat2 ellipse = mat2(data.ellipse.xy, data.ellipse.zw) * size;
  mat2 rotation = mat2(cos(data.normal_phase.w), sin(data.normal_phase.w), -sin(data.normal_phase.w), cos(data.normal_phase.w));
  Window found[MAX_WINDOWS];
  found[0] = Window(int(data.position_chart.w), data.place.xy * size, ellipse, vec2(0.0), vec2(0.0));
  int count = 1;
  float lost = 0.0, cut = 0.0;
  for (int i = 0; i < SCOUTS; ++i) {
    Walk walk = Walk(data.place.zw * size, data.place.xy * size + ellipse * (rotation * pattern[i]), int(data.position_chart.w), mat2(1.0),
                     data.place.xy * size, FOUND);
    march(walk);
    ivec2 texel;
    bool carried = find_texel(walk.to, walk.chart, texel);
    float rho = carried ? length(texelFetch(positions, texel, 0).xyz - data.position_chart.xyz) : 1e9;
    if (walk.outcome == BOUNDARY) {
      cut += rho < radius ? 1.0 : 0.0;
      continue;
    }
    if (walk.outcome == LOST || !carried) {
      lost += length(pattern[i]) * enlargement <= 1.0 ? 1.0 : 0.0;
      continue;
    }
    if (rho > radius) continue;
    int window = -1;
    for (int k = 0; k < count; ++k) {
      vec2 apart = inverse(found[k].frame) * (walk.center - found[k].center);
      if (found[k].chart == walk.chart && (dot(apart, apart) < 1.0 || count == MAX_WINDOWS)) {
        window = k;
        break;
      }
    }
    if (window < 0) {
      if (count == MAX_WINDOWS) {
        lost += 1.0;
        continue;
      }
      window = count++;
      found[window] = Window(walk.chart, walk.center, walk.turn * ellipse, vec2(1e9), vec2(-1e9));
    }
    vec2 place = inverse(found[window].frame) * (walk.to - found[window].center);
    found[window].low = min(found[window].low, place);
    found[window].high = max(found[window].high, place);
  }
  for (int k = 0; k < count; ++k) {
    vec2 low = found[k].low - GAP, span = found[k].high + GAP - low;
    mat2 map = mat2(found[k].frame[0] * span.x, found[k].frame[1] * span.y);
    windows[index * MAX_WINDOWS + k] = WindowData(vec4(found[k].center + found[k].frame * low, float(found[k].chart), 0.0), vec4(map[0], map[1]));
  }
  float reach = enlargement * radius;
  losses[index] = vec4(float(count), lost * 3.14159265 * reach * reach / float(SCOUTS), cut, 0.0);
}
