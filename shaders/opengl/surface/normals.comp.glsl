#version 450 core
// One invocation per fan → its unit normal, as in mesh/normals.cpp: Max's, or turned by the gradient of a jet through the
// vertices around.
#include "variant.glsl"
#include "opengl/elements.glsl"
#include "opengl/surface/mesh.glsl"
#include "opengl/surface/jet.glsl"
layout(std430, binding = BINDING_NORMALS) writeonly restrict buffer Normals { float normals[]; };
layout(binding = UNIT_FACES) uniform samplerBuffer faces;
layout(binding = UNIT_RINGS) uniform isamplerBuffer rings;
layout(binding = UNIT_FAN_VERTICES) uniform isamplerBuffer fan_vertices;
layout(binding = UNIT_RING_VERTICES) uniform isamplerBuffer ring_vertices;
layout(binding = UNIT_RING_FACES) uniform isamplerBuffer ring_faces;

// As cosines: 26 and 37 degrees of spread, 8 and 12 degrees of turn.
const double spread_full = 0.9LF, spread_none = 0.8LF;
const double turn_full = 0.9902680687415704LF, turn_none = 0.9781476007338057LF;
// Relative to distances of neighbors (noise), and to their heights (share).
const double noise_none = 0.015LF, noise_full = 0.05LF, share_none = 0.15LF, share_full = 0.4LF;

dvec3 fan_position(int entry) { return dvec3(mesh_position(texelFetch(fan_vertices, entry).x)); }

// The mean of |a|² |b|² over the faces; a and b are a face's edges from the fan's own vertex.
double mean_squares(int begin, int end) {
  dvec3 p = fan_position(begin);
  double sum = 0.0LF;
  for (int i = begin + 1; i < end - 1; ++i) {
    dvec3 a = fan_position(i) - p, b = fan_position(i + 1) - p;
    sum += dot(a, a) * dot(b, b);
  }
  return sum / double(end - begin - 2);
}

// N. Max's normal from edges to the vertices around; faces with |a|² |b|² below least_squares count by area.
dvec3 max_normal(int begin, int end, double least_squares) {
  dvec3 p = fan_position(begin), sum = dvec3(0.0LF);
  for (int i = begin + 1; i < end - 1; ++i) {
    dvec3 a = fan_position(i) - p, b = fan_position(i + 1) - p;
    double most = max(dot(a, a) * dot(b, b), least_squares);
    if (most > 0.0LF) sum += cross(a, b) / most;
  }
  dvec3 normal = unit_or_zero(sum);
  for (int i = end - 1; i > begin + 1 && normal == dvec3(0.0LF); --i) // if they cancel: the last face with a normal
    normal = unit_or_zero(cross(fan_position(i - 1) - p, fan_position(i) - p));
  return normal == dvec3(0.0LF) ? dvec3(0.0LF, 0.0LF, 1.0LF) : normal;
}

// The direction of the area-weighted mean of the rings' face normals. spread: that mean's length times its cosine with the
// normal.
dvec3 mean_of_faces(dvec3 normal, int begin, int end, out double spread) {
  dvec3 sum = dvec3(0.0LF);
  double areas = 0.0LF;
  for (int i = begin; i < end; ++i) {
    vec4 face = texelFetch(faces, texelFetch(ring_faces, i).x);
    double area = double(face.w) * double(face.w);
    sum += area * dvec3(face.xyz);
    areas += area;
  }
  spread = areas > 0.0LF ? dot(sum, normal) / areas : 1.0LF;
  dvec3 mean = unit_or_zero(sum);
  return mean == dvec3(0.0LF) ? normal : mean;
}

double smooth_between(double none, double full, double value) {
  double t = clamp((value - none) / (full - none), 0.0LF, 1.0LF);
  return t * t * (3.0LF - 2.0LF * t);
}

dvec3 unit(dvec3 v) { return v * (1.0LF / sqrt(dot(v, v))); }

dvec3 turned(dvec3 n, dvec3 p, dvec3 mean, double spread, int begin, int end) {
  dvec3 e1 = unit(cross(n, abs(n.x) < 0.6LF ? dvec3(1.0LF, 0.0LF, 0.0LF) : dvec3(0.0LF, 1.0LF, 0.0LF))), e2 = cross(n, e1);
  double squares = 0.0LF;
  begin_moments();
  for (int i = begin; i < end; ++i) {
    dvec3 d = dvec3(mesh_position(texelFetch(ring_vertices, i).x)) - p;
    add_height(dot(d, e1), dot(d, e2), dot(d, n));
    squares += dot(d, d);
  }
  dvec2 gradient;
  double noise;
  if (!fit_gradient(end - begin, gradient, noise)) return n;
  dvec3 fit = unit(n - gradient.x * e1 - gradient.y * e2);
  double weight = smooth_between(spread_none, spread_full, spread) * smooth_between(turn_none, turn_full, dot(n, fit));
  dvec3 smooth_normal = unit(n + weight * (fit - n));
  noise *= double(end - begin);
  double rough = smooth_between(noise_none, noise_full, sqrt(noise / squares)) *
                 (sum_ww > 0.0LF ? smooth_between(share_none, share_full, sqrt(noise / sum_ww)) : 0.0LF);
  if (rough == 0.0LF) return smooth_normal;
  dvec3 blended = unit_or_zero(smooth_normal + rough * (mean - smooth_normal));
  return blended == dvec3(0.0LF) ? smooth_normal : blended;
}

void main() {
  int fan = own_element();
  if (fan >= last) return;
  ivec3 begin = texelFetch(rings, fan).xyz, end = texelFetch(rings, fan + 1).xyz;
#if FITTED
  dvec3 normal = max_normal(begin.x, end.x, mean_squares(begin.x, end.x));
  double spread;
  dvec3 mean = mean_of_faces(normal, begin.z, end.z, spread);
  normal = turned(normal, fan_position(begin.x), mean, spread, begin.y, end.y);
#else
  dvec3 normal = max_normal(begin.x, end.x, 0.0LF);
#endif
  for (int i = 0; i < 3; ++i) normals[3 * fan + i] = float(normal[i]);
}
