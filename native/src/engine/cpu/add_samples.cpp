// The sums of one set of instructions: compiled once for each, with LANE_WIDTH lanes and under the name KERNEL_TARGET.
#include "engine/cpu/add_samples.h"

#include "engine/cpu/kinds.h"

namespace paradesc::kernels {
inline namespace KERNEL_TARGET {

constexpr int passes = block_lanes / lane_count;

inline Lanes load(const float *from) {
  Lanes lanes;
  __builtin_memcpy(&lanes, from, sizeof lanes);
  return lanes;
}

// A row of a block, and the two that follow it.
inline Vector<3, Lanes> load3(const float *from) { return {load(from), load(from + block_lanes), load(from + 2 * block_lanes)}; }

// A bit for each of these blocks that may have samples in the ball.
inline uint32_t blocks_in_ball(const SampleBlocks &samples, const SumCenter &center, int first) {
  uint32_t in_ball = 0;
  for (int part = 0; part < passes; ++part) {
    const size_t at = static_cast<size_t>(first + part * lane_count);
    const Lanes x = load(samples.middle[0] + at) - center.position[0], y = load(samples.middle[1] + at) - center.position[1],
                z = load(samples.middle[2] + at) - center.position[2];
    const Choices inside = x * x + y * y + z * z < load(samples.limit + at);
    for (int i = 0; i < lane_count; ++i) in_ball |= static_cast<uint32_t>(inside.lane[i] & 1) << (part * lane_count + i);
  }
  return in_ball;
}

inline Lanes square_of(const Vector<3, Lanes> &v) { return dot(v, v); }
inline Lanes fast_sqrt(const Lanes &square) { return square * fast_inversesqrt(max(square, 1e-30f)); }

// Whether the surface may come nearer to the center on a sample than around it, within the ball: there the way to the center is
// one of the surface's normals, or lies between them, which lean from that of the face by SAMPLE_TURN at most.
inline Choices may_be_nearest(const Vector<3, Lanes> &offset, const float *block, float radius) {
  constexpr float normals_length = 0.95f; // squared, at least: of mean normals
  const auto row = [&](int index) { return load(block + index * block_lanes); };
  const Lanes square = square_of(offset), reach = row(SAMPLE_REACH), beyond = radius + reach;
  const Lanes height = dot(offset, load3(block + SAMPLE_FACE * block_lanes));
  const Lanes across = square - height * height * (1.0f / normals_length);
  const Lanes turned = reach + row(SAMPLE_TURN) * max(height, -1.0f * height);
  return across < turned * turned && square < beyond * beyond && row(SAMPLE_AREA) > 0.0f;
}

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

inline int32_t count(const Choices::Bits &per_lane) {
  int32_t all = 0;
  for (int i = 0; i < lane_count; ++i) all -= per_lane[i];
  return all;
}

// Samples as a center sees them.
struct Seen {
  static constexpr float root2 = 1.41421356f, root6 = 2.44948974f;
  Vector<3, Lanes> offset, along[2], normal, normal_along[2];
  Lanes area, per_area;
  Lanes edge[3]; // squared: between corners 0 and 1, 1 and 2, 2 and 0
  Lanes height;  // of the position above the plane of the face

  Seen(const float *block, const SumCenter &center) {
    const auto row3 = [&](int index) { return load3(block + index * block_lanes); };
    offset = row3(SAMPLE_POSITION) - Vector<3, Lanes>(center.position[0], center.position[1], center.position[2]);
    normal = row3(SAMPLE_NORMAL);
    for (int k = 0; k < 2; ++k) {
      along[k] = row3(SAMPLE_ALONG + 3 * k);
      normal_along[k] = row3(SAMPLE_NORMAL_ALONG + 3 * k);
    }
    area = load(block + SAMPLE_AREA * block_lanes);
    per_area = load(block + SAMPLE_PER_AREA * block_lanes);
    height = dot(offset, row3(SAMPLE_FACE));
    const Lanes u = square_of(along[0]), v = square_of(along[1]), uv = dot(along[0], along[1]) * (6.0f * root2 * root6);
    edge[0] = 18.0f * u + 6.0f * v + uv;
    edge[1] = 24.0f * v;
    edge[2] = 18.0f * u + 6.0f * v - uv;
  }

  Vector<3, Lanes> at(const Lanes *place) const { return offset + along[0] * place[0] + along[1] * place[1]; }
  Vector<3, Lanes> normal_at(const Lanes *place) const {
    return normal + normal_along[0] * place[0] + normal_along[1] * place[1];
  }
  // Offset or normal at a corner.
  static Vector<3, Lanes> at_corner(int corner, const Vector<3, Lanes> &mean, const Vector<3, Lanes> *along) {
    if (corner == 0) return mean - along[0] * Lanes(2.0f * root2);
    return mean + along[0] * Lanes(root2) + along[1] * Lanes(corner == 1 ? root6 : -root6);
  }
  Vector<3, Lanes> corner(int k) const { return at_corner(k, offset, along); }
  // Of the circle in which the ball of this radius meets the plane.
  Lanes per_radius_of_arc(float radius) const {
    constexpr float least = 1e-4f;
    return fast_inversesqrt(max(radius * radius - height * height, least * radius * radius));
  }
  Lanes spread() const { return square_of(along[0]) + square_of(along[1]); }
};

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
  Choices::Bits nearest; // less one for each

  // block: from the lanes of this pass on. shown: a bit for each of them that counts.
  void add(const float *block, int shown, const SumCenter &center) {
    const auto row = [&](int index) { return block + index * block_lanes; };
    Seen seen(block, center);
    seen.area = mix(0.0f, seen.area, chosen(shown));
    const float radius = kernel.params.radius;
    const Choices may_be = may_be_nearest(seen.offset, block, radius);
    nearest = nearest + may_be.lane;
    Neighbor neighbor;
    if constexpr (requires { neighbor.face; }) neighbor.face = load3(row(SAMPLE_FACE));
    Lanes squares[3]; // of the distances of the corners
    for (int k = 0; k < 3; ++k) squares[k] = square_to(seen, k);
    const Part part = clip_at(seen, squares, radius);
    place(seen, part, neighbor);
    if constexpr (requires { sums.terms.bending; }) find_turning(seen, part, squares, neighbor);
    neighbor.inside = Wide::geodesic_ball ? part.area : part.area - strip_of(seen, part);
    Vector<4, Lanes> map(0.0f);
    if constexpr (requires { sums.center.value; }) {
      const Vector<3, Lanes> gradient = load3(row(SAMPLE_GRADIENT));
      map = {gradient.x, gradient.y, gradient.z, load(row(SAMPLE_VALUE))};
    }
    if constexpr (requires { sums.half_ball; }) {
      Neighbor inner = neighbor;
      place(seen, clip_at(seen, squares, 0.5f * radius), inner);
      kernel.add_weighted(sums, neighbor, inner, map);
    } else {
      kernel.add_weighted(sums, neighbor, map);
    }
    add_variance(seen, part);
  }

  // Of the distance of a corner that bounds the ball.
  Lanes square_to(const Seen &seen, int corner) {
    Neighbor neighbor;
    neighbor.offset = seen.corner(corner);
    const Lanes square = square_of(neighbor.offset);
    if constexpr (!Wide::geodesic_ball) return square;
    neighbor.rho = fast_sqrt(square);
    neighbor.normal = Seen::at_corner(corner, seen.normal, seen.normal_along);
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
    const Lanes square = square_of(neighbor.offset), share = part.area * seen.per_area;
    neighbor.rho = fast_sqrt(square);
    // The mean distance grows by what varies across the way.
    const Lanes u = dot(neighbor.offset, seen.along[0]), v = dot(neighbor.offset, seen.along[1]);
    const Lanes per_rho = fast_inversesqrt(max(square, 1e-30f));
    neighbor.mean_rho = fast_sqrt(square + share * max(seen.spread() - (u * u + v * v) * per_rho * per_rho, 0.0f));
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
    constexpr float root2 = Seen::root2, root6 = Seen::root6;
    const Lanes from[2] = {choose(root2, root2, -2.0f * root2), choose(root6, -1.0f * root6, 0.0f)};
    const Lanes to[2] = {choose(root2, -2.0f * root2, root2), choose(-1.0f * root6, 0.0f, root6)};
    const Lanes from_length = fast_sqrt(choose(squares[1], squares[2], squares[0]));
    const Lanes to_length = fast_sqrt(choose(squares[2], squares[0], squares[1]));
    const Lanes bisector = from_length / max(from_length + to_length, 1e-30f);
    const Lanes extent = fast_sqrt(part.area * seen.per_area);
    constexpr float inner[4][2] = {{-1.0f, -1.0f}, {-1.0f, 1.0f}, {1.0f, -1.0f}, {1.0f, 1.0f}};
    constexpr float gauss[2] = {0.21132487f, 0.78867513f};
    neighbor.turning = 0.0f;
    neighbor.directions = Vector<3, Lanes>(Lanes(0.0f));
    for (int k = 0; k < 4; ++k) {
      const Lanes start = k < 2 ? Lanes(0.0f) : bisector, size = k < 2 ? bisector : 1.0f - bisector;
      const Lanes along = start + gauss[k % 2] * size, share = mix(0.5f * size, 0.25f, apart);
      Lanes place[2];
      for (int axis = 0; axis < 2; ++axis)
        place[axis] = mix(from[axis] + along * (to[axis] - from[axis]), part.place[axis] + extent * inner[k][axis], apart);
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
    const Lanes weight = part.area * part.area * seen.per_area;
    for (int k = 0; k < 2; ++k) {
      const Lanes x = dot(seen.along[k], sums.center.t1) * (1.0f / kernel.params.radius),
                  y = dot(seen.along[k], sums.center.t2) * (1.0f / kernel.params.radius);
      const Lanes turn_x = dot(seen.normal_along[k], sums.center.t1), turn_y = dot(seen.normal_along[k], sums.center.t2);
      sums.moments.xx += weight * Vector<3, Lanes>(x * x, x * y, y * y);
      sums.moments.xy += weight * Vector<3, Lanes>(x * turn_x, x * turn_y + y * turn_x, y * turn_y);
    }
  }
};

using AllLanes = std::array<float, block_lanes>;

// The lanes of one pass go where they belong among all. Returns where the next part's go.
template <class Part> AllLanes *store(const Part &part, int pass, AllLanes *lanes) {
  constexpr size_t count = sizeof(Part) / sizeof(Lanes);
  for (size_t i = 0; i < count; ++i)
    __builtin_memcpy(lanes[i].data() + pass * lane_count, reinterpret_cast<const char *>(&part) + i * sizeof(Lanes),
                     sizeof(Lanes));
  return lanes + count;
}

template <template <class, class> class Kernel>
int32_t add_samples(const EvaluateParams &params, const SampleBlocks &samples, const SumCenter &center, float *sums) {
  using Wide = Kernel<Lanes, Choices>;
  alignas(64) AllLanes lanes[max_sums];
  AllLanes *end = lanes;
  int32_t nearest = 0;
  for (int pass = 0; pass < passes; ++pass) {
    Adder<Wide> adder{Wide{params}, {}, {}};
    const auto all = [](const float *v) { return Vector<3, Lanes>(v[0], v[1], v[2]); };
    adder.kernel.sums_init(adder.sums, all(center.position), all(center.normal), center.value);
    for (int first = 0; first < samples.count; first += block_lanes)
      for (uint32_t blocks = blocks_in_ball(samples, center, first); blocks; blocks &= blocks - 1) {
        const int index = first + __builtin_ctz(blocks);
        const ptrdiff_t block = samples.block[index];
        adder.add(samples.data + samples.stride * block + pass * lane_count, samples.shown[index] >> (pass * lane_count), center);
      }
    end = store(adder.sums.moments, pass, lanes);
    if constexpr (requires { adder.sums.half_ball; }) end = store(adder.sums.half_ball, pass, end);
    end = store(adder.sums.terms, pass, end);
    nearest += count(adder.nearest);
  }
  for (const AllLanes *one = lanes; one != end; ++one) *sums++ = sum_of(*one);
  return nearest;
}

int32_t count_nearest(float radius, const float *data, int32_t stride, int32_t begin, int32_t end, const SumCenter &center) {
  Choices::Bits nearest{}, lane;
  for (int i = 0; i < lane_count; ++i) lane[i] = i;
  for (int32_t block = begin / block_lanes; block * block_lanes < end; ++block)
    for (int pass = 0; pass < passes; ++pass) {
      const float *const from = data + static_cast<ptrdiff_t>(stride) * block + pass * lane_count;
      const Choices::Bits index = lane + (block * block_lanes + pass * lane_count);
      const Vector<3, Lanes> offset = load3(from) - Vector<3, Lanes>(center.position[0], center.position[1], center.position[2]);
      const Choices may_be = may_be_nearest(offset, from, radius);
      nearest = nearest + (may_be.lane & (index >= begin) & (index < end));
    }
  return count(nearest);
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
const SumTarget SUMS_OF(KERNEL_TARGET){TARGET_NAME(KERNEL_TARGET), by_kind, count_nearest};

} // namespace KERNEL_TARGET
} // namespace paradesc::kernels
