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

bool on_chart(ivec2 texel, int chart) {
  if (any(lessThan(texel, ivec2(0))) || any(greaterThanEqual(texel, ivec2(buffer_size)))) return false;
  ivec2 id = texelFetch(ids, texel, 0).xy;
  return id.x == chart && id.y >= 0;
}

// A rectangle of a window's frame: corner, span, and the largest area in space that it may hold of the ball.
struct Stratum {
  vec2 low;
  vec2 span;
  float area;
};

// Looks at four places: where the parameterization is stretched, few samples of a window would stand for much of the surface.
Stratum probe(WindowData window, mat2 frame, vec2 low, vec2 span, vec3 ball) {
  float largest = 0.0;
  for (int i = 0; i < 4; ++i) {
    ivec2 texel = ivec2(floor(window.center_chart.xy + frame * (low + span * (0.25 + 0.5 * vec2(i & 1, i >> 1)))));
    if (!on_chart(texel, int(window.center_chart.z))) continue;
    vec4 point = texelFetch(positions, texel, 0);
    if (length(point.xyz - ball) < 1.1 * radius) largest = max(largest, point.w);
  }
  float size = float(buffer_size);
  return Stratum(low, span, largest * abs(determinant(frame)) * span.x * span.y / (size * size));
}

// Every window in strata, each as densely sampled as the disk of a center without seams; what lies on the window's chart counts.
void sample_support(inout Sums sums, CenterData data, int index) {
  vec4 search = searches[index];
  sums.moments.lost = search.y;
  sums.moments.cut = search.z;
  float size = float(buffer_size);
  vec2 home = data.place.xy * size;
  float density = float(samples) / (PI * enlargement * enlargement * radius * radius);
  int iterations = 0;
  for (int k = 0; k < int(search.x); ++k) {
    WindowData window = windows[index * MAX_WINDOWS + k];
    mat2 frame = frame_of(window);
    vec2 span = window.box.zw - window.box.xy;
    int side = span.x * span.y > 0.3 ? 4 : 2;
    for (int j = 0; j < side * side; ++j) {
      vec2 part = span / float(side);
      Stratum stratum = probe(window, frame, window.box.xy + part * vec2(j % side, j / side), part, sums.center.position);
      int own = int(clamp(ceil(stratum.area * density), 4.0, float(samples)));
      iterations += 4 + own * (k + 1);
      if (iterations > MAX_ITERATIONS) {
        sums.moments.lost += stratum.area;
        continue;
      }
      float cell = abs(determinant(frame)) * part.x * part.y / (float(own) * size * size);
      for (int i = 0; i < own; ++i) {
        vec2 place = window.center_chart.xy + frame * (stratum.low + part * fract(pattern[samples + i] + pattern[samples + j]));
        ivec2 texel = ivec2(floor(place));
        if (!on_chart(texel, int(window.center_chart.z)) || seen_before(place, index, k, window.center_chart.z)) continue;
        vec2 apart = place - home;
        add_texel(sums, texel, cell, k == 0 && dot(apart, apart) < 1.0);
      }
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
