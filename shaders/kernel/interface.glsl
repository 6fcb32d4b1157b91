// The inputs of descriptors: a center, one neighbor at a time, and at the end the neighborhood that was fitted to all of them.
//
// Everything in kernel/ is both GLSL and C++. So floats end in f, whole vectors are written without swizzles, parameters that a
// function sets are OUT(type) or INOUT(type), and code that runs for each neighbor chooses by mix() instead of branches: C++ adds
// several neighbors at a time, in lanes.
#include "shared.h"
#include "kernel/limits.h"

#ifndef VARIATE // whether sums reduce the noise of samples by the shape operator as control variate
#define VARIATE 1
#endif
#define PI 3.14159265358979f
#ifndef __cplusplus
#define OUT(type) out type
#define INOUT(type) inout type
#define NOT_A_NUMBER uintBitsToFloat(0x7fc00000u) // not a constant: strict compilers accept no built-in function in one
#endif

struct Center {
  vec3 position;
  vec3 normal;
  vec3 t1; // with t2: axes of the tangent plane for the coordinates of neighbors
  vec3 t2;
#if MAP
  float value; // f at p
#endif
};

struct Neighbor {
  vec3 offset;     // d = q - p
  float rho;       // |d|
  float mean_rho;  // mean of |d| over the surface it stands for
  vec3 normal;     // n_i, unit
  float noise;     // variance of the surface along its normals, in units of r^2
  float facet;     // area of the triangle it lies on, or mean area of several
#if FACES
  vec3 face;       // unit normal of the triangle it lies on
#endif
#if VARIATE
  vec2 direction;  // unit tangent direction e of d
  vec3 directions; // mean of e e^T over the surface it stands for
#endif
  float geodesic;  // s, the distance along the surface
  float distance;  // rho or s, whichever bounds the neighborhood
  float area;      // the surface area this neighbor stands for
  float weight;    // w: the part of that area within the neighborhood
  float inside;    // the part within r along the surface
  float turning;   // mean of |n - n_i|^2/rho^2 over that surface
  bool near;       // nearer than one texel: too near to divide by rho
#if MAP
  vec2 coordinates; // d in the tangents of p, in units of r
  float value;     // f_i - f(p)
  vec2 slope;      // r grad f_i in the tangents of p, r that of f; NaN if it does not exist, 0 if no operator needs it
#endif
};

struct Neighborhood {
  float radius;
  float area;         // sum of w
  float scale;        // factor of sums over samples: 2 if adaptive sampling took half of them, else 1
  vec3 shape;         // shape operator S: s_xx, s_xy, s_yy
  vec2 eigenvalues;   // of S, the larger first; NaN where it cannot be fitted
  vec3 direction_max; // unit tangents for these eigenvalues
  vec3 direction_min;
  float variate;      // weight of S as control variate: 1 on a full disk, 0 if the neighborhood hits the boundary or is no disk
  float mean;         // H, K, k1 >= k2 by the requested estimator
  float gauss;
  float k1;
  float k2;
  float standard_error; // of H, by noise; NaN if the noise is unknown
};

// e^T S e and |S e|^2, summed over neighbors by the moments of e e^T (xx, xy, yy).
float normal_curvature(vec3 shape, vec3 moments) { return shape.x * moments.x + 2.0f * shape.y * moments.y + shape.z * moments.z; }
vec3 square(vec3 shape) {
  return vec3(shape.x * shape.x + shape.y * shape.y, shape.y * (shape.x + shape.z), shape.y * shape.y + shape.z * shape.z);
}
vec3 outer(vec2 v) { return vec3(v.x * v.x, v.x * v.y, v.y * v.y); }

vec3 positive_direction(vec3 v) {
  vec3 size = abs(v);
  float largest = size.x >= size.y && size.x >= size.z ? v.x : size.y >= size.z ? v.y : v.z;
  return largest < 0.0f ? -v : v;
}

// The means over directions of |S e|^2 and of kappa_S(e) in a full neighborhood. If the distance along the surface bounds the
// neighborhood, its rim is nearer by a factor of 1 - (kappa r)^2/24 where the surface bends.
vec2 exact_means(Neighborhood neighborhood) {
  vec2 k = neighborhood.eigenvalues;
  vec2 exact = vec2(0.5f * dot(k, k), 0.5f * (k.x + k.y));
#if GEODESIC_BALL
  float h = exact.y, d = 0.5f * (k.x - k.y), square = neighborhood.radius * neighborhood.radius;
  float square_mean = h * h + 0.5f * d * d; // of kappa^2
  float cube_mean = h * (h * h + 1.5f * d * d);
  exact -= square * vec2(h * h * d * d / 6.0f, cube_mean / 6.0f - h * square_mean / 8.0f);
#endif
  return exact;
}

// The inverse of the side of a square of this area.
float per_side_of(float area) { return inversesqrt(max(area, 1e-20f)); }

// The share of a square at this distance that lies within the radius.
float rim_share(float away, float radius, float per_side) { return clamp((radius - away) * per_side + 0.5f, 0.0f, 1.0f); }

// A Gaussian window of the distance rho.
float gaussian(float rho, float width) { return exp(rho * rho * (-0.5f / (width * width))); }
