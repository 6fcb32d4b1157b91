// Unit vectors → the square that a flattened octahedron makes, and back (Meyer et al. 2010); numbers from -1 to 1 in 16-bit floats, and
// what rounding took from them.
vec2 fold(vec2 place) { return (1.0 - abs(place.yx)) * vec2(place.x < 0.0 ? -1.0 : 1.0, place.y < 0.0 ? -1.0 : 1.0); }

vec2 to_octahedron(vec3 direction) {
  vec3 n = direction / max(abs(direction.x) + abs(direction.y) + abs(direction.z), 1e-30);
  return n.z < 0.0 ? fold(n.xy) : n.xy;
}

vec3 from_octahedron(vec2 place) {
  float z = 1.0 - abs(place.x) - abs(place.y);
  return normalize(vec3(z < 0.0 ? fold(place) : place, z));
}

// Rounding takes 2^-12 at most. 12 bits hold three such rests in 16 steps each, or two in 64: a whole number that a 16-bit float has
// exactly.
const float REST = 1.0 / 4096.0;
const float LEAST_CODE = -2048.0;

ivec3 steps_of(vec3 rest, int count) { return clamp(ivec3(floor((rest / REST + 1.0) * 0.5 * float(count))), ivec3(0), ivec3(count - 1)); }
vec3 rest_of(ivec3 steps, int count) { return ((vec3(steps) + 0.5) * (2.0 / float(count)) - 1.0) * REST; }

float code_of_three(vec3 rest) {
  ivec3 s = steps_of(rest, 16);
  return float(s.x | s.y << 4 | s.z << 8) + LEAST_CODE;
}
float code_of_two(vec2 rest) {
  ivec3 s = steps_of(vec3(rest, 0.0), 64);
  return float(s.x | s.y << 6) + LEAST_CODE;
}
vec3 three_of_code(float code) {
  int c = int(code - LEAST_CODE);
  return rest_of(ivec3(c & 15, c >> 4 & 15, c >> 8), 16);
}
vec2 two_of_code(float code) {
  int c = int(code - LEAST_CODE);
  return rest_of(ivec3(c & 63, c >> 6, 0), 64).xy;
}
