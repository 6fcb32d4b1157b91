// Samples in lanes, relative to a center, and the parts of them within a ball. It is compiled for each instruction set, as
// KERNEL_TARGET.
#pragma once

#include <cstddef>

#include "engine/cpu/add_samples.h"
#include "engine/kernels/lane_memory.h"

namespace paradesc::kernels {
inline namespace KERNEL_TARGET {

constexpr float root2 = 1.41421356f, root6 = 2.44948974f;

// Samples relative to the center.
struct Seen {
  Vector<3, Lanes> offset, along[2], normal, normal_along[2], face;
  Lanes area, per_area, noise, facet;
  Choices is_cluster;

  [[gnu::always_inline]] Seen(const FlatSample *const *samples, const Vector<3, Lanes> &center) {
    const Vector<4, Lanes> position = gather<offsetof(FlatSample, position)>(samples);
    offset = first3(position) - center;
    area = position.w;
    per_area = 1.0f / max(area, 1e-30f);
    const Vector<4, Lanes> with_kind = gather<offsetof(FlatSample, normal)>(samples);
    normal = first3(with_kind);
    is_cluster = with_kind.w > 0.0f;
    along[0] = first3(gather<offsetof(FlatSample, along[0])>(samples));
    along[1] = first3(gather<offsetof(FlatSample, along[1])>(samples));
    normal_along[0] = first3(gather<offsetof(FlatSample, normal_along[0])>(samples));
    normal_along[1] = first3(gather<offsetof(FlatSample, normal_along[1])>(samples));
    face = first3(gather<offsetof(FlatSample, face)>(samples));
    const Vector<4, Lanes> of_triangle = gather<offsetof(FlatSample, noise)>(samples);
    noise = of_triangle.x;
    facet = of_triangle.y;
  }

  Vector<3, Lanes> at(const Lanes *place) const { return offset + along[0] * place[0] + along[1] * place[1]; }
  Vector<3, Lanes> normal_at(const Lanes *place) const {
    return normal + normal_along[0] * place[0] + normal_along[1] * place[1];
  }
  Lanes spread() const { return square_of(along[0]) + square_of(along[1]); }
  // Returns one over the radius of the circle in which the ball of this radius meets the sample's plane.
  Lanes per_radius_of_arc(float radius) const {
    constexpr float least = 1e-4f;
    const Lanes height = dot(offset, face);
    return fast_inversesqrt(max(radius * radius - height * height, least * radius * radius));
  }
};

// The corners of a sample, as coefficients of its two directions.
constexpr float corner_place[3][2] = {{-2.0f * root2, 0.0f}, {root2, root6}, {root2, -root6}};
// Four places over which a quadratic has the mean that it has over the sample.
constexpr float four_places[4][2] = {{-1.0f, -1.0f}, {-1.0f, 1.0f}, {1.0f, -1.0f}, {1.0f, 1.0f}};
inline void find_corners(const Vector<3, Lanes> &mean, const Vector<3, Lanes> *along, Vector<3, Lanes> *corners) {
  const Vector<3, Lanes> first = along[0] * root2, second = along[1] * root6, middle = mean + first;
  corners[0] = mean - first * 2.0f;
  corners[1] = middle + second;
  corners[2] = middle - second;
}

// Squared distances.
struct Distances {
  Lanes corner[3]; // of the corners from the center
  Lanes edge[3];   // between corners 0 and 1, 1 and 2, 2 and 0
};

// The part of each sample that lies in a ball.
struct Part {
  Lanes area;
  Lanes place[2];       // its mean position, as coefficients of the sample's directions
  Lanes chord;          // squared length between the points where the rim meets the sample's edges; 0 if it does not
  Lanes chord_place[2]; // the middle of the chord
};

// Returns the part of a cluster in the ball. Its outline is unknown, so its area is taken to vary along the distance from the
// center as that of a disk does, approximately, with the distance's mean and variance. to_mean, distance: of the mean position
// and of the corners, whose variance is four times that of the cluster.
inline Part clip_cluster(const Seen &seen, const Lanes &to_mean, const Lanes (&distance)[3], float radius) {
  constexpr float per_squares = 1.0f / 12.0f; // the sum of the corners' squared coefficients along each direction
  const Lanes mean = 0.75f * to_mean + 0.25f * (distance[0] + distance[1] + distance[2]) * (1.0f / 3.0f);
  const Lanes slope[2] = {(distance[1] + distance[2] - 2.0f * distance[0]) * (root2 * per_squares),
                          (distance[1] - distance[2]) * (root6 * per_squares)};
  const Lanes per_deviation = fast_inversesqrt(max(slope[0] * slope[0] + slope[1] * slope[1], 1e-24f));
  constexpr float width = 2.236068f, per_width = 1.0f / width;
  const Lanes at = max(min((radius - mean) * per_deviation * per_width, 1.0f), -1.0f), rest = 1.0f - at * at;
  const Lanes share = 0.5f + at * (0.75f - 0.25f * at * at), moment = (-0.1875f * width) * rest * rest;
  const Lanes per_share = fast_inversesqrt(max(share, 1e-12f)), inner = moment * per_share * per_share * per_deviation;
  Part part;
  part.area = seen.area * share;
  // The distance grows more slowly across the rim where the surface leans.
  const Lanes height = dot(seen.offset, seen.face),
              flat = max(1.0f - height * height / max(square_of(seen.offset), 1e-30f), 0.0f);
  const Lanes chord = seen.area * (0.75f * per_width) * rest * per_deviation * fast_sqrt(flat);
  part.chord = chord * chord;
  for (int k = 0; k < 2; ++k) {
    part.place[k] = inner * slope[k];
    part.chord_place[k] = at * width * per_deviation * slope[k];
  }
  return part;
}

inline Part mix(const Part &a, const Part &b, const Choices &choice) {
  const auto choose = [&](const Lanes &of_a, const Lanes &of_b) { return mix(of_a, of_b, choice); };
  return {choose(a.area, b.area),
          {choose(a.place[0], b.place[0]), choose(a.place[1], b.place[1])},
          choose(a.chord, b.chord),
          {choose(a.chord_place[0], b.chord_place[0]), choose(a.chord_place[1], b.chord_place[1])}};
}

// Finds the point where the edge from one corner to another meets the rim, as the fraction above / below. beyond: how far the
// squared distances of both corners are below that of the rim. The squared distance along the edge is quadratic.
inline void meet_rim(const Lanes &beyond, const Lanes &other_beyond, const Lanes &edge, Lanes &above, Lanes &below) {
  const Lanes slope = other_beyond - beyond + edge;
  const Lanes root = fast_sqrt(max(slope * slope + 4.0f * edge * beyond, 0.0f));
  above = 2.0f * max(beyond, -1.0f * beyond);
  below = max(root + mix(slope, -1.0f * slope, beyond > 0.0f), 1e-18f);
}

// Finds the part of a triangle in the ball. It is the triangle without, or only, the part at the corner that is alone on its side
// of the rim. The part is bounded by two edges and by an arc beyond its chord. inside: how far the squared distances of the
// corners are below that of the rim. edge: as in Distances. per_radius: one over the arc's radius.
[[gnu::always_inline]] inline Part clip(const Seen &seen, const Lanes *inside, const Lanes *edge, const Lanes &per_radius) {
  const Choices in0 = inside[0] > 0.0f, in1 = inside[1] > 0.0f, in2 = inside[2] > 0.0f;
  const Choices alone1 = (in0 != in1) && (in1 != in2), alone2 = (in1 != in2) && (in2 != in0);
  const auto choose = [&](const Lanes &of0, const Lanes &of1, const Lanes &of2) {
    return mix(mix(of0, of1, alone1), of2, alone2);
  };
  const Lanes alone = choose(inside[0], inside[1], inside[2]), next = choose(inside[1], inside[2], inside[0]),
              previous = choose(inside[2], inside[0], inside[1]);
  const Lanes to_next = choose(edge[0], edge[1], edge[2]), to_previous = choose(edge[2], edge[0], edge[1]),
              opposite = choose(edge[1], edge[2], edge[0]);
  Lanes above_next, below_next, above_previous, below_previous;
  meet_rim(alone, next, to_next, above_next, below_next);
  meet_rim(alone, previous, to_previous, above_previous, below_previous);
  const Lanes root = fast_inversesqrt(max(below_next * below_previous, 1e-36f)), reciprocal = root * root;
  const Lanes p = min(above_next * below_previous * reciprocal, 1.0f), q = min(above_previous * below_next * reciprocal, 1.0f);
  const Lanes chord = p * p * to_next + q * q * to_previous - p * q * (to_next + to_previous - opposite);
  const Lanes corner = seen.area * p * q, arc = min(max(chord, 0.0f) * fast_sqrt(chord) * (1.0f / 12.0f) * per_radius, seen.area);
  const Choices only_corner = alone > 0.0f, cut = (in0 != in1) || (in1 != in2);
  const Lanes sign = mix(-1.0f, 1.0f, only_corner);
  // Areas are distributed to corners: that of the corner triangle by thirds, that of the arc by halves to the ends of its chord.
  const Lanes third = sign * corner * (1.0f / 3.0f), half = arc * 0.5f;
  const Lanes all = mix(seen.area, 0.0f, only_corner);
  const Lanes at_next = p * (third + half), at_previous = q * (third + half);
  const Lanes at_alone = 3.0f * third + arc - at_next - at_previous;
  const Lanes at0 = choose(at_alone, at_previous, at_next), at1 = choose(at_next, at_alone, at_previous),
              at2 = choose(at_previous, at_next, at_alone);
  Part part;
  part.area = mix(mix(0.0f, seen.area, in0), max(all + 3.0f * third + arc, 0.0f), cut);
  const Lanes root_area = fast_inversesqrt(max(part.area, 1e-30f)), per_area = mix(0.0f, root_area * root_area, cut);
  part.place[0] = (root2 * (at1 + at2) - 2.0f * root2 * at0) * per_area;
  part.place[1] = root6 * (at1 - at2) * per_area;
  const Lanes half_next = p * 0.5f, half_previous = q * 0.5f, rest = 1.0f - half_next - half_previous;
  const Lanes m1 = choose(half_next, rest, half_previous), m2 = choose(half_previous, half_next, rest);
  part.chord = mix(0.0f, max(chord, 0.0f), cut && seen.area > 0.0f);
  part.chord_place[0] = root2 * (3.0f * (m1 + m2) - 2.0f); // their sum is 1
  part.chord_place[1] = root6 * (m1 - m2);
  return part;
}

} // namespace KERNEL_TARGET
} // namespace paradesc::kernels
