// The triangles that the ball of one center cuts → their contribution to its sums beyond the triangles that count as wholes. It
// is compiled for each instruction set, as KERNEL_TARGET.
#pragma once

#include <cstddef>
#include <limits>
#include <utility>

#include "engine/cpu/ball_sums.h"
#include "engine/kernels/lane_memory.h"

namespace paradesc::kernels {
inline namespace KERNEL_TARGET {

// A center, broadcast to all lanes.
struct RimCenter {
  Vector<3, Lanes> position, t1, t2;
  float square; // of the radius
};

struct RimSums {
  Lanes area, xx[3], xn[3], facets, noise; // xx, xy, yy; x m, x o + y m, y o of normals (m, o)
};

// A vector in the tangent plane.
struct Flat {
  Lanes u, v;
};
inline Flat flat(const RimCenter &center, const Vector<3, Lanes> &v) { return {dot(v, center.t1), dot(v, center.t2)}; }
inline Flat operator+(const Flat &a, const Flat &b) { return {a.u + b.u, a.v + b.v}; }
inline Flat operator-(const Flat &a, const Flat &b) { return {a.u - b.u, a.v - b.v}; }
inline Flat operator*(const Lanes &s, const Flat &a) { return {s * a.u, s * a.v}; }

// Adds the products of a position with itself and with a normal, weighted by an area.
inline void add_products(const Lanes &area, const Flat &x, const Flat &n, RimSums &sums) {
  const Lanes u = area * x.u, v = area * x.v;
  sums.xx[0] += u * x.u;
  sums.xx[1] += u * x.v;
  sums.xx[2] += v * x.v;
  sums.xn[0] += u * n.u;
  sums.xn[1] += u * n.v + v * n.u;
  sums.xn[2] += v * n.v;
}

using SignBits = Choices::Bits;
// Flips the signs of the floats whose sign bit is set in `signs`.
inline Lanes turn_sign(const Lanes &a, const SignBits &signs) {
  return Lanes(std::bit_cast<Lanes::Floats>(std::bit_cast<SignBits>(a.lane) ^ signs));
}

// The points where the edges at the alone corner meet the rim, and the area between the chord and the arc. The alone corner is
// the only one on its side of the rim.
struct Cut {
  SignBits outside; // sign bits: set if the alone corner is outside
  Lanes p, q;       // fractions of the edges to the next corner and to the previous one
  Lanes arc;        // area between chord and arc
  Lanes angle;      // squared angle of the arc, approximately: chord over radius
};

// to: the edges from the alone corner to the next corner and to the previous one.
inline Cut cut_of(const RimCenter &center, const Vector<3, Lanes> &alone, const Vector<3, Lanes> (&to)[2], const Lanes &area,
                  const Lanes &per_twice_area) {
  const Lanes beyond = square_of(alone) - center.square;
  const SignBits bits = std::bit_cast<SignBits>(beyond.lane), sign = SignBits{} + std::numeric_limits<int32_t>::min();
  Cut cut;
  cut.outside = ~bits & sign;
  const Lanes above(std::bit_cast<Lanes::Floats>(bits & ~sign));
  // Along an edge, the squared distance minus that of the rim is beyond + 2 slope t + square t^2. Its first root is above /
  // below.
  const auto below = [&](const Lanes &slope, const Lanes &square) {
    const Lanes root = max(slope * slope - square * beyond, 1e-30f);
    return max(root * fast_inversesqrt(root) + turn_sign(slope, cut.outside), 1e-18f);
  };
  const Lanes next = square_of(to[0]), previous = square_of(to[1]), between = dot(to[0], to[1]);
  const Lanes below_next = below(dot(alone, to[0]), next), below_previous = below(dot(alone, to[1]), previous);
  const Lanes share = above / (below_next * below_previous);
  cut.p = min(share * below_previous, 1.0f);
  cut.q = min(share * below_next, 1.0f);
  const Lanes chord = max(cut.p * (cut.p * next - 2.0f * cut.q * between) + cut.q * cut.q * previous, 1e-30f);
  constexpr float least = 1e-4f; // minimum of the arc's squared radius, relative to the ball's
  const Lanes height = dot(alone, cross(to[0], to[1])) * per_twice_area;
  const Lanes arc_square = max(center.square - height * height, least * center.square);
  const Lanes per_radius = chord * fast_inversesqrt(chord * arc_square); // one over the arc's radius, times the chord
  cut.angle = per_radius * per_radius;
  cut.arc = min(chord * per_radius * (1.0f / 12.0f) * (1.0f + cut.angle * (0.075f + 0.01f * cut.angle)), area); // by a series
  return cut;
}

// The normals of a triangle, interpolated linearly between unit normals at the corners and then normalized. The squared length of
// an interpolated normal falls by the product of two weights times the squared distance of their normals.
struct TurningNormals {
  Flat alone, to_next, to_previous;
  Lanes next, previous, across; // squared distances: alone to next, alone to previous, next to previous

  TurningNormals(const RimCenter &center, const Vector<3, Lanes> (&normal)[3]) {
    const Vector<3, Lanes> first = normal[1] - normal[0], second = normal[2] - normal[0];
    alone = flat(center, normal[0]);
    to_next = flat(center, first);
    to_previous = flat(center, second);
    next = square_of(first);
    previous = square_of(second);
    across = square_of(first - second);
  }
  // Returns the normal at a place, by weights of the next corner and of the previous one.
  Flat at(const Lanes &b, const Lanes &c) const {
    const Lanes loss = (1.0f - b - c) * (b * next + c * previous) + b * c * across;
    return fast_inversesqrt(max(1.0f - loss, 1e-6f)) * (alone + b * to_next + c * to_previous);
  }
};

// Adds the triangle at the alone corner by the edge midpoints of the four triangles that its own edge midpoints cut it into.
inline void add_turning_corner(const Lanes &area, const Flat &x, const Flat &to_p, const Flat &to_q, const Cut &cut,
                               const TurningNormals &normals, RimSums &sums) {
  const auto add = [&](float share, float of_p, float of_q) {
    const Lanes b = of_p * cut.p, c = of_q * cut.q;
    add_products(share * area, x + Lanes(of_p) * to_p + Lanes(of_q) * to_q, normals.at(b, c), sums);
  };
  constexpr float inner = 1.0f / 6.0f, outer = 1.0f / 12.0f;
  for (const auto &[of_p, of_q] : {std::pair{0.25f, 0.25f}, {0.5f, 0.25f}, {0.25f, 0.5f}}) add(inner, of_p, of_q);
  for (const float near : {0.25f, 0.75f}) {
    add(outer, near, 0.0f);
    add(outer, 0.0f, near);
    add(outer, near, 1.0f - near);
  }
}

// Adds at most one vector of lanes. bases: alone corners in RimTriangles.
template <bool turning, bool with_noise>
[[gnu::always_inline]] inline void add_rim_lanes(const RimCenter &center, const float *const *bases, const float *areas,
                                                 const float *per_twice_areas, const float *noises, RimSums &sums) {
  constexpr size_t next = 3 * sizeof(float), previous = 6 * sizeof(float), normal = offsetof(RimTriangle, normal);
  const Lanes area = load(areas);
  const Vector<3, Lanes> corner = first3(gather<0>(bases));
  const Vector<3, Lanes> to[2] = {first3(gather<next>(bases)) - corner, first3(gather<previous>(bases)) - corner};
  const Vector<3, Lanes> alone = corner - center.position;
  const Cut cut = cut_of(center, alone, to, area, load(per_twice_areas));
  const Lanes third = area * cut.p * cut.q * (1.0f / 3.0f), of_corner = turn_sign(third, cut.outside);
  const Lanes half_p = 0.5f * cut.p, half_q = 0.5f * cut.q;
  const Flat x = flat(center, alone), along_p = half_p * flat(center, to[0]), along_q = half_q * flat(center, to[1]);
  const Vector<3, Lanes> normals[3] = {first3(gather<normal>(bases)), first3(gather<normal + next>(bases)),
                                       first3(gather<normal + previous>(bases))};
  const Lanes arc = cut.arc * (1.0f + 0.1f * cut.angle);
  const Flat chord_middle = x + along_p + along_q;
  // The mean of a quadratic over a triangle is the mean of its values at the edge midpoints. The segment between chord and arc
  // has its centroid beyond the middle of the chord, by two fifths of the arc's height. Its variance along the chord is a
  // twentieth of the chord's square.
  if constexpr (turning) {
    const TurningNormals normal_of(center, normals);
    add_turning_corner(3.0f * of_corner, x, along_p + along_p, along_q + along_q, cut, normal_of, sums);
    add_products(arc, chord_middle, normal_of.at(half_p, half_q), sums);
    add_products(cut.arc * 0.2f, along_q - along_p, half_q * normal_of.to_previous - half_p * normal_of.to_next, sums);
  } else {
    const Flat n = flat(center, normals[0]), turn_p = half_p * (flat(center, normals[1]) - n),
               turn_q = half_q * (flat(center, normals[2]) - n);
    add_products(of_corner, x + along_p, n + turn_p, sums);
    add_products(of_corner, x + along_q, n + turn_q, sums);
    add_products(of_corner + arc, chord_middle, n + turn_p + turn_q, sums);
    add_products(cut.arc * 0.2f, along_q - along_p, turn_q - turn_p, sums);
  }
  const Lanes part = 3.0f * of_corner + cut.arc;
  sums.area += part;
  if constexpr (with_noise) {
    sums.facets += part * area;
    sums.noise += part * load(noises);
  }
}

// corners: as in GroupLists, with room to fill up the last lanes.
template <bool turning, bool with_noise>
void add_rim(const PatchArrays &surface, const RimCenter &center, int32_t *corners, int32_t count, float (&to)[ball_sums]) {
  constexpr int32_t row = sizeof(RimTriangle) / sizeof(float), parts = group_lanes / lane_count;
  const float *const rims = surface.rim[0].corner[0];
  const int32_t last = (count + lane_count - 1) / lane_count * lane_count;
  for (int32_t i = count; i < last; ++i) corners[i] = row * surface.triangles; // the zero triangle
  RimSums sums[parts];
  for (RimSums &of_part : sums) of_part = RimSums{0.0f, {0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f}, 0.0f, 0.0f};
  for (int32_t i = 0; i < last; i += lane_count) {
    for (int lane = 0; lane < lane_count && i + lane_count < last; ++lane) { // prefetches the next ones
      __builtin_prefetch(rims + static_cast<uint32_t>(corners[i + lane_count + lane]) / row * row);
      __builtin_prefetch(rims + static_cast<uint32_t>(corners[i + lane_count + lane]) / row * row + row / 2);
    }
    const float *bases[lane_count];
    alignas(64) float areas[lane_count], per_twice_areas[lane_count], noises[lane_count];
    for (int lane = 0; lane < lane_count; ++lane) {
      const auto corner = static_cast<uint32_t>(corners[i + lane]);
      const float *const triangle = rims + corner / row * row;
      bases[lane] = rims + corner;
      areas[lane] = triangle[offsetof(RimTriangle, area) / sizeof(float)];
      per_twice_areas[lane] = triangle[offsetof(RimTriangle, per_twice_area) / sizeof(float)];
      if constexpr (with_noise) noises[lane] = surface.noise[corner / row];
    }
    add_rim_lanes<turning, with_noise>(center, bases, areas, per_twice_areas, noises, sums[i / lane_count % parts]);
  }
  const auto fold_all = [&](auto member) {
    Lanes lanes[parts];
    for (int32_t i = 0; i < parts; ++i) lanes[i] = member(sums[i]);
    return fold_lanes(lanes);
  };
  to[0] = fold_all([](const RimSums &s) { return s.area; });
  for (int k = 0; k < 3; ++k) {
    to[1 + k] = fold_all([k](const RimSums &s) { return s.xx[k]; });
    to[4 + k] = fold_all([k](const RimSums &s) { return s.xn[k]; });
  }
  to[7] = with_noise ? fold_all([](const RimSums &s) { return s.facets; }) : 0.0f;
  to[8] = with_noise ? fold_all([](const RimSums &s) { return s.noise; }) : 0.0f;
}

} // namespace KERNEL_TARGET
} // namespace paradesc::kernels
