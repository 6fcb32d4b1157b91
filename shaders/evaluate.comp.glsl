#version 450 core
// One invocation, one place of a vertex in the UV map → every descriptor asked for, from one sampling of its neighborhood (paper 4.1).
#include "variant.glsl"
#include "interface.glsl"
#include "buffers.glsl"
#include "descriptors.glsl"
layout(local_size_x = GROUP_SIZE) in;
layout(std430, binding = BINDING_CENTERS) readonly restrict buffer Centers { CenterData centers[]; };
layout(std430, binding = BINDING_RESULTS) writeonly restrict buffer Results { float results[]; };
layout(location = 2) uniform int first;
layout(location = 3) uniform int last;
layout(location = 4) uniform int total;
layout(location = 5) uniform int samples;
layout(location = 6) uniform float radius;
layout(location = 7) uniform float enlargement;
layout(location = 8) uniform int block_size;
layout(location = 9) uniform int seed;

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

// One place of the surface. near: nearer to the center than texels can tell.
void add_neighbor(inout Sums sums, vec3 position, vec3 normal, float area, bool near) {
  Neighbor neighbor;
  neighbor.offset = position - sums.center.position;
  neighbor.rho = length(neighbor.offset);
  // A square that the ball's rim cuts counts by the part of it that lies inside.
  neighbor.weight = area * clamp((radius - neighbor.rho) * inversesqrt(max(area, 1e-20)) + 0.5, 0.0, 1.0);
  if (!(neighbor.weight > 0.0)) return;
  neighbor.normal = normal;
  neighbor.near = near || neighbor.rho == 0.0;
  vec2 x = vec2(dot(neighbor.offset, sums.t1), dot(neighbor.offset, sums.t2)) / radius;
  vec2 y = vec2(dot(neighbor.normal, sums.t1), dot(neighbor.normal, sums.t2));
  neighbor.direction = x * inversesqrt(max(dot(x, x), 1e-12));
  sums.moments.area += neighbor.weight;
  sums.moments.xx += neighbor.weight * outer(x);
  sums.moments.xy += neighbor.weight * vec3(x.x * y.x, x.x * y.y + x.y * y.x, x.y * y.y);
  states_add(sums.states, sums.center, neighbor);
}

// One texel: cell is the area in (u, v) that it stands for.
void add_texel(inout Sums sums, ivec2 texel, float cell) {
  vec4 point = texelFetch(positions, texel, 0);
  bool near = length(point.xyz - sums.center.position) * float(buffer_size) < sqrt(point.w);
  add_neighbor(sums, point.xyz, texelFetch(normals, texel, 0).xyz, point.w * cell, near);
}

#if AFFINE
#include "affine.glsl"
#else
#include "connected.glsl"
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
