// The sums for one instruction set. This file is compiled once for each, with LANE_WIDTH lanes and under the name KERNEL_TARGET.
#include "engine/cpu/add_samples.h"

#include <array>
#include <cstddef>
#include <type_traits>
#include <utility>

#include "engine/cpu/kinds.h"
#include "engine/cpu/seen_samples.h"
#include "support/targets.h"

namespace paradesc::kernels {
inline namespace KERNEL_TARGET {

// ---- Sums

template <class Wide> struct Adder {
  using Neighbor = typename Wide::Neighbor;
  Wide kernel;
  typename Wide::Sums sums;
  bool bending;

  // may_be_cut: the rim may cut some of the samples; if false, they lie within the ball.
  template <bool may_be_cut> [[gnu::always_inline]] void add(const FlatSample *const *samples, const SampleMap *const *maps) {
    const Seen seen(samples, sums.center.position);
    const float radius = kernel.params.radius;
    const Distances distances = distances_of(seen);
    Part part{seen.area, {0.0f, 0.0f}, 0.0f, {0.0f, 0.0f}};
    if constexpr (may_be_cut) part = clip_at(seen, distances, radius);
    if constexpr (requires { sums.center.value; })
      add_middles<may_be_cut>(seen, part, maps);
    else
      add_part<may_be_cut>(seen, distances, part);
  }

  // Adds a part by its mean position and the variation around it.
  template <bool may_be_cut>
  [[gnu::always_inline]] void add_part(const Seen &seen, const Distances &distances, const Part &part) {
    Neighbor neighbor;
    place<may_be_cut>(seen, part, neighbor);
    if constexpr (requires { sums.terms.bending; }) {
      neighbor.turning = 0.0f;
      if (bending) find_turning(seen, part, distances.corner, neighbor);
    }
    neighbor.inside = Wide::geodesic_ball || !may_be_cut ? part.area : part.area - strip_of(seen, part);
    kernel.add_weighted(sums, neighbor, Vector<4, Lanes>(Lanes(0.0f)));
    add_variance(seen, part, neighbor.distance);
  }

  // Adds a part by its edge midpoints, over which a quadratic has its mean. Operators sum the map times squared positions.
  template <bool may_be_cut> void add_middles(const Seen &seen, const Part &part, const SampleMap *const *maps) {
    constexpr float middles[3][2] = {{root2, 0.0f}, {-0.5f * root2, 0.5f * root6}, {-0.5f * root2, -0.5f * root6}};
    const Vector<4, Lanes> mean = gather<offsetof(SampleMap, mean)>(maps), first = gather<offsetof(SampleMap, along[0])>(maps),
                           second = gather<offsetof(SampleMap, along[1])>(maps);
    const Lanes extent = may_be_cut ? fast_sqrt(part.area * seen.per_area) : Lanes(1.0f);
    for (const float(&middle)[2] : middles) {
      const Lanes at[2] = {part.place[0] + extent * middle[0], part.place[1] + extent * middle[1]};
      Neighbor neighbor{};
      neighbor.offset = seen.at(at);
      neighbor.normal = seen.normal_at(at);
      neighbor.rho = fast_sqrt(square_of(neighbor.offset));
      neighbor.weight = part.area * (1.0f / 3.0f);
      kernel.add_weighted(sums, neighbor, mean + first * at[0] + second * at[1]);
    }
  }

  Distances distances_of(const Seen &seen) {
    Vector<3, Lanes> corners[3];
    find_corners(seen.offset, seen.along, corners);
    Distances distances;
    for (int k = 0; k < 3; ++k) distances.corner[k] = square_of(corners[k]);
    if constexpr (Wide::geodesic_ball) {
      Vector<3, Lanes> normals[3];
      find_corners(seen.normal, seen.normal_along, normals);
      for (int k = 0; k < 3; ++k) {
        Neighbor neighbor;
        neighbor.offset = corners[k];
        neighbor.rho = fast_sqrt(distances.corner[k]);
        neighbor.normal = normals[k];
        const Lanes geodesic = kernel.geodesic_distance(sums.center, neighbor);
        distances.corner[k] = geodesic * geodesic;
      }
    }
    const Lanes u = square_of(seen.along[0]), v = square_of(seen.along[1]), uv = dot(seen.along[0], seen.along[1]);
    const Lanes sum = 18.0f * u + 6.0f * v, gap = (6.0f * root2 * root6) * uv;
    distances.edge[0] = sum + gap;
    distances.edge[1] = 24.0f * v;
    distances.edge[2] = sum - gap;
    return distances;
  }

  // Returns the area at the rim that is within the radius in space, but not along the surface.
  Lanes strip_of(const Seen &seen, const Part &part) const {
    const float radius = kernel.params.radius;
    const Vector<3, Lanes> offset = seen.at(part.chord_place), normal = seen.normal_at(part.chord_place);
    const Lanes per_length = fast_inversesqrt(max(square_of(normal), 1e-30f));
    const Lanes bend = dot(normal * per_length - sums.center.normal, offset) * (1.0f / radius);
    const Lanes per_arc = seen.per_radius_of_arc(radius);
    const Lanes square = bend * bend * (1.0f / 24.0f), chord = min(part.chord * per_arc * per_arc, 4.0f);
    // The strip has (r^2 - r^2 / (1 + square)^2) / 2 per unit of angle, at most all of the disk in which the sample's plane cuts
    // the ball. The last factors are the angle of the chord.
    const Lanes strip = 0.5f * radius * radius * square * (2.0f + square) / ((1.0f + square) * (1.0f + square));
    return min(strip, 0.5f / (per_arc * per_arc)) * fast_sqrt(chord) * (1.0f + chord * (1.0f / 24.0f + 3.0f / 640.0f * chord));
  }

  [[gnu::always_inline]] Part clip_at(const Seen &seen, const Distances &distances, float radius) {
    const Lanes rim = radius * radius;
    const Lanes inside[3] = {rim - distances.corner[0], rim - distances.corner[1], rim - distances.corner[2]};
    const Choices in = inside[0] > 0.0f;
    Part part{mix(0.0f, seen.area, in), {0.0f, 0.0f}, 0.0f, {0.0f, 0.0f}};
    if (any((in != (inside[1] > 0.0f)) || (in != (inside[2] > 0.0f))))
      part = clip(seen, inside, distances.edge, seen.per_radius_of_arc(radius));
    if (any(seen.is_cluster)) {
      const Lanes of_corners[3] = {fast_sqrt(distances.corner[0]), fast_sqrt(distances.corner[1]),
                                   fast_sqrt(distances.corner[2])};
      part = mix(part, clip_cluster(seen, distance_to_mean(seen), of_corners, radius), seen.is_cluster);
    }
    return part;
  }

  Lanes distance_to_mean(const Seen &seen) {
    Neighbor neighbor;
    neighbor.offset = seen.offset;
    neighbor.normal = seen.normal;
    neighbor.rho = fast_sqrt(square_of(seen.offset));
    if constexpr (Wide::geodesic_ball) return kernel.geodesic_distance(sums.center, neighbor);
    return neighbor.rho;
  }

  // Lets the neighbor represent the part.
  template <bool may_be_cut> void place(const Seen &seen, const Part &part, Neighbor &neighbor) {
    neighbor.offset = may_be_cut ? seen.at(part.place) : seen.offset;
    neighbor.normal = may_be_cut ? seen.normal_at(part.place) : seen.normal;
    const Lanes square = square_of(neighbor.offset), share = part.area * seen.per_area;
    neighbor.rho = fast_sqrt(square);
    // The mean distance grows with the variance perpendicular to the offset.
    const Lanes u = dot(neighbor.offset, seen.along[0]), v = dot(neighbor.offset, seen.along[1]);
    const Lanes per_rho = fast_inversesqrt(max(square, 1e-30f));
    neighbor.mean_rho = fast_sqrt(square + share * max(seen.spread() - (u * u + v * v) * per_rho * per_rho, 0.0f));
    neighbor.geodesic = kernel.geodesic_distance(sums.center, neighbor);
    neighbor.distance = Wide::geodesic_ball ? neighbor.geodesic : neighbor.rho;
    neighbor.area = seen.area;
    neighbor.weight = part.area;
    neighbor.near = Choices{};
    neighbor.facet = seen.facet;
    neighbor.noise = mix(0.0f, seen.noise * (1.0f / (kernel.params.radius * kernel.params.radius)), part.area > 0.0f);
  }

  // Finds the mean of |n - n_i|^2/rho^2 over a part by four points that are spread over it, or over its quarters if it is nearer
  // to the center than it is long. squares: of the corners' distances.
  void find_turning(const Seen &seen, const Part &part, const Lanes *squares, Neighbor &neighbor) const {
    const float least = 1e-6f * kernel.params.radius * kernel.params.radius;
    const Lanes extent = fast_sqrt(part.area * seen.per_area);
    const auto mean_around = [&](float u, float v, float size) {
      Lanes sum = 0.0f;
      for (const float(&point)[2] : four_places) {
        const Lanes place[2] = {part.place[0] + extent * (u + size * point[0]), part.place[1] + extent * (v + size * point[1])};
        const Vector<3, Lanes> normal = seen.normal_at(place);
        sum += 0.25f * turning_of(normal * fast_inversesqrt(max(square_of(normal), 1e-12f)), seen.at(place), least);
      }
      return sum;
    };
    neighbor.turning = mean_around(0.0f, 0.0f, 1.0f);
    constexpr float close = 12.0f; // squared distance over squared extent
    const Choices is_near = square_of(seen.at(part.place)) < close * extent * extent * seen.spread();
    if (any(is_near)) {
      Lanes of_quarters = mean_around(0.0f, 0.0f, -0.5f);
      for (const float(&corner)[2] : corner_place) of_quarters += mean_around(0.5f * corner[0], 0.5f * corner[1], 0.5f);
      neighbor.turning = mix(neighbor.turning, 0.25f * of_quarters, is_near);
    }
    const Choices is_corner = squares[0] < least || squares[1] < least || squares[2] < least;
    if (any(is_corner)) neighbor.turning = mix(neighbor.turning, turning_at_corner(seen, squares, least), is_corner);
  }

  Lanes turning_of(const Vector<3, Lanes> &normal, const Vector<3, Lanes> &offset, float least) const {
    const Lanes root = fast_inversesqrt(max(square_of(offset), least));
    return square_of(normal - sums.center.normal) * root * root;
  }

  // Returns the mean if the center is a corner of the sample. Between linear normals it depends on the direction only then, and
  // is averaged along the opposite edge, by Gauss points on both sides of the bisector.
  Lanes turning_at_corner(const Seen &seen, const Lanes *squares, float least) const {
    const Choices at0 = squares[0] < least, at2 = squares[2] < least;
    const auto choose = [&](const Lanes &of0, const Lanes &of1, const Lanes &of2) { return mix(mix(of1, of2, at2), of0, at0); };
    const Lanes from_length = fast_sqrt(choose(squares[1], squares[2], squares[0]));
    const Lanes to_length = fast_sqrt(choose(squares[2], squares[0], squares[1]));
    const Lanes bisector = from_length / max(from_length + to_length, 1e-30f);
    Lanes sum = 0.0f;
    for (const float gauss : {0.21132487f, 0.78867513f})
      for (const auto &[start, size] : {std::pair(Lanes(0.0f), bisector), std::pair(bisector, 1.0f - bisector)}) {
        const Lanes along = start + gauss * size;
        Lanes place[2];
        for (int axis = 0; axis < 2; ++axis) {
          const auto corner = [&](int i) { return Lanes(corner_place[i][axis]); };
          const Lanes from = choose(corner(1), corner(2), corner(0)), to = choose(corner(2), corner(0), corner(1));
          place[axis] = from + along * (to - from);
        }
        sum += 0.5f * size * turning_of(seen.normal_at(place), seen.at(place), least);
      }
    return sum;
  }

  // Adds the variation within the parts to the moments of their mean positions and normals.
  void add_variance(const Seen &seen, const Part &part, const Lanes &distance) {
    const Lanes weight = part.area * part.area * seen.per_area;
    for (int k = 0; k < 2; ++k) {
      const Lanes x = dot(seen.along[k], sums.center.t1) * (1.0f / kernel.params.radius),
                  y = dot(seen.along[k], sums.center.t2) * (1.0f / kernel.params.radius);
      const Lanes turn_x = dot(seen.normal_along[k], sums.center.t1), turn_y = dot(seen.normal_along[k], sums.center.t2);
      const Vector<3, Lanes> xx = weight * Vector<3, Lanes>(x * x, x * y, y * y),
                             xy = weight * Vector<3, Lanes>(x * turn_x, x * turn_y + y * turn_x, y * turn_y);
      sums.moments.xx += xx;
      sums.moments.xy += xy;
      if constexpr (requires { sums.windows; }) kernel.add_to_windows(sums.windows, distance, xx, xy);
    }
  }
};

using LanesOfSums = float[max_sums][block_lanes];

// Stores the lanes of one pass at their place among all lanes. Returns the index of the next sum.
template <class Part> size_t store(const Part &part, int pass, LanesOfSums &sums, size_t at) {
  constexpr size_t count = sizeof(Part) / sizeof(Lanes);
  for (size_t i = 0; i < count; ++i)
    __builtin_memcpy(sums[at + i] + pass * lane_count, reinterpret_cast<const char *>(&part) + i * sizeof(Lanes), sizeof(Lanes));
  return at + count;
}

template <template <class, class> class Kernel>
void add_samples(const EvaluateParams &params, const SelectedSamples &samples, const SumCenter &center, float *sums) {
  using Wide = Kernel<Lanes, Choices>;
  alignas(64) LanesOfSums of_lanes;
  size_t count = 0;
  for (int pass = 0; pass < block_lanes / lane_count; ++pass) {
    const int first = pass * lane_count;
    Adder<Wide> adder{Wide{params}, {}, samples.bending};
    adder.kernel.sums_init(adder.sums, all(center.position), all(center.normal), center.value);
    const auto add_all = [&](const SampleRun &run, auto may_be_cut) {
      for (int32_t i = 0; i < run.blocks; ++i) {
        const FlatSample *some[lane_count];
        const SampleMap *maps[lane_count];
        for (int lane = 0; lane < lane_count; ++lane) {
          const int32_t item = run.item[i * block_lanes + first + lane];
          some[lane] = samples.sample[item];
          if constexpr (requires { adder.sums.center.value; }) maps[lane] = samples.map[item];
        }
        adder.template add<may_be_cut>(some, maps);
      }
    };
    add_all(samples.whole, std::bool_constant<Wide::geodesic_ball>());
    add_all(samples.cut, std::true_type());
    count = store(adder.sums.moments, pass, of_lanes, 0);
    if constexpr (requires { adder.sums.windows; }) count = store(adder.sums.windows, pass, of_lanes, count);
    count = store(adder.sums.terms, pass, of_lanes, count);
  }
  for (size_t i = 0; i < count; ++i) {
    std::array<float, block_lanes> lanes;
    __builtin_memcpy(&lanes, of_lanes[i], sizeof lanes);
    sums[i] = sum_of(lanes);
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

} // namespace KERNEL_TARGET
} // namespace paradesc::kernels

namespace paradesc {

PARADESC_TARGET(SumTarget, sums_of) = {PARADESC_TARGET_NAME, kernels::by_kind};

} // namespace paradesc
