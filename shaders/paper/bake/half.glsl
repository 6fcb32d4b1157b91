// Floats → the nearest 16-bit floats, and the rounding errors of numbers between -1 and 1; unit vectors → the square of a
// flattened octahedron, and back (Meyer et al. 2010). C++ compiles this text, too (engine/paper/half.h).

// Ties go to the even number. Drivers may round freely when they pack or store floats; integers leave them no choice.
float nearest_half(float value) {
  uint bits = floatBitsToUint(value), sign_bit = bits & 0x80000000u, size = bits & 0x7fffffffu;
  if (size >= 0x7f800000u) return value; // infinite, or not a number
  if (size >= 0x38800000u) {             // 2^-14: above it, 10 of the 23 fraction bits stay
    uint rounded = (size + 0xfffu + ((size >> 13) & 1u)) & 0xffffe000u;
    return uintBitsToFloat(sign_bit | (rounded < 0x47800000u ? rounded : 0x7f800000u)); // 2^16 exceeds the largest half
  }
  uint exponent = size >> 23, digits = (size & 0x7fffffu) | 0x800000u; // below it, halves are multiples of 2^-24
  uint dropped = exponent > 101u ? 126u - exponent : 25u;
  uint steps = (digits + (1u << (dropped - 1u)) - 1u + ((digits >> dropped) & 1u)) >> dropped;
  return uintBitsToFloat(sign_bit | floatBitsToUint(float(steps) / 16777216.0f));
}
vec3 nearest_half(vec3 value) { return vec3(nearest_half(value.x), nearest_half(value.y), nearest_half(value.z)); }
vec2 nearest_half(vec2 value) { return vec2(nearest_half(value.x), nearest_half(value.y)); }

vec2 fold(vec2 octahedral) {
  return vec2((1.0f - abs(octahedral.y)) * (octahedral.x < 0.0f ? -1.0f : 1.0f), (1.0f - abs(octahedral.x)) * (octahedral.y < 0.0f ? -1.0f : 1.0f));
}

vec2 to_octahedron(vec3 direction) {
  vec3 n = direction / max(abs(direction.x) + abs(direction.y) + abs(direction.z), 1e-30f);
  return n.z < 0.0f ? fold(vec2(n.x, n.y)) : vec2(n.x, n.y);
}

vec3 from_octahedron(vec2 octahedral) {
  float z = 1.0f - abs(octahedral.x) - abs(octahedral.y);
  return normalize(vec3(z < 0.0f ? fold(octahedral) : octahedral, z));
}

// Rounding errors are at most 2^-12. 12 bits hold three such errors in 16 steps each, or two in 64 steps: an integer that a
// 16-bit float stores exactly.
#define LARGEST_REST (1.0f / 4096.0f)
#define LEAST_CODE -2048

ivec3 steps_of(vec3 rest, int count) {
  return clamp(ivec3(floor((rest / LARGEST_REST + 1.0f) * 0.5f * float(count))), ivec3(0), ivec3(count - 1));
}
vec3 rest_of(ivec3 steps, int count) { return ((vec3(steps) + 0.5f) * (2.0f / float(count)) - 1.0f) * LARGEST_REST; }

float code_of_three(vec3 rest) {
  ivec3 s = steps_of(rest, 16);
  return float((s.x | s.y << 4 | s.z << 8) + LEAST_CODE);
}
float code_of_two(vec2 rest) {
  ivec3 s = steps_of(vec3(rest, 0.0f), 64);
  return float((s.x | s.y << 6) + LEAST_CODE);
}
vec3 three_of_code(float code) {
  int c = int(code) - LEAST_CODE;
  return rest_of(ivec3(c & 15, c >> 4 & 15, c >> 8), 16);
}
vec2 two_of_code(float code) {
  int c = int(code) - LEAST_CODE;
  vec3 rest = rest_of(ivec3(c & 63, c >> 6, 0), 64);
  return vec2(rest.x, rest.y);
}
