// The sums for one instruction set. This file is compiled once for each, with LANE_WIDTH lanes and under the name KERNEL_TARGET.
#include "engine/creases/face_sums.h"

#include <cstddef>

#include "engine/creases/lane_functions.h"
#include "engine/kernels/lane_memory.h"
#include "kernel/limits.h"
#include "support/targets.h"

namespace paradesc::kernels {
inline namespace KERNEL_TARGET {

namespace {

using Place = Vector<3, Lanes>;

Lanes only(const Choices &where, const Lanes &value) { return mix(0.0f, value, where); }

// A symmetric tensor in the tangent plane of the center.
struct Tensor {
  Lanes xx = 0.0f, xy = 0.0f, yy = 0.0f;

  // Adds amount·v̂v̂ᵀ; for a v that is near zero compared with the unit, half the amount on each axis.
  void add(const Lanes &amount, const Lanes &x, const Lanes &y, const Lanes &unit2) {
    const Lanes no_direction = 1e-4f * unit2, share = amount / (x * x + y * y + no_direction);
    xx += share * (x * x + 0.5f * no_direction);
    xy += share * x * y;
    yy += share * (y * y + 0.5f * no_direction);
  }
};

// Triangles relative to the center, in radii.
struct Seen {
  Place corner[3], way[3]; // edges, and their squared lengths
  Lanes length2[3];
  Place normal;
  Lanes height;                  // of the plane; 0 if the center lies on it
  Lanes nearest, farthest, size; // squared: distances of corners, and the longest edge
  Lanes seen_area;
  Vector<3, Lanes> excess;

  // Returns whether the triangle is smaller than this share of its distance, so that integrands vary little over it.
  Choices is_small(float share) const { return size < nearest * (share * share); }
  Lanes edge_middle2(int k) const { return square_of(corner[k] + way[k] * 0.5f); }
};

// The directions of the center's tangents for vectors of a triangle's plane that are turned into the tangent plane.
struct Turned {
  Place w1, w2;
  Lanes p1, p2; // the normal along the tangents

  Turned(const Place &normal, const LaneCenter &center) {
    const Place n = all(center.normal), t1 = all(center.t1), t2 = all(center.t2);
    const Lanes turn = 1.0f / max(1.0f + dot(n, normal), static_cast<float>(LEAST_TURN));
    p1 = dot(t1, normal);
    p2 = dot(t2, normal);
    w1 = t1 - n * (p1 * turn);
    w2 = t2 - n * (p2 * turn);
  }
  void add(Tensor &tensor, const Place &first, const Place &second, const Vector<3, Lanes> &there, const Lanes &amount) const {
    const Lanes ux = dot(w1, first), uy = dot(w2, first), vx = dot(w1, second), vy = dot(w2, second);
    tensor.xx += amount * (there.x * ux * ux + 2.0f * there.y * ux * vx + there.z * vx * vx);
    tensor.xy += amount * (there.x * ux * uy + there.y * (ux * vy + uy * vx) + there.z * vx * vy);
    tensor.yy += amount * (there.x * uy * uy + 2.0f * there.y * uy * vy + there.z * vy * vy);
  }
};

// The kernel of H for surfaces that bend little, at a squared distance.
Lanes kernel_at(const Lanes &square) { return only(square < 1.0f, 0.25f * (square - 1.0f - logarithm(max(square, 1e-24f)))); }

Seen see(const FaceRow *const *rows, const Choices &is_own, const LaneCenter &center) {
  const auto a = gather<offsetof(FaceRow, corner)>(rows), b = gather<offsetof(FaceRow, corner) + 16>(rows),
             c = gather<offsetof(FaceRow, corner) + 32>(rows), n = gather<offsetof(FaceRow, normal)>(rows);
  Seen seen;
  const Place raw[3] = {first3(a), first3(b), first3(c)}, place = all(center.place), rest = all(center.rest);
  for (int k = 0; k < 3; ++k) {
    seen.corner[k] = (raw[k] - place - rest) * center.per_radius;
    seen.way[k] = (raw[(k + 1) % 3] - raw[k]) * center.per_radius;
    seen.length2[k] = square_of(seen.way[k]);
  }
  const Lanes x = square_of(seen.corner[0]), y = square_of(seen.corner[1]), z = square_of(seen.corner[2]);
  seen.nearest = min(min(x, y), z);
  seen.farthest = max(max(x, y), z);
  seen.size = max(max(seen.length2[0], seen.length2[1]), seen.length2[2]);
  seen.normal = first3(n);
  seen.seen_area = a.w;
  seen.excess = {b.w, c.w, n.w};
  seen.height = mix(dot(seen.normal, seen.corner[0]), 0.0f, is_own);
  // A center that is off the line between two others by needles alone lies on the surface behind the needles.
  const Choices is_low = abs(seen.height) < center.rounding;
  if (!any(is_low && !is_own)) return seen;
  for (int k = 0; k < 3; ++k) {
    const Lanes t = clamp(-dot(seen.corner[k], seen.way[k]) / max(seen.length2[k], 1e-30f), 0.0f, 1.0f);
    const Choices is_near = square_of(seen.corner[k] + seen.way[k] * t) < center.rounding * center.rounding;
    seen.height = mix(seen.height, 0.0f, is_low && is_near);
  }
  return seen;
}

// An edge and the part of it within the ball, from low to high along its line, counted from the point nearest to the center.
struct Edge {
  Place along; // unit
  Lanes length;
  Lanes low, high;
  Lanes near2;  // squared distance of the line
  Lanes across; // distance in the plane from the foot of the center to the line, positive if the foot is to the left
  Lanes sector; // the angle under which the foot sees the parts outside of the ball

  Edge(const Seen &seen, int k, bool is_within) {
    length = sqrt(seen.length2[k]);
    along = seen.way[k] / max(length, 1e-30f);
    const Lanes from = dot(seen.corner[k], along), to = from + length;
    near2 = square_of(seen.corner[k] - along * from);
    across = dot(seen.normal, cross(seen.corner[k], along));
    low = from;
    high = to;
    sector = 0.0f;
    if (is_within) return;
    const Lanes half = sqrt(max(1.0f - near2, 0.0f));
    low = min(max(-half, from), to);
    high = min(max(half, from), to);
    const Lanes a2 = across * across;
    sector = angle(across * (low - from), a2 + from * low) + angle(across * (to - high), a2 + high * to);
  }
  // Returns the solid angle of the triangle between the foot and the part. An arc at distance rho has (1 - height/rho) times its
  // angle.
  Lanes solid_angle(const Lanes &height) const {
    const Lanes a = abs(across), a2 = a * a, h2 = height * height, plane2 = a2 + h2;
    const Lanes near = sqrt(plane2 + low * low), far = sqrt(plane2 + high * high);
    const Lanes turn = angle(a * (high - low), a2 + low * high);
    const Lanes angle_ = turn - angle(height * a * (high * near - low * far), a2 * near * far + h2 * low * high);
    return mix(angle_, -angle_, across < 0.0f);
  }
};

// Integrals along the part of an edge within the ball: of the squared distance, of its logarithm, and of the kernel.
struct Along {
  Lanes squares, logarithms, kernel;

  explicit Along(const Edge &edge) {
    const Lanes &low = edge.low, &high = edge.high, &near2 = edge.near2, length = high - low, near = sqrt(near2);
    constexpr float least = 1e-24f;
    squares = length * (near2 + (high * high + high * low + low * low) * (1.0f / 3.0f));
    logarithms = high * logarithm(max(near2 + high * high, least)) - low * logarithm(max(near2 + low * low, least)) -
                 2.0f * length + 2.0f * near * angle(near * length, near2 + low * high);
    kernel = 0.25f * (squares - length - logarithms);
  }
};

// Returns the height_integral of closed_forms.cpp over the part of an edge within the ball.
Lanes height_integral(const Edge &edge, const Lanes &height2) {
  constexpr float nodes[4] = {-0.861136312f, -0.339981044f, 0.339981044f, 0.861136312f};
  constexpr float weights[4] = {0.347854845f, 0.652145155f, 0.652145155f, 0.347854845f};
  const Lanes near2 = max(edge.near2, height2), near = sqrt(near2), per_height2 = 1.0f / height2;
  const auto t_of = [&](const Lanes &s) { return s / (near + sqrt(near2 + s * s)); };
  const Lanes begin = t_of(edge.low), end = t_of(edge.high), middle = 0.5f * (begin + end), half = 0.5f * (end - begin);
  Lanes sum = 0.0f;
  for (int i = 0; i < 4; ++i) {
    const Lanes t = middle + half * nodes[i], t2 = t * t, v = 1.0f / (1.0f - t2), s = 2.0f * near * t * v;
    const Lanes x = (edge.across * edge.across + s * s) * per_height2;
    const Lanes ratio = mix(1.0f - 0.5f * x, logarithm(1.0f + x) / max(x, 1e-30f), x > 1e-3f);
    sum += weights[i] * (1.0f + t2) * v * v * ratio;
  }
  return 2.0f * edge.across * near * half * per_height2 * sum;
}

// ---- The surface as a solid

// Returns the integral of |h| (1/rho^3 - 1) over triangles within the ball: their solid angle, less what fills them.
Lanes seen_within(const Seen &seen, const Lanes &height) {
  const Place &a = seen.corner[0], &b = seen.corner[1], &c = seen.corner[2];
  const Lanes x = length(a), y = length(b), z = length(c), volume = height * seen.seen_area;
  return 2.0f * angle(volume, x * y * z + dot(a, b) * z + dot(b, c) * x + dot(c, a) * y) - 0.5f * volume;
}

// The same for small triangles at the rim, which may cut them anywhere.
Lanes seen_at_rim(const Seen &seen, const Lanes &height) {
  Lanes sum = 0.0f;
  for (int k = 0; k < 3; ++k) {
    const Lanes square = seen.edge_middle2(k);
    sum += max(1.0f / (square * sqrt(square)) - 1.0f, 0.0f);
  }
  return height * seen.seen_area * sum * (1.0f / 6.0f);
}

// The same for any triangle.
Lanes seen_cut(const Edge (&edges)[3], const Lanes &height) {
  Lanes solid = 0.0f, area = 0.0f, arcs = 0.0f;
  for (const Edge &edge : edges) {
    solid += edge.solid_angle(height);
    area += edge.across * (edge.high - edge.low);
    arcs += edge.sector;
  }
  return solid + (1.0f - height) * arcs - 0.5f * height * (area + (1.0f - height * height) * arcs);
}

// ---- What bends smoothly

// Returns the integral of the kernel over triangles. gradient: what it will be multiplied by, at most.
Lanes kernel_over(const Edge (&edges)[3], const Along (&along)[3], const Lanes &height, const Lanes &gradient) {
  constexpr float least_height2 = 1e-9f, least_effect = 1e-7f;
  const Lanes height2 = max(height * height, least_height2);
  const Choices is_high = height2 * gradient > least_effect;
  const bool any_is_high = any(is_high);
  Lanes sum = 0.0f, arcs = 0.0f;
  for (int k = 0; k < 3; ++k) {
    const Edge &edge = edges[k];
    arcs += edge.sector;
    sum += edge.across * (0.0625f * (along[k].squares + height2 * (edge.high - edge.low)) - 0.125f * along[k].logarithms);
    if (any_is_high) sum += only(is_high, -0.125f * height2 * height_integral(edge, height2));
  }
  return sum + arcs * (0.0625f - height2 * (0.0625f * height2 - 0.125f * logarithm(height2)));
}

struct Sums {
  Tensor hard, smooth;
};

// Adds triangles to the sums. Classes that no lane belongs to are skipped: they would add zeros.
class Adding {
public:
  Adding(const FaceRow *const *rows, const Choices &is_own, const Choices &counts, const LaneCenter &center)
      : rows_(rows), seen_(see(rows, is_own, center)), turned_(seen_.normal, center), counts_(counts), height_(abs(seen_.height)),
        is_in_ball_(height_ < 1.0f), is_within_(!(seen_.farthest > 1.0f)), is_small_(seen_.is_small(0.2f)),
        is_middling_(!is_small_ && seen_.is_small(0.45f)), is_near_(counts && !is_small_ && !is_middling_) {}

  void add(Sums &sums) {
    const Choices is_seen = counts_ && is_in_ball_ && height_ > 0.0f && seen_.seen_area > 0.0f;
    const Choices is_whole = is_seen && is_within_, is_tiny = is_small_ && seen_.size < 0.0025f;
    const Choices is_at_rim = is_seen && !is_within_ && is_tiny, is_cut = is_seen && !is_within_ && !is_tiny;
    Lanes solid = 0.0f;
    if (any(is_whole)) solid += only(is_whole, seen_within(seen_, height_));
    if (any(is_at_rim)) solid += only(is_at_rim, seen_at_rim(seen_, height_));
    if (any(counts_ && is_small_)) add_small(sums.smooth);
    if (any(counts_ && !is_small_) || any(is_cut)) solid += add_near(sums.smooth, is_cut);
    sums.hard.add(mix(solid, -solid, seen_.height < 0.0f), turned_.p1, turned_.p2, 1.0f);
  }

private:
  void add_small(Tensor &tensor) const {
    const Place first = first3(gather<offsetof(FaceRow, axis)>(rows_));
    const Lanes square = square_of((seen_.corner[0] + seen_.corner[1] + seen_.corner[2]) * (1.0f / 3.0f));
    turned_.add(tensor, first, cross(seen_.normal, first), seen_.excess, only(counts_ && is_small_, kernel_at(square)));
  }

  // Removes bends at edges that are not creases, and adds the gradients of normals. Returns the solid angles of cut triangles.
  Lanes add_near(Tensor &tensor, const Choices &is_cut) const {
    const auto axis = gather<offsetof(FaceRow, axis)>(rows_), bends = gather<offsetof(FaceRow, smooth_bend)>(rows_),
               others = gather<offsetof(FaceRow, bend)>(rows_);
    Lanes solid = 0.0f, over = 0.0f, along[3] = {0.0f, 0.0f, 0.0f};
    if (any(counts_ && is_middling_)) {
      for (int k = 0; k < 3; ++k) {
        const Lanes middle = kernel_at(seen_.edge_middle2(k));
        along[k] = only(is_middling_, sqrt(seen_.length2[k]) * middle);
        over += only(is_middling_, seen_.seen_area * middle * (1.0f / 6.0f));
      }
    }
    if (any(is_near_ || is_cut)) {
      const bool all_within = !any((is_near_ || is_cut) && !is_within_);
      const Edge edges[3] = {{seen_, 0, all_within}, {seen_, 1, all_within}, {seen_, 2, all_within}};
      if (any(is_cut)) solid = only(is_cut, seen_cut(edges, height_));
      if (any(is_near_)) {
        const Along sums[3] = {Along(edges[0]), Along(edges[1]), Along(edges[2])};
        for (int k = 0; k < 3; ++k) along[k] = mix(along[k], sums[k].kernel, is_near_);
        const Lanes gradient = only(is_near_, abs(axis.w) + abs(bends.w) + abs(others.w));
        if (any(gradient > 0.0f)) over = mix(over, kernel_over(edges, sums, height_, gradient), is_near_);
      }
    }
    const Choices is_bent = counts_ && !is_small_;
    const Lanes bend[3] = {bends.x, bends.y, bends.z};
    for (int k = 0; k < 3; ++k) remove_bend(tensor, k, only(is_bent, bend[k] * along[k]));
    const Place first = first3(axis);
    turned_.add(tensor, first, cross(seen_.normal, first), {axis.w, bends.w, others.w}, only(is_bent && is_in_ball_, over));
    return solid;
  }

  // Removes half of a bend; the other half is removed for the face across the edge.
  void remove_bend(Tensor &tensor, int k, const Lanes &amount) const {
    tensor.add(-0.5f * amount, dot(turned_.w2, seen_.way[k]), -dot(turned_.w1, seen_.way[k]), max(seen_.length2[k], 1e-30f));
  }

  const FaceRow *const *rows_;
  const Seen seen_;
  const Turned turned_;
  const Choices counts_;
  const Lanes height_;
  const Choices is_in_ball_, is_within_, is_small_, is_middling_, is_near_;
};

FaceSums add_faces(const FaceRow *const *rows, int32_t count, int32_t own, const LaneCenter &center) {
  constexpr int parts = FACE_LANES / lane_count;
  Sums sums[parts];
  const auto first_of = [](int32_t lanes) {
    return choices_of(lanes >= lane_count ? ~uint32_t{0} : lanes > 0 ? (uint32_t{1} << lanes) - 1 : 0);
  };
  for (int32_t first = 0; first < count; first += FACE_LANES)
    for (int part = 0; part < parts; ++part) {
      const int32_t i = first + part * lane_count;
      Adding(rows + i, first_of(own - i), first_of(count - i), center).add(sums[part]);
    }
  const auto folded = [&](Tensor Sums::*tensor, Lanes Tensor::*entry) {
    Lanes lanes[parts];
    for (int part = 0; part < parts; ++part) lanes[part] = sums[part].*tensor.*entry;
    return fold_lanes(lanes);
  };
  return {{folded(&Sums::hard, &Tensor::xx), folded(&Sums::hard, &Tensor::xy), folded(&Sums::hard, &Tensor::yy)},
          {folded(&Sums::smooth, &Tensor::xx), folded(&Sums::smooth, &Tensor::xy), folded(&Sums::smooth, &Tensor::yy)}};
}

} // namespace

} // namespace KERNEL_TARGET
} // namespace paradesc::kernels

namespace paradesc {

PARADESC_TARGET(FaceTarget, face_sums_of) = {PARADESC_TARGET_NAME, kernels::add_faces};

} // namespace paradesc
