#version 450 core
// One invocation, one place of a vertex in the UV map → every descriptor asked for, from one sampling of its neighborhood (paper 4.1).
#include "interface.glsl"
#include "buffers.glsl"
#include "descriptors.glsl"
layout(local_size_x = GROUP_SIZE) in;
layout(std430, binding = BINDING_CENTERS) readonly restrict buffer Centers { CenterData centers[]; };
layout(std430, binding = BINDING_WINDOWS) readonly restrict buffer Windows { WindowData windows[]; };
layout(std430, binding = BINDING_SEARCH) readonly restrict buffer Searches { vec4 searches[]; };
layout(std430, binding = BINDING_RESULTS) writeonly restrict buffer Results { float results[]; };
layout(location = 2) uniform int first;
layout(location = 3) uniform int last;
layout(location = 4) uniform int total;
layout(location = 5) uniform int samples;
layout(location = 6) uniform float radius;
layout(location = 7) uniform float enlargement;
layout(location = 8) uniform int block_size;
layout(location = 9) uniform int seed;
layout(binding = UNIT_BLOCKS) uniform sampler2D blocks;

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
void add_texel(inout Sums sums, ivec2 texel, float cell) {
  vec4 point = texelFetch(positions, texel, 0);
  Neighbor neighbor;
  neighbor.offset = point.xyz - sums.center.position;
  neighbor.rho = length(neighbor.offset);
  neighbor.weight = point.w * cell;
  // A cell that the ball's rim cuts counts by the part of it that lies inside.
  neighbor.weight *= clamp((radius - neighbor.rho) * inversesqrt(max(neighbor.weight, 1e-20)) + 0.5, 0.0, 1.0);
  if (!(neighbor.weight > 0.0)) return;
  neighbor.normal = texelFetch(normals, texel, 0).xyz;
  neighbor.near = neighbor.rho * float(buffer_size) < sqrt(point.w);
  vec2 x = vec2(dot(neighbor.offset, sums.t1), dot(neighbor.offset, sums.t2)) / radius;
  vec2 y = vec2(dot(neighbor.normal, sums.t1), dot(neighbor.normal, sums.t2));
  neighbor.direction = x * inversesqrt(max(dot(x, x), 1e-12));
  sums.moments.area += neighbor.weight;
  sums.moments.xx += neighbor.weight * outer(x);
  sums.moments.xy += neighbor.weight * vec3(x.x * y.x, x.x * y.y + x.y * y.x, x.y * y.y);
  states_add(sums.states, sums.center, neighbor);
}

// Whether a block of texels, its low corner given, meets a window's box. With the block inside the box' bounds this is exact.
bool meets(WindowData window, vec2 low) {
  mat2 to_frame = inverse(frame_of(window));
  vec2 middle = to_frame * (low + 0.5 * float(block_size) - window.center_chart.xy);
  vec2 half_size = 0.5 * float(block_size) * (abs(to_frame[0]) + abs(to_frame[1]));
  return all(greaterThan(middle + half_size, window.box.xy)) && all(lessThan(middle - half_size, window.box.zw));
}

// Bounds of a window in blocks: low and high, inclusive.
ivec4 block_bounds(WindowData window) {
  mat2 frame = frame_of(window);
  vec2 middle = window.center_chart.xy + frame * (0.5 * (window.box.xy + window.box.zw));
  vec2 half_span = 0.5 * (window.box.zw - window.box.xy);
  vec2 reach = abs(frame[0]) * half_span.x + abs(frame[1]) * half_span.y;
  vec2 limit = vec2((buffer_size - 1) / block_size);
  return ivec4(clamp(floor((middle - reach) / float(block_size)), vec2(0.0), limit),
               clamp(floor((middle + reach) / float(block_size)), vec2(0.0), limit));
}

// A block that an earlier window on the same chart has sampled already.
bool seen_before(ivec2 block, int first_window, int window, float chart) {
  for (int k = first_window; k < window; ++k) {
    WindowData other = windows[k];
    if (other.center_chart.z != chart) continue;
    ivec4 bounds = block_bounds(other);
    if (all(greaterThanEqual(block, bounds.xy)) && all(lessThanEqual(block, bounds.zw)) && meets(other, vec2(block * block_size))) return true;
  }
  return false;
}

// A place in [0, 2^16)^2 that depends on the cell and the seed alone: every center takes the same texel of it.
ivec2 jitter(ivec2 cell) {
  uint h = uint(cell.x) * 0x8da6b343u ^ uint(cell.y) * 0xd8163841u ^ uint(seed) * 0xcb1ab31fu;
  h = (h ^ (h >> 16)) * 0x85ebca6bu;
  h = (h ^ (h >> 13)) * 0xc2b2ae35u;
  h ^= h >> 16;
  return ivec2(h & 0xffffu, h >> 16);
}

// Texels between the samples of a block: a power of two, so that blocks hold whole cells, and no cell is larger than the disk's.
int stride_of(ivec2 block) {
  float texel_area = texelFetch(blocks, block, 0).x / (float(buffer_size) * float(buffer_size));
  if (!(texel_area > 0.0)) return 0;
  float cell_area = PI * enlargement * enlargement * radius * radius / float(samples);
  return clamp(1 << int(floor(max(0.5 * log2(cell_area / texel_area), 0.0))), 1, block_size);
}

// Every block that a window meets, by one texel of each of its cells. Which texels those are depends on the surface and not on the center,
// so a vertex on a seam gets the same samples from each of its places in the UV map.
void sample_support(inout Sums sums, int index) {
  vec4 search = searches[index];
  sums.moments.lost = search.y;
  sums.moments.cut = search.z;
  float size = float(buffer_size);
  int base = index * MAX_WINDOWS;
  int iterations = 0;
  for (int k = base; k < base + int(search.x); ++k) {
    WindowData window = windows[k];
    int chart = int(window.center_chart.z);
    ivec4 bounds = block_bounds(window);
    int width = bounds.z - bounds.x + 1;
    int count = width * (bounds.w - bounds.y + 1);
    for (int j = 0; j < count; ++j) {
      ivec2 block = bounds.xy + ivec2(j % width, j / width);
      ++iterations;
      if (!meets(window, vec2(block * block_size)) || seen_before(block, base, k, window.center_chart.z)) continue;
      int stride = stride_of(block);
      if (stride == 0) continue;
      int side = block_size / stride;
      iterations += k - base + side * side;
      if (iterations > MAX_ITERATIONS) {
        sums.moments.lost += texelFetch(blocks, block, 0).x * float(block_size * block_size) / (size * size);
        continue;
      }
      float cell = float(stride * stride) / (size * size);
      for (int i = 0; i < side * side; ++i) {
        ivec2 low = block * block_size + ivec2(i % side, i / side) * stride;
        ivec2 texel = low + (jitter(low) & (stride - 1));
        if (any(greaterThanEqual(texel, ivec2(buffer_size)))) continue;
        ivec2 id = texelFetch(ids, texel, 0).xy;
        if (id.x == chart && id.y >= 0) add_texel(sums, texel, cell);
      }
    }
  }
}
void main() {
  int index = first + int(gl_GlobalInvocationID.x);
  if (index >= last) return;
  CenterData data = centers[index];
  Sums sums;
  sums.center = Center(data.position_chart.xyz, data.normal_phase.xyz, radius);
  tangents(sums.center.normal, sums.t1, sums.t2);
  sums.moments = Moments(0.0, vec3(0.0), vec3(0.0), 0.0, 0.0);
  states_init(sums.states);
  sample_support(sums, index);

  Moments m = sums.moments;
  Center center = sums.center;
  States states = sums.states;
  Support support = finish_support(m);
  results[ROW_COVERAGE * total + index] = m.area > 0.0 ? m.area / (m.area + m.lost) : 0.0;
  results[ROW_FLAGS * total + index] = m.cut > 0.0 ? 1.0 : 0.0;
  STATES_FINISH
}
