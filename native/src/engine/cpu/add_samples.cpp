// The sums of one set of instructions: compiled once for each, with LANE_WIDTH lanes and under the name KERNEL_TARGET.
#include "engine/cpu/add_samples.h"

#include "engine/cpu/kinds.h"

namespace paradesc::kernels {
inline namespace KERNEL_TARGET {

constexpr int passes = max_lanes / lane_count;

inline Lanes load(const float *from) {
  Lanes lanes;
  __builtin_memcpy(&lanes, from, sizeof lanes);
  return lanes;
}
inline Vector<3, Lanes> all(const float *v) { return {v[0], v[1], v[2]}; }

inline Lanes square_of(const Vector<3, Lanes> &v) { return dot(v, v); }
inline Lanes fast_sqrt(const Lanes &square) { return square * fast_inversesqrt(max(square, 1e-30f)); }

// Those lanes whose bits are set.
inline Choices chosen(int bits) {
  Choices::Bits lane;
  for (int i = 0; i < lane_count; ++i) lane[i] = 1 << i;
  return {(lane & bits) != 0};
}

inline bool any(const Choices &choices) {
  using Words = std::array<uint64_t, lane_count / 2>;
  uint64_t all = 0;
  for (const uint64_t word : std::bit_cast<Words>(choices)) all |= word;
  return all != 0;
}

inline int bits_of(const Choices &choices) {
  int bits = 0;
  for (int i = 0; i < lane_count; ++i) bits |= (choices.lane[i] & 1) << i;
  return bits;
}

// A sample as the centers see it.
struct Seen {
  static constexpr float root2 = 1.41421356f, root6 = 2.44948974f;
  const FlatSample &sample;
  Vector<3, Lanes> offset;
  Lanes height; // of the position above the plane of the face
  Lanes area;
  float edge[3]; // squared: between corners 0 and 1, 1 and 2, 2 and 0
  float spread;

  Seen(const FlatSample &from, const Vector<3, Lanes> &center, const Choices &shown)
      : sample(from), offset(all(from.position) - center), height(dot(offset, all(from.face))),
        area(mix(0.0f, from.area, shown)) {
    const auto product = [](const float *a, const float *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
    const float u = product(from.along[0], from.along[0]), v = product(from.along[1], from.along[1]);
    const float uv = product(from.along[0], from.along[1]) * (6.0f * root2 * root6);
    edge[0] = 18.0f * u + 6.0f * v + uv;
    edge[1] = 24.0f * v;
    edge[2] = 18.0f * u + 6.0f * v - uv;
    spread = u + v;
  }

  Vector<3, Lanes> along(int k) const { return all(sample.along[k]); }
  Vector<3, Lanes> normal_along(int k) const { return all(sample.normal_along[k]); }
  Vector<3, Lanes> at(const Lanes *place) const { return offset + along(0) * place[0] + along(1) * place[1]; }
  Vector<3, Lanes> normal_at(const Lanes *place) const {
    return all(sample.normal) + normal_along(0) * place[0] + normal_along(1) * place[1];
  }
  // Of the circle in which the ball of this radius meets the plane.
  Lanes per_radius_of_arc(float radius) const {
    constexpr float least = 1e-4f;
    return fast_inversesqrt(max(radius * radius - height * height, least * radius * radius));
  }
};

// The corners of a sample, along its two directions.
constexpr float corner_place[3][2] = {{-2.0f * Seen::root2, 0.0f}, {Seen::root2, Seen::root6}, {Seen::root2, -Seen::root6}};
inline Vector<3, Lanes> at_corner(int k, const Vector<3, Lanes> &mean, const float along[2][3]) {
  const auto gap = [&](int axis) { return corner_place[k][0] * along[0][axis] + corner_place[k][1] * along[1][axis]; };
  return {mean.x + gap(0), mean.y + gap(1), mean.z + gap(2)};
}

// Whether the surface may come nearer to the center on a sample than around it, within the ball: there the way to the center is
// one of the surface's normals, or lies between them, which lean from that of the face by its turn at most.
inline Choices may_be_nearest(const Seen &seen, float radius) {
  constexpr float normals_length = 0.95f; // squared, at least: of mean normals
  const float reach = seen.sample.reach, beyond = radius + reach;
  const Lanes square = square_of(seen.offset), height = max(seen.height, -1.0f * seen.height);
  const Lanes across = square - height * height * (1.0f / normals_length), turned = reach + seen.sample.turn * height;
  return across < turned * turned && square < beyond * beyond;
}

// The part of samples that lies in a ball.
struct Part {
  Lanes area;
  Lanes place[2];       // its mean position, along both of the sample's directions
  Lanes chord;          // squared: between the places where the rim meets the sample's edges; 0: it does not
  Lanes chord_place[2]; // its middle
};

// How far along the edge from a corner to another the rim is met. beyond: how far the squared distances of both are below that of
// the rim; between them the distance falls as the edge is straight.
inline void meet_rim(const Lanes &beyond, const Lanes &other_beyond, const Lanes &edge, Lanes &above, Lanes &below) {
  const Lanes slope = other_beyond - beyond + edge;
  const Lanes root = fast_sqrt(max(slope * slope + 4.0f * edge * beyond, 0.0f));
  above = 2.0f * max(beyond, -1.0f * beyond);
  below = max(root + mix(slope, -1.0f * slope, beyond > 0.0f), 1e-18f);
}

// What of a triangle lies in the ball: all but or only the part at the corner that is alone on its side of the rim, which is
// bounded by two edges, and by an arc that lies beyond its chord. inside: how far the squared distances of the corners are below
// that of the rim. per_radius: one over that of the arc.
[[gnu::always_inline]] inline Part clip(const Seen &seen, const Lanes *inside, const Lanes &per_radius) {
  const Choices in0 = inside[0] > 0.0f, in1 = inside[1] > 0.0f, in2 = inside[2] > 0.0f;
  const Choices alone1 = (in0 != in1) && (in1 != in2), alone2 = (in1 != in2) && (in2 != in0);
  const auto choose = [&](const Lanes &of0, const Lanes &of1, const Lanes &of2) {
    return mix(mix(of0, of1, alone1), of2, alone2);
  };
  const Lanes alone = choose(inside[0], inside[1], inside[2]), next = choose(inside[1], inside[2], inside[0]),
              previous = choose(inside[2], inside[0], inside[1]);
  const Lanes to_next = choose(seen.edge[0], seen.edge[1], seen.edge[2]),
              to_previous = choose(seen.edge[2], seen.edge[0], seen.edge[1]),
              opposite = choose(seen.edge[1], seen.edge[2], seen.edge[0]);
  Lanes above_next, below_next, above_previous, below_previous;
  meet_rim(alone, next, to_next, above_next, below_next);
  meet_rim(alone, previous, to_previous, above_previous, below_previous);
  const Lanes root = fast_inversesqrt(max(below_next * below_previous, 1e-36f)), reciprocal = root * root;
  const Lanes p = min(above_next * below_previous * reciprocal, 1.0f), q = min(above_previous * below_next * reciprocal, 1.0f);
  const Lanes chord = p * p * to_next + q * q * to_previous - p * q * (to_next + to_previous - opposite);
  const Lanes corner = seen.area * p * q, arc = min(max(chord, 0.0f) * fast_sqrt(chord) * (1.0f / 12.0f) * per_radius, seen.area);
  const Choices only_corner = alone > 0.0f, cut = (in0 != in1) || (in1 != in2);
  const Lanes sign = mix(-1.0f, 1.0f, only_corner);
  // Areas by corners: that of the triangle at the corner by thirds, that of the arc by halves of its chord.
  const Lanes third = sign * corner * (1.0f / 3.0f), half = arc * 0.5f;
  const Lanes all = mix(seen.area, 0.0f, only_corner);
  const Lanes at_next = p * (third + half), at_previous = q * (third + half);
  const Lanes at_alone = 3.0f * third + arc - at_next - at_previous;
  const Lanes at0 = choose(at_alone, at_previous, at_next), at1 = choose(at_next, at_alone, at_previous),
              at2 = choose(at_previous, at_next, at_alone);
  Part part;
  part.area = mix(mix(0.0f, seen.area, in0), max(all + 3.0f * third + arc, 0.0f), cut);
  const Lanes root_area = fast_inversesqrt(max(part.area, 1e-30f)), per_area = mix(0.0f, root_area * root_area, cut);
  part.place[0] = (Seen::root2 * (at1 + at2) - 2.0f * Seen::root2 * at0) * per_area;
  part.place[1] = Seen::root6 * (at1 - at2) * per_area;
  const Lanes half_next = p * 0.5f, half_previous = q * 0.5f, rest = 1.0f - half_next - half_previous;
  const Lanes m1 = choose(half_next, rest, half_previous), m2 = choose(half_previous, half_next, rest);
  part.chord = mix(0.0f, max(chord, 0.0f), cut && seen.area > 0.0f);
  part.chord_place[0] = Seen::root2 * (3.0f * (m1 + m2) - 2.0f); // their sum is 1
  part.chord_place[1] = Seen::root6 * (m1 - m2);
  return part;
}

template <class Wide> struct Adder {
  using Neighbor = typename Wide::Neighbor;
  Wide kernel;
  typename Wide::Sums sums;

  // Returns the bits of the centers to which the surface may come nearest on it.
  int add(const FlatSample &sample, const Choices &shown) {
    const Seen seen(sample, sums.center.position, shown);
    const float radius = kernel.params.radius;
    const Choices may_be = may_be_nearest(seen, radius);
    Lanes squares[3]; // of the distances of the corners
    for (int k = 0; k < 3; ++k) squares[k] = square_to(seen, k);
    const int nearest = any(may_be) ? bits_of(may_be) : 0;
    if (!any(min(min(squares[0], squares[1]), squares[2]) < radius * radius)) return nearest;
    Neighbor neighbor;
    if constexpr (requires { neighbor.face; }) neighbor.face = all(sample.face);
    const Part part = clip_at(seen, squares, radius);
    place(seen, part, neighbor);
    if constexpr (requires { sums.terms.bending; }) find_turning(seen, part, squares, neighbor);
    neighbor.inside = Wide::geodesic_ball ? part.area : part.area - strip_of(seen, part);
    Vector<4, Lanes> map(0.0f);
    if constexpr (requires { sums.center.value; }) map = {sample.map[0], sample.map[1], sample.map[2], sample.map[3]};
    if constexpr (requires { sums.half_ball; }) {
      Neighbor inner = neighbor;
      place(seen, clip_at(seen, squares, 0.5f * radius), inner);
      kernel.add_weighted(sums, neighbor, inner, map);
    } else {
      kernel.add_weighted(sums, neighbor, map);
    }
    add_variance(seen, part);
    return nearest;
  }

  // Of the distance of a corner that bounds the ball.
  Lanes square_to(const Seen &seen, int corner) {
    Neighbor neighbor;
    neighbor.offset = at_corner(corner, seen.offset, seen.sample.along);
    const Lanes square = square_of(neighbor.offset);
    if constexpr (!Wide::geodesic_ball) return square;
    neighbor.rho = fast_sqrt(square);
    neighbor.normal = at_corner(corner, all(seen.sample.normal), seen.sample.normal_along);
    const Lanes geodesic = kernel.geodesic_distance(sums.center, neighbor);
    return geodesic * geodesic;
  }

  // At the rim, what is within the radius, but not along the surface.
  Lanes strip_of(const Seen &seen, const Part &part) const {
    const float radius = kernel.params.radius;
    const Vector<3, Lanes> offset = seen.at(part.chord_place), normal = seen.normal_at(part.chord_place);
    const Lanes per_length = fast_inversesqrt(max(square_of(normal), 1e-30f));
    const Lanes bend = dot(normal * per_length - sums.center.normal, offset) * (1.0f / radius);
    const Lanes per_arc = seen.per_radius_of_arc(radius);
    const Lanes square = bend * bend * (1.0f / 24.0f), chord = min(part.chord * per_arc * per_arc, 4.0f);
    // Half of r^2 - r^2 / (1 + square)^2 for each angle; and the angle of the chord.
    return 0.5f * radius * radius * square * (2.0f + square) / ((1.0f + square) * (1.0f + square)) * fast_sqrt(chord) *
           (1.0f + chord * (1.0f / 24.0f + 3.0f / 640.0f * chord));
  }

  [[gnu::always_inline]] static Part clip_at(const Seen &seen, const Lanes *squares, float radius) {
    const Lanes rim = radius * radius, inside[3] = {rim - squares[0], rim - squares[1], rim - squares[2]};
    const Choices in = inside[0] > 0.0f;
    if (!any((in != (inside[1] > 0.0f)) || (in != (inside[2] > 0.0f))))
      return {mix(0.0f, seen.area, in), {0.0f, 0.0f}, 0.0f, {0.0f, 0.0f}};
    return clip(seen, inside, seen.per_radius_of_arc(radius));
  }

  // The neighbor stands for the part.
  void place(const Seen &seen, const Part &part, Neighbor &neighbor) {
    neighbor.offset = seen.at(part.place);
    neighbor.normal = seen.normal_at(part.place);
    const Lanes square = square_of(neighbor.offset), share = part.area * seen.sample.per_area;
    neighbor.rho = fast_sqrt(square);
    // The mean distance grows by what varies across the way.
    const Lanes u = dot(neighbor.offset, seen.along(0)), v = dot(neighbor.offset, seen.along(1));
    const Lanes per_rho = fast_inversesqrt(max(square, 1e-30f));
    neighbor.mean_rho = fast_sqrt(square + share * max(seen.spread - (u * u + v * v) * per_rho * per_rho, 0.0f));
    neighbor.geodesic = kernel.geodesic_distance(sums.center, neighbor);
    neighbor.distance = Wide::geodesic_ball ? neighbor.geodesic : neighbor.rho;
    neighbor.area = seen.area;
    neighbor.weight = part.area;
    neighbor.near = Choices{};
  }

  // The means of |n - n_i|^2/rho^2 and of e e^T, by four places. Of a triangle that has the center at a corner they are those
  // along the opposite edge, where it is not cut, for they depend on the direction alone: by Gauss's places on both sides of the
  // bisector. Of others, those over the part.
  void find_turning(const Seen &seen, const Part &part, const Lanes *squares, Neighbor &neighbor) {
    const float near = 1e-6f * kernel.params.radius * kernel.params.radius;
    const Choices at0 = squares[0] < near, at2 = squares[2] < near, apart = !(at0 || squares[1] < near || at2);
    const auto choose = [&](const Lanes &of0, const Lanes &of1, const Lanes &of2) { return mix(mix(of1, of2, at2), of0, at0); };
    const Lanes from_length = fast_sqrt(choose(squares[1], squares[2], squares[0]));
    const Lanes to_length = fast_sqrt(choose(squares[2], squares[0], squares[1]));
    const Lanes bisector = from_length / max(from_length + to_length, 1e-30f);
    const Lanes extent = fast_sqrt(part.area * seen.sample.per_area);
    constexpr float inner[4][2] = {{-1.0f, -1.0f}, {-1.0f, 1.0f}, {1.0f, -1.0f}, {1.0f, 1.0f}};
    constexpr float gauss[2] = {0.21132487f, 0.78867513f};
    neighbor.turning = 0.0f;
    neighbor.directions = Vector<3, Lanes>(Lanes(0.0f));
    for (int k = 0; k < 4; ++k) {
      const Lanes start = k < 2 ? Lanes(0.0f) : bisector, size = k < 2 ? bisector : 1.0f - bisector;
      const Lanes along = start + gauss[k % 2] * size, share = mix(0.5f * size, 0.25f, apart);
      Lanes place[2];
      for (int axis = 0; axis < 2; ++axis) {
        const auto corner = [&](int i) { return Lanes(corner_place[i][axis]); };
        const Lanes from = choose(corner(1), corner(2), corner(0)), to = choose(corner(2), corner(0), corner(1));
        place[axis] = mix(from + along * (to - from), part.place[axis] + extent * inner[k][axis], apart);
      }
      const Vector<3, Lanes> turn = seen.normal_at(place) - sums.center.normal, way = seen.at(place);
      const Lanes root = fast_inversesqrt(max(square_of(way), near));
      const Lanes x = dot(way, sums.center.t1), y = dot(way, sums.center.t2);
      const Lanes root_of_flat = fast_inversesqrt(max(x * x + y * y, near));
      neighbor.turning += share * square_of(turn) * root * root;
      neighbor.directions += share * root_of_flat * root_of_flat * Vector<3, Lanes>(x * x, x * y, y * y);
    }
  }

  // To the moments that the parts' mean positions and normals have, what these vary within them.
  void add_variance(const Seen &seen, const Part &part) {
    const Lanes weight = part.area * part.area * seen.sample.per_area;
    for (int k = 0; k < 2; ++k) {
      const Lanes x = dot(seen.along(k), sums.center.t1) * (1.0f / kernel.params.radius),
                  y = dot(seen.along(k), sums.center.t2) * (1.0f / kernel.params.radius);
      const Lanes turn_x = dot(seen.normal_along(k), sums.center.t1), turn_y = dot(seen.normal_along(k), sums.center.t2);
      sums.moments.xx += weight * Vector<3, Lanes>(x * x, x * y, y * y);
      sums.moments.xy += weight * Vector<3, Lanes>(x * turn_x, x * turn_y + y * turn_x, y * turn_y);
    }
  }
};

// The lanes of one pass go where they belong among all. Returns where the next part's go.
template <class Part> size_t store(const Part &part, int pass, Sums &sums, size_t at) {
  constexpr size_t count = sizeof(Part) / sizeof(Lanes);
  for (size_t i = 0; i < count; ++i)
    __builtin_memcpy(sums[at + i] + pass * lane_count, reinterpret_cast<const char *>(&part) + i * sizeof(Lanes), sizeof(Lanes));
  return at + count;
}

template <template <class, class> class Kernel>
void add_samples(const EvaluateParams &params, const FlatSample *const *samples, const uint16_t *shown, int32_t count,
                 const SumCenters &centers, Sums &sums, uint16_t *nearest) {
  using Wide = Kernel<Lanes, Choices>;
  for (int pass = 0; pass < passes; ++pass) {
    const int first = pass * lane_count;
    const auto load3 = [&](const float(&v)[3][max_lanes]) {
      return Vector<3, Lanes>(load(v[0] + first), load(v[1] + first), load(v[2] + first));
    };
    Adder<Wide> adder{Wide{params}, {}};
    adder.kernel.sums_init(adder.sums, load3(centers.position), load3(centers.normal), load(centers.value + first));
    for (int32_t i = 0; i < count; ++i) {
      const int bits = adder.add(*samples[i], chosen(shown[i] >> first)) << first;
      nearest[i] = static_cast<uint16_t>(pass == 0 ? bits : nearest[i] | bits);
    }
    size_t at = store(adder.sums.moments, pass, sums, 0);
    if constexpr (requires { adder.sums.half_ball; }) at = store(adder.sums.half_ball, pass, sums, at);
    store(adder.sums.terms, pass, sums, at);
  }
}

constexpr AddSamples by_kind[sum_kinds] = {add_samples<FitKernel>,
                                           add_samples<SurfaceKernel>,
                                           add_samples<SurfaceGeodesicKernel>,
                                           add_samples<ExtrapolatedKernel>,
                                           add_samples<ExtrapolatedGeodesicKernel>,
                                           add_samples<JetKernel>,
                                           add_samples<JetGeodesicKernel>,
                                           add_samples<WindowsKernel>,
                                           add_samples<WindowsGeodesicKernel>};

#define TEXT_OF(name) #name
#define TARGET_NAME(target) TEXT_OF(target)
#define JOIN(a, b) a##b
#define SUMS_OF(target) JOIN(sums_of_, target)
extern const SumTarget SUMS_OF(KERNEL_TARGET);
const SumTarget SUMS_OF(KERNEL_TARGET){TARGET_NAME(KERNEL_TARGET), by_kind};

} // namespace KERNEL_TARGET
} // namespace paradesc::kernels
