#version 450 core
// One invocation, one place of a vertex in the UV map → every descriptor asked for, from one sampling of its neighborhood (paper 4.1).
#include "variant.glsl"
#include "device.glsl"
// The rim of the neighborhood's projection to the tangent plane, |x|^2 = r^2 (1 - RIM_BEND (kappa r)^2).
#if GEODESIC_BALL
#define RIM_BEND (1.0 / 3.0)
#else
#define RIM_BEND (1.0 / 4.0)
#endif
#include "kernel/interface.glsl"
#include "opengl/evaluate/buffers.glsl"
#include "descriptors.glsl"
#if INTEGRAL
#include "kernel/terms/ball.glsl"
#include "kernel/terms/area.glsl"
#endif
layout(local_size_x = GROUP_SIZE) in;
layout(std430, binding = BINDING_CENTERS) readonly restrict buffer Centers { CenterData centers[]; };
layout(std430, binding = BINDING_RESULTS) writeonly restrict buffer Results { uint results[]; }; // bits of floats, which keep NaN
#if EXACT
layout(std430, binding = BINDING_REACH) readonly restrict buffer Reach { int reach[]; };
layout(location = 15) uniform int reach_count;
ivec2 reach_range;
// Whether the surface reaches the triangle from the center within the ball. No loop: its rounds would count with those of the samples.
bool is_reached(int triangle) {
  int low = reach_range.x, high = reach_range.y;
#define HALVE { int middle = (low + high) / 2; bool below = low < high && reach[middle] < triangle; low = below ? middle + 1 : low; high = below ? high : middle; }
  HALVE HALVE HALVE HALVE HALVE HALVE HALVE HALVE HALVE HALVE HALVE HALVE HALVE
  return low < reach_range.y && reach[low] == triangle;
}
#else
bool is_reached(int triangle) { return true; }
#endif
#if MAP
layout(binding = UNIT_MAP) uniform sampler2D maps;
layout(std430, binding = BINDING_MAP_CENTERS) readonly restrict buffer MapCenters { vec4 map_centers[]; };
layout(std430, binding = BINDING_MAP_BARE) readonly restrict buffer MapBare { vec4 map_bare[]; };
#define MAP_OF_BARE(i) map_bare[i]
#else
#define MAP_OF_BARE(i) vec4(0.0)
#endif
#if FACES
layout(binding = UNIT_FACES) uniform sampler2D faces;
#endif
layout(location = 2) uniform int first;
layout(location = 3) uniform int last;
layout(location = 4) uniform int total;
layout(location = 5) uniform int samples;
layout(location = 6) uniform float radius;
layout(location = 7) uniform float enlargement;
layout(location = 8) uniform int block_size;
layout(location = 9) uniform int seed;
layout(location = 10) uniform float variate_share; // 0: no control variate
layout(location = 11) uniform float adaptive; // root mean square of the normals' deviation above which all samples are taken

struct Moments {
  float area;
  vec3 xx;      // sum of w x x^T, x in units of r
  vec3 xy;      // sum of w: x1 y1, x1 y2 + x2 y1, x2 y2
  float yy;     // sum of w |y|^2
  float squares; // sum of w^2
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

// Least squares: S minimizes the sum of w |S x - y|^2 over symmetric 2x2 matrices. False where x does not span the plane.
bool fit_shape_operator(Moments m, out vec3 shape) {
  shape = vec3(0.0);
  float determinant = m.xx.x * m.xx.z - m.xx.y * m.xx.y;
  float trace = m.xx.x + m.xx.z;
  if (!(determinant > 1e-4 * trace * trace)) return false;
  vec2 ratio = m.xx.y / vec2(m.xx.x, m.xx.z);
  float s12 = (m.xy.y - ratio.x * m.xy.x - ratio.y * m.xy.z) / (trace - m.xx.y * (ratio.x + ratio.y));
  shape = vec3((m.xy.x - s12 * m.xx.y) / m.xx.x, s12, (m.xy.z - s12 * m.xx.y) / m.xx.z);
  return true;
}

struct Sums {
  Center center;
  vec3 t1;
  vec3 t2;
  Moments moments;
#if INTEGRAL
  BallTerms ball;
#if EXTRAPOLATED
  BallTerms half_ball; // of half the radius
#endif
  AreaTerms areas;
#endif
  States states;
};

// Eigenvalues and eigenvectors of S.
void find_directions(Sums sums, inout Support support) {
  float mean = 0.5 * (support.shape.x + support.shape.z);
  vec2 gap = vec2(0.5 * (support.shape.x - support.shape.z), support.shape.y);
  float half_gap = length(gap);
  support.eigenvalues = vec2(mean + half_gap, mean - half_gap);
  // Half of the angle of gap, from whichever of its two forms does not cancel.
  vec2 e = gap.x >= 0.0 ? vec2(half_gap + gap.x, gap.y) : vec2(gap.y, half_gap - gap.x);
  e = half_gap > 0.0 ? normalize(e) : vec2(1.0, 0.0);
  support.directions = mat2x3(sums.t1 * e.x + sums.t2 * e.y, sums.t2 * e.x - sums.t1 * e.y);
}

// How far the second moments of a full disk may deviate. Few samples leave noise: of the rim, which 2 sqrt(pi n) of n cut.
float disk_tolerance(Moments m) {
  float share = m.squares / max(m.area * m.area, 1e-30); // 1 / n
  return max(DISK_DEVIATION, 6.0 * pow(share, 0.75) - 0.09);
}

// scale: of the sums, where only half of the samples were taken.
Support finish_support(Sums sums, float scale) {
  Moments m = sums.moments;
  const float none = NOT_A_NUMBER;
  Support support =
      Support(radius, scale * m.area, scale, vec3(0.0), vec2(none), mat2x3(vec3(none), vec3(none)), 1.0, DISK_DEVIATION, 0.0, none, none, none, none);
  if (fit_shape_operator(m, support.shape)) {
    support.shape /= radius;
    find_directions(sums, support);
    // The control variate's exact mean is that of a full flat disk: second moments pi r^4/4 each.
    float disk = 0.25 * PI * radius * radius;
    vec3 off = abs(scale * m.xx / disk - vec3(1.0, 0.0, 1.0));
    support.deviation = max(max(off.x, off.z), off.y);
    support.tolerance = disk_tolerance(m);
    support.variate =
        m.cut > 0.0 ? 0.0 : variate_share * (1.0 - smoothstep(support.tolerance, 3.0 * support.tolerance, support.deviation));
  }
#if INTEGRAL
  if (!(m.area > 0.0)) return support;
  support.mean = ball_mean_curvature(sums.ball, support);
#if EXTRAPOLATED
  Support half_support = support;
  half_support.radius *= 0.5;
  support.mean = (4.0 * ball_mean_curvature(sums.half_ball, half_support) - support.mean) / 3.0;
#endif
  support.gauss = area_gaussian_curvature(area_finish(sums.areas, sums.areas.inside, support), radius);
  float root = sqrt(max(support.mean * support.mean - support.gauss, 0.0));
  support.k1 = support.mean + root;
  support.k2 = support.mean - root;
#else
  support.k1 = support.eigenvalues.x;
  support.k2 = support.eigenvalues.y;
  support.mean = 0.5 * (support.k1 + support.k2);
  support.gauss = support.k1 * support.k2;
#endif
  return support;
}

// Whether the normals deviate from what the shape operator says by more than the threshold.
bool is_rough(Moments m) {
  vec3 shape;
  if (!fit_shape_operator(m, shape)) return true;
  float unexplained = m.yy - dot(shape, m.xy);
  return unexplained > adaptive * adaptive * m.area;
}

// The distance along the surface by the normal curvature from p to q: the arc over the chord.
float geodesic_distance(Center center, Neighbor neighbor) {
  float square = neighbor.rho * neighbor.rho;
  float bend = dot(neighbor.normal - center.normal, neighbor.offset) / max(square, 1e-30); // kappa
  return neighbor.rho * (1.0 + bend * bend * square / 24.0);
}

#if MAP
// A tangent vector v of a place with normal m, turned with it into the tangent plane of n: no projection would keep its length.
vec3 turn_to(vec3 n, vec3 m, vec3 v) { return v - (n + m) * (dot(n, v) / max(1.0 + dot(n, m), LEAST_TURN)); }
#endif

// One place of the surface, on that triangle. near: nearer to the center than texels can tell. geodesic: its distance along the surface where that is
// known, else below 0. map: gradient and value of f there.
void add_neighbor(inout Sums sums, vec3 position, vec3 normal, int triangle, float area, bool near, float geodesic, vec4 map) {
  Neighbor neighbor;
  neighbor.offset = position - sums.center.position;
  neighbor.rho = length(neighbor.offset);
  neighbor.normal = normal;
#if FACES
  neighbor.face = texelFetch(faces, list_place(triangle), 0).xyz;
#endif
  neighbor.area = area;
  neighbor.geodesic = geodesic < 0.0 ? geodesic_distance(sums.center, neighbor) : geodesic;
#if GEODESIC_BALL
  neighbor.distance = neighbor.geodesic;
#else
  neighbor.distance = neighbor.rho;
#endif
  // A square that the rim cuts counts by the part of it that lies inside. Where none does all of this adds nothing: software devices would
  // mask every sum that follows a return.
  neighbor.weight = area * rim_share(neighbor.distance, radius, area);
  neighbor.near = near || neighbor.rho == 0.0;
  vec2 x = vec2(dot(neighbor.offset, sums.t1), dot(neighbor.offset, sums.t2)) * (1.0 / radius);
  vec2 y = vec2(dot(neighbor.normal, sums.t1), dot(neighbor.normal, sums.t2));
  neighbor.direction = x * inversesqrt(max(dot(x, x), 1e-12));
  sums.moments.area += neighbor.weight;
  sums.moments.squares += neighbor.weight * neighbor.weight;
  sums.moments.xx += neighbor.weight * outer(x);
  sums.moments.xy += neighbor.weight * vec3(x.x * y.x, x.x * y.y + x.y * y.x, x.y * y.y);
  sums.moments.yy += neighbor.weight * dot(y, y);
#if INTEGRAL
  ball_add(sums.ball, sums.center, neighbor);
#if EXTRAPOLATED
  Neighbor inner = neighbor;
  inner.weight = area * rim_share(neighbor.distance, 0.5 * radius, area);
  if (inner.weight > 0.0) ball_add(sums.half_ball, sums.center, inner);
#endif
  area_add(sums.areas, sums.center, neighbor);
#endif
#if MAP
  neighbor.place = x;
  neighbor.value = map.w - sums.center.value;
  neighbor.slope = map_radius * turn_to(sums.center.normal, normal, map.xyz) * sums.center.tangents;
  if (isnan(map.w)) return; // the map does not exist there
#endif
  states_add(sums.states, sums.center, neighbor);
}

// The point of one texel and what it stands for. reach: how far the texel reaches in space.
void add_point(inout Sums sums, vec3 position, vec3 normal, float area, float reach, ivec2 texel, float geodesic) {
#if EXACT || FACES
  int triangle = texelFetch(ids, texel, 0).y;
  if (triangle < 0) triangle = -1 - triangle;
#else
  const int triangle = -1;
#endif
  if (!is_reached(triangle)) return;
  bool near = length(position - sums.center.position) < reach;
#if MAP
  vec4 map = texelFetch(maps, texel, 0);
#else
  const vec4 map = vec4(0.0);
#endif
  add_neighbor(sums, position, normal, triangle, area, near, geodesic, map);
}

// One texel: cell is the area in (u, v) that it stands for.
void add_texel(inout Sums sums, ivec2 texel, float cell, float geodesic) {
  vec3 normal;
  vec4 point = surface_at(texel, normal);
  add_point(sums, point.xyz, normal, point.w * cell, reach_of_texel(point.w), texel, geodesic);
}

#if AFFINE || PAPER
#include "opengl/march/walks.glsl"
#if AFFINE
#include "opengl/march/affine.glsl"
#else
#include "opengl/march/paper.glsl"
#endif
#else
#include "opengl/evaluate/connected.glsl"
#endif

#if AFFINE || PAPER
// False where samples are left to later dispatches.
bool take_samples(inout Sums sums, CenterData data, int index, out float scale) {
  int slot = int(gl_GlobalInvocationID.x);
  bool refined = true;
  if (begin_sample > 0 || (PAPER == 1 && marks_only == 0)) {
    sums = progress[slot].sums;
    refined = progress[slot].refined != 0;
  }
#if ADAPTIVE
  if (begin_sample == first_half() && marks_only == 0) refined = sums.moments.cut > 0.0 || is_rough(sums.moments);
#endif
  Place place = place_of(data, index);
#if PAPER
  first_visit = slot * MAX_VISITS;
  visit_count = progress[slot].visit_count;
  if (marks_only != 0) {
    bool left = mark_charts(sums, place);
    progress[slot].left = left || (begin_sample > 0 && progress[slot].left != 0) ? 1 : 0;
    progress[slot].visit_count = visit_count;
  } else if (refined) {
    sample_support(sums, place, progress[slot].left != 0);
  }
#else
  if (refined) sample_support(sums, place);
#endif
  scale = refined ? 1.0 : 2.0;
  if (marks_only == 0 && end_sample == samples) return true;
  progress[slot].sums = sums;
  progress[slot].refined = refined ? 1 : 0;
  return false;
}
#else
bool take_samples(inout Sums sums, CenterData data, int index, out float scale) {
  scale = 1.0;
#if ADAPTIVE
  sample_support(sums, data, index, 0);
  if (sums.moments.cut > 0.0 || is_rough(sums.moments))
    sample_support(sums, data, index, 1);
  else
    scale = 2.0;
#else
  sample_support(sums, data, index);
#endif
  return true;
}
#endif

void main() {
  // Software devices give each core a row of groups: every other one, so that cores have as much to do where centers in a row are costly.
  int group = int(gl_WorkGroupID.x), even = (int(gl_NumWorkGroups.x) + 1) / 2;
  group = group < even ? 2 * group : 2 * (group - even) + 1;
  int index = first + group * GROUP_SIZE + int(gl_LocalInvocationID.x);
  if (index >= last) return;
#if EXACT
  reach_range = ivec2(reach[reach_count + index], reach[reach_count + index + 1]);
  index = reach[index];
#endif
  CenterData data = centers[index];
  Sums sums;
  sums.center.position = data.position_chart.xyz;
  sums.center.normal = data.normal_phase.xyz;
  sums.center.radius = radius;
  tangents(sums.center.normal, sums.t1, sums.t2);
#if MAP
  sums.center.value = map_centers[index].w;
  sums.center.tangents = mat2x3(sums.t1, sums.t2);
#endif
  sums.moments = Moments(0.0, vec3(0.0), vec3(0.0), 0.0, 0.0, 0.0, 0.0);
#if INTEGRAL
  ball_init(sums.ball);
#if EXTRAPOLATED
  ball_init(sums.half_ball);
#endif
  area_init(sums.areas);
#endif
  states_init(sums.states);
  float scale;
  if (!take_samples(sums, data, index, scale)) return;

  Moments m = sums.moments;
  Center center = sums.center;
  States states = sums.states;
  Support support = finish_support(sums, scale);
  float coverage = m.area > 0.0 ? m.area / (m.area + m.lost) : 0.0;
  float flags = (m.cut > 0.0 ? FLAG_CUT : 0.0) + (scale == 1.0 ? FLAG_ALL_SAMPLES : 0.0) +
                (support.deviation > support.tolerance ? FLAG_NO_DISK : 0.0) +
                (support.deviation > 2.0 * support.tolerance + 0.1 ? FLAG_FAR_FROM_DISK : 0.0);
  results[ROW_COVERAGE * total + index] = floatBitsToUint(coverage);
  results[ROW_FLAGS * total + index] = floatBitsToUint(flags);
  results[ROW_AREA * total + index] = floatBitsToUint(support.area);
  STATES_FINISH
}
