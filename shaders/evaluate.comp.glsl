#version 450 core
// One invocation, one place of a vertex in the UV map → every descriptor asked for, from one sampling of its neighborhood (paper 4.1).
#include "variant.glsl"
#include "interface.glsl"
#include "buffers.glsl"
#include "descriptors.glsl"
layout(local_size_x = GROUP_SIZE) in;
layout(std430, binding = BINDING_CENTERS) readonly restrict buffer Centers { CenterData centers[]; };
layout(std430, binding = BINDING_PATTERN) readonly restrict buffer Pattern { vec2 pattern[]; };
#if SEAMS
layout(std430, binding = BINDING_WINDOWS) readonly restrict buffer Windows { WindowData windows[]; };
layout(std430, binding = BINDING_SEARCH) readonly restrict buffer Searches { vec4 searches[]; };
#endif
layout(std430, binding = BINDING_RESULTS) writeonly restrict buffer Results { float results[]; };
layout(location = 2) uniform int first;
layout(location = 3) uniform int last;
layout(location = 4) uniform int total;
layout(location = 5) uniform int samples;
layout(location = 6) uniform float radius;
layout(location = 7) uniform float enlargement;

struct Moments {
  float area;
  vec3 xx;      // sum of w x x^T, x in units of r
  vec3 xy;      // sum of w: x1 y1, x1 y2 + x2 y1, x2 y2
  float lost;
  float cut;    // samples that met a boundary within the ball
};

// An orthonormal pair of tangents (Duff et al. 2017).
void tangents(vec3 n, out vec3 t1, out vec3 t2) {
  float s = n.z >= 0.0 ? 1.0 : -1.0;
  float a = -1.0 / (s + n.z);
  float b = n.x * n.y * a;
  t1 = vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x);
  t2 = vec3(b, s + n.y * n.y * a, -n.y);
}

// Least squares: S minimizes the sum of w |S x - y|^2 over symmetric 2x2 matrices.
Support finish_support(Moments m) {
  Support support = Support(radius, m.area, vec3(0.0), NOT_A_NUMBER, NOT_A_NUMBER, 0.0);
  float determinant = m.xx.x * m.xx.z - m.xx.y * m.xx.y;
  float trace = m.xx.x + m.xx.z;
  if (!(determinant > 1e-4 * trace * trace)) return support;
  vec2 ratio = m.xx.y / vec2(m.xx.x, m.xx.z);
  float s12 = (m.xy.y - ratio.x * m.xy.x - ratio.y * m.xy.z) / (trace - m.xx.y * (ratio.x + ratio.y));
  support.shape = vec3((m.xy.x - s12 * m.xx.y) / m.xx.x, s12, (m.xy.z - s12 * m.xx.y) / m.xx.z) / radius;
  float mean = 0.5 * (support.shape.x + support.shape.z);
  float half_gap = length(vec2(0.5 * (support.shape.x - support.shape.z), support.shape.y));
  support.k1 = mean + half_gap;
  support.k2 = mean - half_gap;
  // The control variate's exact mean is that of a full flat disk: second moments pi r^4/4 each.
  float disk = 0.25 * PI * radius * radius;
  vec3 off = abs(m.xx / disk - vec3(1.0, 0.0, 1.0));
  float deviation = max(max(off.x, off.z), off.y);
  support.variate = m.cut > 0.0 ? 0.0 : 1.0 - smoothstep(0.1, 0.3, deviation);
  return support;
}

struct Sums {
  Center center;
  vec3 t1;
  vec3 t2;
  Moments moments;
  States states;
};

// One texel: weight is the area of its cell in (u, v).
void add_texel(inout Sums sums, ivec2 texel, float cell, bool near) {
  vec4 point = texelFetch(positions, texel, 0);
  Neighbor neighbor;
  neighbor.offset = point.xyz - sums.center.position;
  neighbor.rho = length(neighbor.offset);
  neighbor.weight = point.w * cell;
  // A cell that the ball's rim cuts counts by the part of it that lies inside.
  neighbor.weight *= clamp((radius - neighbor.rho) * inversesqrt(max(neighbor.weight, 1e-20)) + 0.5, 0.0, 1.0);
  if (!(neighbor.weight > 0.0)) return;
  neighbor.normal = texelFetch(normals, texel, 0).xyz;
  neighbor.near = near;
  vec2 x = vec2(dot(neighbor.offset, sums.t1), dot(neighbor.offset, sums.t2)) / radius;
  vec2 y = vec2(dot(neighbor.normal, sums.t1), dot(neighbor.normal, sums.t2));
  neighbor.direction = x * inversesqrt(max(dot(x, x), 1e-12));
  sums.moments.area += neighbor.weight;
  sums.moments.xx += neighbor.weight * outer(x);
  sums.moments.xy += neighbor.weight * vec3(x.x * y.x, x.x * y.y + x.y * y.x, x.y * y.y);
  states_add(sums.states, sums.center, neighbor);
}

#if SEAMS
// A place that an earlier window on the same chart has sampled already.
bool seen_before(vec2 place, int index, int window, float chart) {
  for (int k = 0; k < window; ++k) {
    WindowData other = windows[index * MAX_WINDOWS + k];
    if (other.center_chart.z != chart) continue;
    vec2 local = inverse(frame_of(other)) * (place - other.center_chart.xy);
    if (all(greaterThanEqual(local, other.box.xy)) && all(lessThan(local, other.box.zw))) return true;
  }
  return false;
}

// Samples of a window: its share of the disk's, so that they lie equally dense everywhere.
float window_samples(WindowData window, float most) {
  vec2 span = window.box.zw - window.box.xy;
  return ceil(clamp(most * span.x * span.y / 4.0, min(most, 32.0), most));
}

// Every window evenly, by the pattern of the unit square; what lies on the window's chart counts.
void sample_support(inout Sums sums, CenterData data, int index) {
  vec4 search = searches[index];
  sums.moments.lost = search.y;
  sums.moments.cut = search.z;
  vec2 home = data.place.xy * float(buffer_size);
  int count = int(search.x);
  float iterations = 0.0;
  for (int k = 0; k < count; ++k) iterations += window_samples(windows[index * MAX_WINDOWS + k], float(samples)) * float(k + 1);
  float most = float(samples) * min(1.0, float(MAX_ITERATIONS) / iterations);
  for (int k = 0; k < count; ++k) {
    WindowData window = windows[index * MAX_WINDOWS + k];
    vec2 span = window.box.zw - window.box.xy;
    mat2 frame = frame_of(window);
    int own = int(window_samples(window, most));
    float cell = abs(determinant(frame)) * span.x * span.y / (float(own) * float(buffer_size) * float(buffer_size));
    for (int i = 0; i < own; ++i) {
      vec2 place = window.center_chart.xy + frame * (window.box.xy + span * pattern[samples + i]);
      ivec2 texel = ivec2(floor(place));
      if (any(lessThan(texel, ivec2(0))) || any(greaterThanEqual(texel, ivec2(buffer_size)))) continue;
      ivec2 id = texelFetch(ids, texel, 0).xy;
      if (id.x != int(window.center_chart.z) || id.y < 0 || seen_before(place, index, k, window.center_chart.z)) continue;
      vec2 apart = place - home;
      add_texel(sums, texel, cell, k == 0 && dot(apart, apart) < 1.0);
    }
  }
}
#else
// The whole support lies on one chart: the golden-angle pattern over the ellipse, no questions asked.
void sample_support(inout Sums sums, CenterData data, int index) {
  float size = float(buffer_size);
  mat2 rotation = mat2(cos(data.normal_phase.w), sin(data.normal_phase.w), -sin(data.normal_phase.w), cos(data.normal_phase.w));
  mat2 ellipse = mat2(data.ellipse.xy, data.ellipse.zw) * rotation * size;
  float cell = PI * abs(determinant(ellipse)) / (float(samples) * size * size);
  for (int i = 0; i < samples; ++i) {
    vec2 offset = ellipse * pattern[i];
    add_texel(sums, ivec2(data.place.xy * size + offset), cell, dot(offset, offset) < 1.0);
  }
}
#endif

void main() {
  int index = first + int(gl_GlobalInvocationID.x);
  if (index >= last) return;
  CenterData data = centers[index];
  Sums sums;
  sums.center = Center(data.position_chart.xyz, data.normal_phase.xyz, radius);
  tangents(sums.center.normal, sums.t1, sums.t2);
  sums.moments = Moments(0.0, vec3(0.0), vec3(0.0), 0.0, 0.0);
  states_init(sums.states);
  sample_support(sums, data, index);

  Moments m = sums.moments;
  Center center = sums.center;
  States states = sums.states;
  Support support = finish_support(m);
  results[ROW_COVERAGE * total + index] = m.area > 0.0 ? m.area / (m.area + m.lost) : 0.0;
  results[ROW_FLAGS * total + index] = m.cut > 0.0 ? 1.0 : 0.0;
  STATES_FINISH
}
