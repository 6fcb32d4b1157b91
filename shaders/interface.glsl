// All that a descriptor sees of the world: the center, one neighbor at a time, and at the end the support they made.
#include "shared.h"
#include "descriptor_limits.h"

struct Center {
  vec3 position;
  vec3 normal;
  float radius;
};

struct Neighbor {
  vec3 offset;     // d = q - p
  float rho;       // |d|
  vec3 normal;     // n_i, unit
  vec2 direction;  // unit tangent direction e of d
  float weight;    // w: the surface area this neighbor stands for
  bool near;       // nearer than one texel: too near for anything divided by rho
};

struct Support {
  float radius;
  float area;      // sum of w
  vec3 shape;      // shape operator S: s_xx, s_xy, s_yy
  float k1;        // its eigenvalues, k1 >= k2; NaN where it cannot be fitted
  float k2;
  float variate;   // how far S may serve as control variate: 1 on a full disk, 0 where the support is cut or folded
};

const float PI = 3.14159265358979;
const float NOT_A_NUMBER = uintBitsToFloat(0x7fc00000u);

// e^T S e and |S e|^2, summed over neighbors by the moments of e e^T (xx, xy, yy).
float normal_curvature(vec3 shape, vec3 moments) { return shape.x * moments.x + 2.0 * shape.y * moments.y + shape.z * moments.z; }
vec3 square(vec3 shape) {
  return vec3(shape.x * shape.x + shape.y * shape.y, shape.y * (shape.x + shape.z), shape.y * shape.y + shape.z * shape.z);
}
vec3 outer(vec2 v) { return vec3(v.x * v.x, v.x * v.y, v.y * v.y); }

// For a descriptor that follows from the support alone.
#define DESCRIPTOR_WITHOUT_STATE                                                                                                    \
  struct State { float none; };                                                                                                     \
  void descriptor_init(out State state) { state.none = 0.0; }                                                                       \
  void descriptor_add(inout State state, Center center, Neighbor neighbor) {}
