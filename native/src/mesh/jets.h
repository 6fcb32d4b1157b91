// Heights of a fan's neighbors over its tangent plane → the gradient of a jet there, and the noise that it leaves, several fans
// at a time.
//
// Jets: F. Cazals, M. Pouget, "Estimating differential quantities using polynomial fitting of osculating jets", 2003.
#pragma once

#include <cstddef>
#include <vector>

namespace paradesc {

inline constexpr int max_neighbors = 96;

// Several fans at a time, one in each lane; lanes do not depend on each other.
inline constexpr int fan_lanes = 8;
using FanLanes [[gnu::vector_size(fan_lanes * sizeof(double))]] = double;

// The neighbors of one fan per lane, as heights w over Max's tangent plane. After a lane's last neighbor come zeros, which change
// no sum.
struct Heights {
  int count[fan_lanes] = {};
  size_t max_count = 0;
  FanLanes u[max_neighbors], v[max_neighbors], w[max_neighbors];
};

// The gradient at the origin of the height function through it; exists is false if the neighbors do not determine it.
struct Gradients {
  bool exists[fan_lanes];
  double u[fan_lanes], v[fan_lanes];
  double noise[fan_lanes]; // variance of the heights around the jet
};

// Blends the cubic jet into the quadratic one as far as the cubic terms explain more than noise would: the quadratic jet has a
// third of the cubic jet's noise. F is the ratio of Fisher's test of the larger model, about 1 if the terms explain nothing; the
// shrinkage 1 - c/F is James and Stein's.
using FitGradients = void (*)(const Heights &heights, Gradients &gradients);
// The functions for the instruction sets that this processor has, the widest first.
std::vector<FitGradients> jet_targets();

} // namespace paradesc
