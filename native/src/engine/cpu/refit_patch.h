// The current corners of a batch's triangles → bounding spheres of its patches, moments of the triangles, and the data that the
// rim needs. It is compiled for each instruction set, as KERNEL_TARGET.
#pragma once

#include <algorithm>

#include "engine/cpu/ball_sums.h"
#include "engine/cpu/nine_places.h"
#include "engine/kernels/lane_memory.h"

namespace paradesc::kernels {
inline namespace KERNEL_TARGET {

// ---- The sphere

// Finds the middle of the bounding box of the positions of a patch's nodes.
inline void find_middle(const PatchArrays &surface, int32_t patch, float *middle) {
  for (int axis = 0; axis < 3; ++axis) {
    const float *const position = surface.position[axis];
    float low = position[surface.patch_begin[patch]], high = low;
    for (int32_t node = surface.patch_begin[patch] + 1; node < surface.patch_begin[patch + 1]; ++node) {
      low = std::min(low, position[node]);
      high = std::max(high, position[node]);
    }
    middle[axis] = 0.5f * (low + high);
  }
}

inline float square_from(const PatchArrays &surface, int32_t node, const float *middle) {
  float sum = 0.0f;
  for (int axis = 0; axis < 3; ++axis) {
    const float gap = surface.position[axis][node] - middle[axis];
    sum += gap * gap;
  }
  return sum;
}

// Finds the distances from the middle to the patch's nodes and to all corners of its triangles, plus a margin for rounding.
inline void find_reach(const PatchArrays &surface, int32_t patch, const float *middle) {
  constexpr float rounding = 1.00001f;
  float own = 0.0f;
  for (int32_t node = surface.patch_begin[patch]; node < surface.patch_begin[patch + 1]; ++node)
    own = std::max(own, std::sqrt(square_from(surface, node, middle)) + surface.node_reach[node]);
  float all = own * own;
  for (int32_t k = 3 * surface.triangle_begin[patch]; k < 3 * surface.triangle_begin[patch + 1]; ++k)
    all = std::max(all, square_from(surface, surface.corner[k], middle));
  for (int axis = 0; axis < 3; ++axis) surface.sphere[axis][patch] = middle[axis];
  surface.sphere[3][patch] = rounding * std::sqrt(all);
  surface.own_reach[patch] = rounding * own;
}

// Returns whether a triangle of the patch has an edge that is long against the radius.
inline bool has_long_edge(const PatchArrays &surface, int32_t patch) {
  if (2.0f * surface.sphere[3][patch] < surface.large) return false;
  const float least = surface.large * surface.large;
  for (int32_t t = surface.triangle_begin[patch]; t < surface.triangle_begin[patch + 1]; ++t)
    for (int k = 0; k < 3; ++k) {
      const int32_t to = surface.corner[3 * t + (k + 1) % 3];
      const float end[3] = {surface.position[0][to], surface.position[1][to], surface.position[2][to]};
      if (square_from(surface, surface.corner[3 * t + k], end) >= least) return true;
    }
  return false;
}

// ---- The triangles

constexpr float turning_square = 0.1f; // 18 degrees

// Sixteen triangles. The last ones may be unused.
struct alignas(64) RefitBlock {
  float corner[3][3][group_lanes], normal[3][3][group_lanes];               // corners relative to the patch's origin
  float noise[group_lanes], per_twice_area[group_lanes], turn[group_lanes]; // turn: squared, between normals
  float moment[moments][group_lanes];
};

// normals: at the corners of these triangles.
inline void read_block(const PatchArrays &surface, const float *origin, int32_t first, int32_t count, const float *normals,
                       RefitBlock &block) {
  if (count < group_lanes) block = {};
  for (int32_t i = 0; i < count; ++i) {
    for (int k = 0; k < 3; ++k)
      for (int axis = 0; axis < 3; ++axis) {
        block.corner[k][axis][i] = surface.position[axis][surface.corner[3 * (first + i) + k]] - origin[axis];
        block.normal[k][axis][i] = normals[9 * i + 3 * k + axis];
      }
    block.noise[i] = surface.noise[first + i];
  }
}

// Returns the largest squared distance between the normals at the corners.
inline Lanes farthest_square(const Lanes (&normal)[3][3]) {
  Lanes farthest = 0.0f;
  for (int k = 0; k < 3; ++k) {
    Lanes square = 0.0f;
    for (int axis = 0; axis < 3; ++axis) {
      const Lanes gap = normal[(k + 1) % 3][axis] - normal[k][axis];
      square += gap * gap;
    }
    farthest = max(farthest, square);
  }
  return farthest;
}

// Replaces the normals at the corners such that linear interpolation has the unit normals at the edge midpoints. Between two
// opposite normals, the first one is used.
inline void straighten(Lanes (&normal)[3][3]) {
  Lanes middle[3][3]; // between corners k and k + 1
  for (int k = 0; k < 3; ++k) {
    Lanes square = 0.0f;
    for (int axis = 0; axis < 3; ++axis) {
      middle[k][axis] = normal[k][axis] + normal[(k + 1) % 3][axis];
      square += middle[k][axis] * middle[k][axis];
    }
    const Choices opposed = square < 1e-12f;
    const Lanes root = fast_inversesqrt(max(square, 1e-12f));
    for (int axis = 0; axis < 3; ++axis) middle[k][axis] = mix(middle[k][axis] * root, normal[k][axis], opposed);
  }
  for (int axis = 0; axis < 3; ++axis)
    for (int k = 0; k < 3; ++k) normal[k][axis] = middle[k][axis] + middle[(k + 2) % 3][axis] - middle[(k + 1) % 3][axis];
}

// The moments of normals, interpolated linearly between unit normals at corners and then normalized: means of n and of x n over a
// triangle.
struct NormalMoments {
  Lanes n[3], xn[6];
};
inline NormalMoments turning_moments(const Lanes (&x)[4][3], const Lanes (&normal)[3][3]) {
  NormalMoments sums{};
  for (const auto &[weight, twelfths] : nine_places) {
    Lanes n[3], at[3], square = 0.0f;
    for (int axis = 0; axis < 3; ++axis) {
      n[axis] = weight[0] * normal[0][axis] + weight[1] * normal[1][axis] + weight[2] * normal[2][axis];
      at[axis] = weight[0] * x[0][axis] + weight[1] * x[1][axis] + weight[2] * x[2][axis];
      square += n[axis] * n[axis];
    }
    const Lanes scale = (twelfths / 12.0f) * fast_inversesqrt(max(square, 1e-12f));
    for (Lanes &component : n) component = component * scale;
    for (int axis = 0; axis < 3; ++axis) {
      const int i = axis == 2 ? 1 : 0, k = axis == 0 ? 1 : 2; // xy, xz, yz
      sums.n[axis] += n[axis];
      sums.xn[axis] += at[axis] * n[axis];
      sums.xn[3 + axis] += at[i] * n[k] + at[k] * n[i];
    }
  }
  return sums;
}

// Triangles that are large, the more so where normals turn, get zeros: the rim takes normals for linear. The second moments of a
// triangle are a twelfth of its area times the products of its corners plus those of the corners' sum.
inline void find_moments(RefitBlock &block, float large, int first) {
  constexpr float finer = 0.5f;
  Lanes x[4][3], n[4][3]; // at the corners, and their sums
  for (int axis = 0; axis < 3; ++axis) {
    for (int k = 0; k < 3; ++k) x[k][axis] = load(block.corner[k][axis] + first);
    x[3][axis] = x[0][axis] + x[1][axis] + x[2][axis];
  }
  Lanes normal[3][3];
  for (int k = 0; k < 3; ++k)
    for (int axis = 0; axis < 3; ++axis) normal[k][axis] = load(block.normal[k][axis] + first);
  const Lanes turn = farthest_square(normal);
  const Choices is_turning = turn > turning_square;
  NormalMoments turning;
  const bool any_turns = any(is_turning);
  if (any_turns) turning = turning_moments(x, normal);
  store(block.turn + first, turn);
  Lanes unit[3][3];
  for (int k = 0; k < 3; ++k)
    for (int axis = 0; axis < 3; ++axis) unit[k][axis] = normal[k][axis];
  straighten(normal);
  for (int axis = 0; axis < 3; ++axis) {
    for (int k = 0; k < 3; ++k) {
      n[k][axis] = normal[k][axis];
      store(block.normal[k][axis] + first, mix(normal[k][axis], unit[k][axis], is_turning));
    }
    n[3][axis] = n[0][axis] + n[1][axis] + n[2][axis];
  }
  const auto side = [&](int k) { return Vector<3, Lanes>(x[k][0] - x[0][0], x[k][1] - x[0][1], x[k][2] - x[0][2]); };
  const Vector<3, Lanes> to_next = side(1), to_previous = side(2);
  const Lanes longest = max(max(square_of(to_next), square_of(to_previous)), square_of(to_next - to_previous));
  const Lanes square = square_of(cross(to_next, to_previous));
  const Lanes root = mix(0.0f, fast_inversesqrt(max(square, 1e-36f)),
                         longest * (1.0f + finer * max(turn - turning_square, 0.0f)) < large * large);
  const Lanes area = 0.5f * square * root, third = area * (1.0f / 3.0f), twelfth = area * (1.0f / 12.0f);
  const auto put = [&](int moment, const Lanes &value) { store(block.moment[moment] + first, value); };
  const auto product = [&](const Lanes(&a)[4][3], int i, const Lanes(&b)[4][3], int k) {
    return twelfth * (a[0][i] * b[0][k] + a[1][i] * b[1][k] + a[2][i] * b[2][k] + a[3][i] * b[3][k]);
  };
  store(block.per_twice_area + first, root);
  put(moment_area, area);
  for (int axis = 0; axis < 3; ++axis) {
    const int i = axis == 2 ? 1 : 0, k = axis == 0 ? 1 : 2; // xy, xz, yz
    put(moment_x + axis, third * x[3][axis]);
    put(moment_n + axis, third * n[3][axis]);
    put(moment_xx + axis, product(x, axis, x, axis));
    put(moment_xx + 3 + axis, product(x, i, x, k));
    put(moment_xn + axis, product(x, axis, n, axis));
    put(moment_xn + 3 + axis, product(x, i, n, k) + product(x, k, n, i));
  }
  const auto put_turning = [&](int moment, const Lanes &mean) {
    put(moment, mix(load(block.moment[moment] + first), area * mean, is_turning));
  };
  for (int k = 0; any_turns && k < 6; ++k) {
    if (k < 3) put_turning(moment_n + k, turning.n[k]);
    put_turning(moment_xn + k, turning.xn[k]);
  }
  put(moment_facet, area * area);
  put(moment_noise, area * load(block.noise + first));
}

inline void write_triangle(const PatchArrays &surface, int32_t triangle, const RefitBlock &block, int32_t i, MomentRow &patch) {
  MomentRow &row = surface.moment[triangle];
  for (int k = 0; k < moment_row; ++k) row.of[k] = k < moments ? block.moment[k][i] : 0.0f;
  for (int k = 0; k < moment_row; ++k) patch.of[k] += row.of[k];
  RimTriangle &rim = surface.rim[triangle];
  for (int k = 0; k < 5; ++k)
    for (int axis = 0; axis < 3; ++axis) {
      rim.corner[k][axis] = surface.position[axis][surface.corner[3 * triangle + k % 3]];
      rim.normal[k][axis] = block.normal[k % 3][axis][i];
    }
  rim.area = block.moment[moment_area][i];
  rim.per_twice_area = block.per_twice_area[i];
  surface.turning[triangle] = block.turn[i] > turning_square ? -1 : 0;
}

inline void refit_triangles(const PatchArrays &surface, int32_t patch, const float *normals) {
  const float origin[3] = {surface.origin[0][patch], surface.origin[1][patch], surface.origin[2][patch]};
  MomentRow of_patch = {};
  RefitBlock block;
  surface.has_listed[patch] = 0;
  for (int32_t first = surface.triangle_begin[patch]; first < surface.triangle_begin[patch + 1]; first += group_lanes) {
    const int32_t count = std::min<int32_t>(group_lanes, surface.triangle_begin[patch + 1] - first);
    read_block(surface, origin, first, count, normals + 9 * (first - surface.triangle_begin[patch]), block);
    for (int lane = 0; lane < group_lanes; lane += lane_count) find_moments(block, surface.large, lane);
    for (int32_t i = 0; i < count; ++i) {
      write_triangle(surface, first + i, block, i, of_patch);
      if (!(block.moment[moment_area][i] > 0.0f)) surface.has_listed[patch] = 1;
    }
  }
  surface.moment[surface.row_of_patch(patch)] = of_patch;
}

// Moments about a distant origin lose digits. The batch's common origin is used if the patches extend over few patch sizes.
inline void find_origins(const PatchArrays &surface, int32_t first, int32_t last) {
  constexpr float near = 8.0f;
  float largest = 0.0f, square = 0.0f, middle[3];
  for (int32_t patch = first; patch < last; ++patch)
    largest = std::max(largest, std::min(surface.sphere[3][patch], surface.large));
  for (int axis = 0; axis < 3; ++axis) {
    const auto [low, high] = std::minmax_element(surface.sphere[axis] + first, surface.sphere[axis] + last);
    middle[axis] = 0.5f * (*low + *high);
    square += 0.25f * (*high - *low) * (*high - *low);
  }
  const bool apart = !(square <= near * near * largest * largest);
  surface.apart[first / group_lanes] = apart;
  for (int32_t patch = first; patch < last; ++patch)
    for (int axis = 0; axis < 3; ++axis) surface.origin[axis][patch] = apart ? surface.sphere[axis][patch] : middle[axis];
}

inline void refit_spheres(const PatchArrays &surface, int32_t batch) {
  const int32_t first = group_lanes * batch, last = std::min(first + group_lanes, surface.patches);
  for (int32_t patch = first; patch < last; ++patch) {
    float middle[3];
    find_middle(surface, patch, middle);
    find_reach(surface, patch, middle);
    surface.has_long_edge[patch] = has_long_edge(surface, patch);
  }
}

inline void refit(const PatchArrays &surface, int32_t batch, const float *normals) {
  refit_spheres(surface, batch);
  const int32_t first = group_lanes * batch, last = std::min(first + group_lanes, surface.patches);
  find_origins(surface, first, last);
  for (int32_t patch = first; patch < last; ++patch)
    refit_triangles(surface, patch, normals + 9 * (surface.triangle_begin[patch] - surface.triangle_begin[first]));
}

} // namespace KERNEL_TARGET
} // namespace paradesc::kernels
