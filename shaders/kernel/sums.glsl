// Neighbors of a center → their sums → the neighborhood: its area, its shape operator, the curvatures that follow from it.
#include "kernel/interface.glsl"
#include "terms.glsl"

struct Moments {
  float area;
  vec3 xx;             // sum of w x x^T, x in units of r
  vec3 xy;             // sum of w: x1 y1, x1 y2 + x2 y1, x2 y2
  float yy;            // sum of w |y|^2
  float squares;       // sum of w^2
  float facets;        // sum of w times the area of the triangle
  float noise;         // sum of w times the variance of the positions along normals, in units of r^2
  float missing_area;  // area of samples that end on no texel, or exceed a device's iterations
  float hits_boundary; // above 0 if the mesh's boundary lies within the ball
};

#if EXTRAPOLATED
// Moments weighted by windows of t = (distance/r)^2: by 1 - t, and by its square.
struct Windows {
  vec3 wide_xx, wide_xy;
  vec3 narrow_xx, narrow_xy;
};
#endif

struct Sums {
  Center center;
  Moments moments;
#if EXTRAPOLATED
  Windows windows;
#endif
  Terms terms;
};

// An orthonormal pair of tangents (Duff et al. 2017).
void tangents(vec3 n, OUT(vec3) t1, OUT(vec3) t2) {
  float s = mix(-1.0f, 1.0f, n.z >= 0.0f);
  float a = -1.0f / (s + n.z);
  float b = n.x * n.y * a;
  t1 = vec3(1.0f + s * n.x * n.x * a, s * b, -s * n.x);
  t2 = vec3(b, s + n.y * n.y * a, -n.y);
}

// value: the map's value at the center.
void sums_init(OUT(Sums) sums, vec3 position, vec3 normal, float value) {
  sums.center.position = position;
  sums.center.normal = normal;
  tangents(normal, sums.center.t1, sums.center.t2);
#if MAP
  sums.center.value = value;
#endif
  sums.moments.area = 0.0f;
  sums.moments.xx = vec3(0.0f);
  sums.moments.xy = vec3(0.0f);
  sums.moments.yy = 0.0f;
  sums.moments.squares = 0.0f;
  sums.moments.facets = 0.0f;
  sums.moments.noise = 0.0f;
  sums.moments.missing_area = 0.0f;
  sums.moments.hits_boundary = 0.0f;
#if EXTRAPOLATED
  sums.windows.wide_xx = vec3(0.0f);
  sums.windows.wide_xy = vec3(0.0f);
  sums.windows.narrow_xx = vec3(0.0f);
  sums.windows.narrow_xy = vec3(0.0f);
#endif
  terms_init(sums.terms);
}

// ---- Adding

// The distance along the surface from the normal curvature between p and q: the length of an arc over the chord.
float geodesic_distance(Center center, Neighbor neighbor) {
  float square = neighbor.rho * neighbor.rho;
  float bend = dot(neighbor.normal - center.normal, neighbor.offset) / max(square, 1e-30f); // kappa
  return neighbor.rho * (1.0f + bend * bend * square / 24.0f);
}

// Turns a tangent vector v at normal m into the tangent plane of n. Unlike a projection, this keeps its length.
vec3 turn_to(vec3 n, vec3 m, vec3 v) { return v - (n + m) * (dot(n, v) / max(1.0f + dot(n, m), float(LEAST_TURN))); }

#if EXTRAPOLATED
// xx, xy: moments at this distance, already multiplied by the weight in the ball.
void add_to_windows(INOUT(Windows) windows, float distance, vec3 xx, vec3 xy) {
  float t = distance / params.radius, window = max(1.0f - t * t, 0.0f);
  windows.wide_xx += window * xx;
  windows.wide_xy += window * xy;
  windows.narrow_xx += window * window * xx;
  windows.narrow_xy += window * window * xy;
}
#endif

// Adds a neighbor. All its members must be set, except those that follow from its place in the tangent plane.
void add_weighted(INOUT(Sums) sums, Neighbor neighbor, vec4 map) {
  Center center = sums.center;
  vec2 x = vec2(dot(neighbor.offset, center.t1), dot(neighbor.offset, center.t2)) * (1.0f / params.radius);
#if VARIATE
  neighbor.direction = x * inversesqrt(max(dot(x, x), 1e-12f));
#ifndef WIDE_NEIGHBORS
  neighbor.directions = outer(neighbor.direction);
#endif
#endif
  sums.moments.area += neighbor.weight;
#if !(MAP && defined(WIDE_NEIGHBORS)) // no control variate is used for a map over wide neighbors
  vec2 y = vec2(dot(neighbor.normal, center.t1), dot(neighbor.normal, center.t2));
  sums.moments.squares += neighbor.weight * neighbor.weight;
  sums.moments.facets += neighbor.weight * neighbor.facet;
  sums.moments.noise += neighbor.weight * neighbor.noise;
  vec3 xx = neighbor.weight * outer(x), xy = neighbor.weight * vec3(x.x * y.x, x.x * y.y + x.y * y.x, x.y * y.y);
  sums.moments.xx += xx;
  sums.moments.xy += xy;
#if EXTRAPOLATED
  add_to_windows(sums.windows, neighbor.distance, xx, xy);
#endif
  sums.moments.yy += neighbor.weight * dot(y, y);
#endif
#if MAP
  bool unknown = isnan(map.w); // the map does not exist there
  vec3 slope = params.map_radius * turn_to(center.normal, neighbor.normal, vec3(map.x, map.y, map.z));
  neighbor.weight = mix(neighbor.weight, 0.0f, unknown);
  neighbor.coordinates = x;
  neighbor.value = mix(map.w - center.value, 0.0f, unknown);
  neighbor.slope = vec2(dot(slope, center.t1), dot(slope, center.t2));
#endif
  terms_add(sums.terms, center, neighbor);
}

// Adds one sample of the surface. face: its triangle's unit normal, if FACES is set. near: nearer to the center than texels can
// resolve. geodesic: its distance along the surface, or below 0 if unknown. map: gradient and value of f at the sample, if MAP is
// set.
void add_neighbor(INOUT(Sums) sums, vec3 position, vec3 normal, vec3 face, float area, bool near, float geodesic, vec4 map) {
  Center center = sums.center;
  Neighbor neighbor;
  neighbor.offset = position - center.position;
  neighbor.rho = length(neighbor.offset);
  neighbor.mean_rho = neighbor.rho;
  neighbor.normal = normal;
  neighbor.noise = NOT_A_NUMBER; // unknown for texels
  neighbor.facet = NOT_A_NUMBER;
#if FACES
  neighbor.face = face;
#endif
  neighbor.area = area;
  neighbor.geodesic = mix(geodesic, geodesic_distance(center, neighbor), geodesic < 0.0f);
#if GEODESIC_BALL
  neighbor.distance = neighbor.geodesic;
#else
  neighbor.distance = neighbor.rho;
#endif
  // A square cut by the rim counts by the part that lies inside. For squares outside, everything below adds zero: after a return,
  // software devices would have to mask every sum.
  float per_side = per_side_of(area);
  neighbor.weight = area * rim_share(neighbor.distance, params.radius, per_side);
  neighbor.inside = area * rim_share(neighbor.geodesic, params.radius, per_side);
  neighbor.near = near || neighbor.rho == 0.0f;
  vec3 turn = center.normal - normal;
  neighbor.turning = dot(turn, turn) / mix(neighbor.rho * neighbor.rho, 1.0f, neighbor.near);
  add_weighted(sums, neighbor, map);
}

// ---- Finishing

// Least squares: S minimizes the sum of w |S x - y|^2 over symmetric 2x2 matrices. Returns false if x does not span the plane.
bool fit_shape_operator(vec3 xx, vec3 xy, OUT(vec3) shape) {
  shape = vec3(0.0f);
  float spread = xx.x * xx.z - xx.y * xx.y;
  float trace = xx.x + xx.z;
  if (!(spread > 1e-5f * trace * trace)) return false;
  vec2 ratio = xx.y / vec2(xx.x, xx.z);
  float s12 = (xy.y - ratio.x * xy.x - ratio.y * xy.z) / (trace - xx.y * (ratio.x + ratio.y));
  shape = vec3((xy.x - s12 * xx.y) / xx.x, s12, (xy.z - s12 * xx.y) / xx.z);
  return true;
}

// S by the requested estimator, in units of 1/r. To lowest order a window blurs by the mean of t^2 over that of t, which is 1/2
// and 2/5 on a disk, so the error that grows with r^2 cancels. Among all sums without that error, this window, (1 - t)(3 - 5 t),
// magnifies noise least.
bool find_shape_operator(Sums sums, OUT(vec3) shape) {
  bool found = fit_shape_operator(sums.moments.xx, sums.moments.xy, shape);
#if EXTRAPOLATED
  vec3 wide, narrow;
  found = found && fit_shape_operator(sums.windows.wide_xx, sums.windows.wide_xy, wide) &&
          fit_shape_operator(sums.windows.narrow_xx, sums.windows.narrow_xy, narrow);
  if (found) shape = 5.0f * narrow - 4.0f * wide;
#endif
  return found;
}

// Returns whether the normals deviate from the shape operator's prediction by more than the threshold.
bool is_rough(Moments m) {
  vec3 shape;
  if (!fit_shape_operator(m.xx, m.xy, shape)) return true;
  float unexplained = m.yy - dot(shape, m.xy);
  return unexplained > params.adaptive * params.adaptive * m.area;
}

// Eigenvalues and eigenvectors of S.
void find_directions(Center center, INOUT(Neighborhood) neighborhood) {
  float mean = 0.5f * (neighborhood.shape.x + neighborhood.shape.z);
  vec2 gap = vec2(0.5f * (neighborhood.shape.x - neighborhood.shape.z), neighborhood.shape.y);
  float half_gap = length(gap);
  neighborhood.eigenvalues = vec2(mean + half_gap, mean - half_gap);
  // Half the angle of gap, by the one of two formulas that does not cancel. On a flat surface gap may be so small that its squares
  // are no floats.
  vec2 lifted = gap * (half_gap < 1e-12f ? 1e12f : 1.0f);
  float size = length(lifted);
  vec2 e = lifted.x >= 0.0f ? vec2(size + lifted.x, lifted.y) : vec2(lifted.y, size - lifted.x);
  e = size > 1e-18f ? normalize(e) : vec2(1.0f, 0.0f);
  neighborhood.direction_max = center.t1 * e.x + center.t2 * e.y;
  neighborhood.direction_min = center.t2 * e.x - center.t1 * e.y;
}

// The standard error of H caused by independent noise of the vertices. By Gauss's theorem H is a sum over heights z: 2 z over the
// ball, -r z over its rim; windows that are 0 at the rim have no rim term. A vertex stands for two triangles. Normals blur the
// ball and its rim, because each normal comes from several vertices.
float standard_error_of(Moments m) {
  float r = params.radius, vertex = 2.0f * m.facets / m.area;
  float blurred = r * r + float(BLUR_OF_NORMALS) * vertex;
#if EXTRAPOLATED
  float growth = 48.0f;
#else
  float growth = 1.0f + r / sqrt(float(BLUR_OF_NORMALS) * 4.0f * vertex);
#endif
  float variance = float(NOISE_SHARE) * m.noise / m.area * r * r * vertex;
  return sqrt(16.0f / PI * variance * growth / blurred) / blurred;
}

// The tolerance of a full disk's second moments. Few samples are noisy: the rim cuts 2 sqrt(pi n) of n samples.
float disk_tolerance(Moments m) {
  float share = m.squares / max(m.area * m.area, 1e-30f); // 1 / n
  return max(float(DISK_DEVIATION), 6.0f * sqrt(share * sqrt(share)) - 0.09f);
}

Neighborhood unfitted_neighborhood(float area, float scale) {
  Neighborhood neighborhood;
  neighborhood.radius = params.radius;
  neighborhood.area = area;
  neighborhood.scale = scale;
  neighborhood.shape = vec3(0.0f);
  neighborhood.eigenvalues = vec2(NOT_A_NUMBER);
  neighborhood.direction_max = vec3(NOT_A_NUMBER);
  neighborhood.direction_min = vec3(NOT_A_NUMBER);
  neighborhood.variate = 0.0f;
  neighborhood.mean = NOT_A_NUMBER;
  neighborhood.gauss = NOT_A_NUMBER;
  neighborhood.k1 = NOT_A_NUMBER;
  neighborhood.k2 = NOT_A_NUMBER;
  neighborhood.standard_error = NOT_A_NUMBER;
  return neighborhood;
}

#if INTEGRAL
void find_curvatures(Sums sums, INOUT(Neighborhood) neighborhood) {
  if (!(sums.moments.area > 0.0f)) return;
  neighborhood.mean = ball_mean_curvature(sums.terms.ball, neighborhood);
  neighborhood.gauss = area_gaussian_curvature(area_finish(sums.terms.area, sums.terms.area.inside, neighborhood), params.radius);
  float root = sqrt(max(neighborhood.mean * neighborhood.mean - neighborhood.gauss, 0.0f));
  neighborhood.k1 = neighborhood.mean + root;
  neighborhood.k2 = neighborhood.mean - root;
}
#else
void find_curvatures(Sums sums, INOUT(Neighborhood) neighborhood) {
  neighborhood.k1 = neighborhood.eigenvalues.x;
  neighborhood.k2 = neighborhood.eigenvalues.y;
  neighborhood.mean = 0.5f * (neighborhood.k1 + neighborhood.k2);
  neighborhood.gauss = neighborhood.k1 * neighborhood.k2;
}
#endif

// scale: 2 if only half of the samples were taken, else 1.
Neighborhood finish_neighborhood(Sums sums, float scale) {
  Moments m = sums.moments;
  Neighborhood neighborhood = unfitted_neighborhood(scale * m.area, scale);
  if (find_shape_operator(sums, neighborhood.shape)) {
    neighborhood.shape /= params.radius;
    find_directions(sums.center, neighborhood);
    neighborhood.standard_error = standard_error_of(m);
    // The control variate's exact mean holds for a full flat disk, whose second moments are pi r^4/4 each. These show no
    // cut that takes little of the disk.
    float disk = 0.25f * PI * params.radius * params.radius;
    vec3 off = abs(scale * m.xx / disk - vec3(1.0f, 0.0f, 1.0f));
    float deviation = max(max(off.x, off.z), off.y), tolerance = disk_tolerance(m);
    neighborhood.variate = m.hits_boundary > 0.0f ? 0.0f : params.variate_share * (1.0f - smoothstep(tolerance, 3.0f * tolerance, deviation));
  }
  find_curvatures(sums, neighborhood);
  return neighborhood;
}
