#version 450 core
// One invocation, one center, one party of scouts → windows of the UV map that hold its support.
//
// Scouts of the golden-angle pattern are carried over the seams one by one. Where they land within the ball they stake out a window: a
// box on that chart, in the frame of the local ellipse. Each window sends scouts of its own, and then grows while the ball shows on its
// sides (grow.comp.glsl). Evaluation samples each window evenly and keeps what lies on its chart and in the ball. So the maps of the seam
// edges, which fit each other only to first order, decide where to look and not what a sample weighs: neighboring edges leave no gaps and
// no overlaps. (The paper's whole pattern around the transformed center, 4.1, with the window measured instead of guessed.)
#include "window.glsl"
#include "neighborhood.glsl"
layout(local_size_x = GROUP_SIZE) in;
layout(std430, binding = BINDING_PATTERN) readonly restrict buffer Pattern { vec2 pattern[]; };
layout(std430, binding = BINDING_ACTIVE) restrict buffer Active { uint active_centers; };
layout(binding = UNIT_TRIANGLES) uniform sampler2D triangles;
layout(location = 8) uniform int round; // the window whose scouts go out; 0: the center's own
layout(location = 9) uniform int begin; // first scout of the party
layout(location = 10) uniform int interior; // centers before this one have no border within their ellipse and need no scouts

float lost_area() { return 3.14159265 * enlargement * enlargement * radius * radius / float(SCOUTS); }

// The square root of the inverse metric of a texel's triangle: the ellipse there, in texels.
mat2 local_ellipse(ivec2 texel) {
  int triangle = texelFetch(ids, texel, 0).y;
  vec4 form = texelFetch(triangles, list_place(triangle < 0 ? -1 - triangle : triangle), 0);
  vec3 inverse_form = vec3(form.z, -form.y, form.x) / max(form.w * form.w, 1e-30);
  float root = 1.0 / max(form.w, 1e-15);
  float scale = enlargement * radius * float(buffer_size) * inversesqrt(max(inverse_form.x + inverse_form.z + 2.0 * root, 1e-30));
  return scale * mat2(inverse_form.x + root, inverse_form.y, inverse_form.y, inverse_form.z + root);
}

// Widens the window that this place belongs to, or opens one. A place belongs to a window if it is near its box.
void stake(inout vec4 search, int base, vec2 place, int chart, ivec2 texel) {
  int count = int(search.x);
  for (int k = base; k < base + count; ++k) {
    WindowData window = windows[k];
    if (int(window.center_chart.z) != chart) continue;
    vec2 local = inverse(frame_of(window)) * (place - window.center_chart.xy);
    bool beside = all(greaterThan(local, window.box.xy - 0.5)) && all(lessThan(local, window.box.zw + 0.5));
    if (!beside && count < MAX_WINDOWS) continue;
    windows[k].box = vec4(min(window.box.xy, local), max(window.box.zw, local));
    return;
  }
  if (count == MAX_WINDOWS) {
    search.y += lost_area();
    return;
  }
  mat2 frame = local_ellipse(texel);
  windows[base + count] = WindowData(vec4(place, float(chart), 0.0), vec4(frame[0], frame[1]), vec4(0.0));
  search.x += 1.0;
}

// Where a window's scouts start: from its middle where that is a texel's center on the chart and in the ball, else from where the window
// was found, which is on the chart too.
vec2 find_start(WindowData window, vec3 ball, out ivec2 texel) {
  int chart = int(window.center_chart.z);
  texel = ivec2(floor(window.center_chart.xy + frame_of(window) * (0.5 * (window.box.xy + window.box.zw))));
  vec2 middle = vec2(texel) + 0.5;
  if (in_ball(middle, chart, ball) && texelFetch(ids, texel, 0).y >= 0) return middle;
  find_texel(window.center_chart.xy, chart, texel);
  return window.center_chart.xy;
}

// Scouts go on beyond their ellipse until a quarter of all has found nothing more.
int scouts_on_ellipse() { return round == 0 ? SCOUTS : WINDOW_SCOUTS; }
bool goes_on(int scout, vec4 search) {
  return scout < 8 * scouts_on_ellipse() && (scout < scouts_on_ellipse() || float(scout) < search.w + 0.25 * float(scout));
}

void main() {
  int index = first + int(gl_GlobalInvocationID.x);
  if (index >= last) return;
  CenterData data = centers[index];
  float size = float(buffer_size);
  int base = index * MAX_WINDOWS;
  int chart = int(data.position_chart.w);
  mat2 ellipse = mat2(data.ellipse.xy, data.ellipse.zw) * size;
  if (round == 0 && begin == 0) {
    float reach = index < interior ? 1.0 / enlargement : 0.0;
    windows[base] = WindowData(vec4(data.place.xy * size, data.position_chart.w, 0.0), vec4(ellipse[0], ellipse[1]),
                               vec4(-reach, -reach, reach, reach));
    searches[index] = vec4(1.0, 0.0, 0.0, 0.0);
  }
  if (index < interior) return;
  vec4 search = searches[index];
  if (begin == 0) search.w = 0.0;
  vec2 start = data.place.zw * size, middle = data.place.xy * size;
  bool sending = round < int(search.x) && goes_on(begin, search);
  if (sending && round > 0) {
    ivec2 texel;
    WindowData window = windows[base + round];
    chart = int(window.center_chart.z);
    start = middle = find_start(window, data.position_chart.xyz, texel);
    ellipse = local_ellipse(texel);
  }
  if (!sending) {
    if (begin == 0) searches[index] = search;
    return;
  }
  mat2 rotation = mat2(cos(data.normal_phase.w), sin(data.normal_phase.w), -sin(data.normal_phase.w), cos(data.normal_phase.w));
  ellipse = ellipse * rotation * sqrt(float(SCOUTS) / float(scouts_on_ellipse()));
  for (int i = begin; i < begin + SCOUT_PARTY && goes_on(i, search); ++i) {
    Walk walk = Walk(start, middle + ellipse * pattern[i], chart, FOUND);
    march(walk, vec4(data.position_chart.xyz, radius));
    ivec2 texel;
    if (walk.outcome == OUTSIDE) continue;
    bool carried = find_texel(walk.to, walk.chart, texel);
    float rho = carried ? length(texelFetch(positions, texel, 0).xyz - data.position_chart.xyz) : 1e9;
    if (walk.outcome == BOUNDARY) {
      search.z += rho < radius ? 1.0 : 0.0;
    } else if (walk.outcome == LOST || !carried) {
      // Only the center's own scouts measure what is lost: those of the windows look at the same places again.
      if (round == 0 && length(pattern[i]) * enlargement <= 1.0) search.y += lost_area();
    } else if (rho < radius) {
      search.w = float(i);
      stake(search, base, walk.to, walk.chart, texel);
    }
  }
  searches[index] = search;
  if (goes_on(begin + SCOUT_PARTY, search) || round + 1 < int(search.x)) atomicAdd(active_centers, 1u);
}
