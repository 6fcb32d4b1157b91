// Neighborhoods written down neighbor by neighbor, and every kernel's values there by C++: one neighbor at a time, and eight.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "descriptor/registry.h"

#define KERNEL ShapeOperatorKernel
#define INTEGRAL 0
#define EXTRAPOLATED 0
#define GEODESIC_BALL 0
#define FACES 1
#define MAP 1
#include "engine/kernels/kernels.h"
#undef KERNEL
#undef INTEGRAL
#undef GEODESIC_BALL
#define KERNEL IntegralKernel
#define INTEGRAL 1
#define GEODESIC_BALL 1
#include "engine/kernels/kernels.h"
#undef KERNEL
#undef INTEGRAL
#undef EXTRAPOLATED
#undef GEODESIC_BALL
#undef FACES
#define KERNEL ExtrapolatedKernel
#define INTEGRAL 0
#define EXTRAPOLATED 1
#define GEODESIC_BALL 0
#define FACES 0
#include "engine/kernels/kernels.h"
#undef KERNEL
#undef INTEGRAL
#undef EXTRAPOLATED
#undef GEODESIC_BALL
#undef FACES
#undef MAP

namespace paradesc::test {

struct RecordedNeighbor {
  vec3 position, normal, face;
  float area, geodesic; // below 0: unknown
  bool near;
  vec4 map; // gradient, value
};

struct Recorded {
  std::string name;
  vec3 position{0.0f}, normal{0.0f, 0.0f, 1.0f};
  float value = 0.0f; // of the map
  float hits_boundary = 0.0f;
  std::vector<RecordedNeighbor> neighbors;
};

inline constexpr float nowhere = std::numeric_limits<float>::quiet_NaN();
inline EvaluateParams recorded_params() {
  EvaluateParams params{};
  params.radius = params.map_radius = 0.1f;
  params.variate_share = 1.0f;
  params.map_sigma = 0.05f;
  params.harris_k = 0.04f;
  return params;
}

// A patch z = (a x^2 + b y^2)/2 + c x y, by a spiral of so many neighbors over a little more than the ball, under a map that
// waves.
inline Recorded record(const std::string &name, float a, float b, float c, int count) {
  Recorded recorded{.name = name, .neighbors = {}};
  recorded.value = 0.3f;
  const double outer = 1.25 * 0.1, share = std::numbers::pi * outer * outer / std::max(count, 1);
  for (int i = 0; i < count; ++i) {
    const double away = outer * std::sqrt((i + 0.5) / count), angle = 2.399963 * i;
    const auto x = static_cast<float>(away * std::cos(angle)), y = static_cast<float>(away * std::sin(angle));
    const vec3 steep(-(a * x + c * y), -(b * y + c * x), 1.0f);
    const vec3 turned = steep + vec3(0.01f * std::sin(40.0f * x), 0.01f * std::cos(30.0f * y), 0.0f);
    recorded.neighbors.push_back(
        {.position = {x, y, 0.5f * (a * x * x + b * y * y) + c * x * y},
         .normal = normalize(steep),
         .face = normalize(turned),
         .area = static_cast<float>(share) * length(steep),
         .geodesic = i % 3 == 0 ? 1.01f * static_cast<float>(away) : -1.0f,
         .near = away < 0.01,
         .map = {8.0f * std::cos(8.0f * x), 3.0f, 0.5f, 0.3f + std::sin(8.0f * x) + 3.0f * y + 20.0f * x * y}});
  }
  return recorded;
}

inline std::vector<Recorded> recorded_neighborhoods() {
  std::vector<Recorded> all = {record("cap", -3.0f, -2.5f, 0.0f, 200),       record("cup", 2.0f, 2.5f, 0.3f, 117),
                               record("saddle", 4.0f, -3.0f, 1.0f, 64),      record("ridge", -5.0f, 0.0f, 0.0f, 93),
                               record("plane", 0.0f, 0.0f, 0.0f, 64),        record("three neighbors", -3.0f, 1.0f, 0.0f, 3),
                               record("one neighbor", -3.0f, 1.0f, 0.0f, 1), record("nothing", 0.0f, 0.0f, 0.0f, 0)};
  Recorded cut = record("cut", -3.0f, -2.0f, 0.0f, 150);
  std::erase_if(cut.neighbors, [](const RecordedNeighbor &neighbor) { return neighbor.position.x > 0.03f; });
  cut.hits_boundary = 1.0f;
  Recorded holes = record("map with holes", -3.0f, -2.0f, 0.0f, 150);
  for (size_t i = 0; i < holes.neighbors.size(); i += 4) holes.neighbors[i].map.w = nowhere;
  for (size_t i = 1; i < holes.neighbors.size(); i += 5) holes.neighbors[i].map.x = nowhere;
  Recorded without = record("no map at the center", -3.0f, -2.0f, 0.0f, 150);
  without.value = nowhere;
  Recorded at_center = record("a neighbor at the center", 3.0f, -2.0f, 0.5f, 80);
  at_center.neighbors.push_back(at_center.neighbors.front());
  at_center.neighbors.back().position = vec3(0.0f);
  at_center.neighbors.back().normal = vec3(0.0f, 0.0f, 1.0f);
  for (const Recorded &one : {cut, holes, without, at_center}) all.push_back(one);
  for (Recorded &one : all) { // somewhere, upside down
    one.normal = vec3(0.0f, 0.0f, -1.0f);
    one.position = vec3(0.2f, -0.4f, 0.1f);
    for (RecordedNeighbor &neighbor : one.neighbors) {
      auto turn = [](vec3 v) { return vec3(v.y, v.x, -v.z); };
      neighbor.position = one.position + turn(neighbor.position);
      neighbor.normal = turn(neighbor.normal);
      neighbor.face = turn(neighbor.face);
      neighbor.map = vec4(turn(vec3(neighbor.map)), neighbor.map.w);
    }
  }
  return all;
}

// The usual size of each value of every row: the radius to the power of its unit, for a map whose values are about 1.
inline std::vector<double> usual_values() {
  std::vector<double> usual;
  for (int row = 0; row <= gradient_row(); ++row)
    usual.insert(usual.end(), static_cast<size_t>(descriptor_row(row).components),
                 std::pow(0.1, descriptor_row(row).length_power));
  return usual;
}

inline void put(std::vector<float> &values, float value) { values.push_back(value); }
inline void put(std::vector<float> &values, const kernels::Vector<3, float> &value) {
  values.insert(values.end(), {value.x, value.y, value.z});
}

// Values of every row of the registry, one after the other.
template <class Kernel> std::vector<float> finish_all(Kernel &kernel, const typename Kernel::Sums &sums) {
  const auto neighborhood = kernel.finish_neighborhood(sums, 1.0f);
  std::vector<float> values;
#define DESCRIPTOR(name, ...) put(values, kernel.name(sums.terms, sums.center, neighborhood));
#define OPERATOR(name, ...) put(values, kernel.name(sums.terms, sums.center, neighborhood));
#include "descriptor/descriptors.def"
#include "descriptor/operators.def"
#undef OPERATOR
#undef DESCRIPTOR
  return values;
}

template <class T> kernels::Vector<3, T> as(vec3 v) { return {v.x, v.y, v.z}; }

template <template <class, class> class Kernel> std::vector<float> one_at_a_time(const Recorded &recorded) {
  Kernel<float, bool> kernel{recorded_params()};
  typename Kernel<float, bool>::Sums sums;
  kernel.sums_init(sums, as<float>(recorded.position), as<float>(recorded.normal), recorded.value);
  sums.moments.hits_boundary = recorded.hits_boundary;
  for (const RecordedNeighbor &neighbor : recorded.neighbors)
    kernel.add_neighbor(sums, as<float>(neighbor.position), as<float>(neighbor.normal), as<float>(neighbor.face), neighbor.area,
                        neighbor.near, neighbor.geodesic, {neighbor.map.x, neighbor.map.y, neighbor.map.z, neighbor.map.w});
  return finish_all(kernel, sums);
}

// Lanes of the last eight that are left over have no area.
template <template <class, class> class Kernel> std::vector<float> eight_at_a_time(const Recorded &recorded) {
  using kernels::Choices, kernels::Lanes, kernels::lane_count;
  Kernel<Lanes, Choices> wide{recorded_params()};
  typename Kernel<Lanes, Choices>::Sums sums;
  wide.sums_init(sums, as<Lanes>(recorded.position), as<Lanes>(recorded.normal), recorded.value);
  for (size_t first = 0; first < recorded.neighbors.size(); first += lane_count) {
    const auto neighbor = [&](size_t i) {
      const size_t last = recorded.neighbors.size() - 1;
      RecordedNeighbor found = recorded.neighbors[std::min(first + i, last)];
      if (first + i > last) found.area = 0.0f;
      return found;
    };
    const auto lanes = [&](const auto &of) {
      Lanes result;
      for (size_t i = 0; i < lane_count; ++i) result.lane[i] = of(neighbor(i));
      return result;
    };
    const auto vectors = [&](vec3 RecordedNeighbor::*member) {
      return kernels::Vector<3, Lanes>(lanes([&](const RecordedNeighbor &p) { return (p.*member).x; }),
                                       lanes([&](const RecordedNeighbor &p) { return (p.*member).y; }),
                                       lanes([&](const RecordedNeighbor &p) { return (p.*member).z; }));
    };
    const Lanes area = lanes([](const RecordedNeighbor &p) { return p.area; });
    Choices near;
    for (size_t i = 0; i < lane_count; ++i) near.lane[i] = neighbor(i).near ? -1 : 0;
    wide.add_neighbor(
        sums, vectors(&RecordedNeighbor::position), vectors(&RecordedNeighbor::normal), vectors(&RecordedNeighbor::face), area,
        near, lanes([](const RecordedNeighbor &p) { return p.geodesic; }),
        {lanes([](const RecordedNeighbor &p) { return p.map.x; }), lanes([](const RecordedNeighbor &p) { return p.map.y; }),
         lanes([](const RecordedNeighbor &p) { return p.map.z; }), lanes([](const RecordedNeighbor &p) { return p.map.w; })});
  }
  using Narrow = Kernel<float, bool>;
  Narrow kernel{recorded_params()};
  typename Narrow::Sums together;
  kernel.sums_init(together, as<float>(recorded.position), as<float>(recorded.normal), recorded.value);
  together.moments = kernels::add_lanes<typename Narrow::Moments>(sums.moments);
  together.terms = kernels::add_lanes<typename Narrow::Terms>(sums.terms);
  if constexpr (requires { together.windows; })
    together.windows = kernels::add_lanes<typename Narrow::Windows>(sums.windows);
  together.moments.hits_boundary = recorded.hits_boundary;
  return finish_all(kernel, together);
}

} // namespace paradesc::test
