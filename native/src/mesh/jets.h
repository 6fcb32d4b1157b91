// Heights of a fan's neighbors over its tangent plane → the gradient of a jet there, several fans at a time.
//
// Jets: F. Cazals, M. Pouget, "Estimating differential quantities using polynomial fitting of osculating jets", 2003.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "support/math.h"

namespace paradesc {

inline constexpr int max_neighbors = 96;

// Several fans at a time, one in each lane; lanes do not depend on each other.
inline constexpr size_t lane_count = 4;
using Lanes [[gnu::vector_size(lane_count * sizeof(double))]] = double;

// The neighbors of a fan in each lane as heights w over Max's tangent plane; behind its last neighbor a lane has zeros, which
// change no sum.
struct Heights {
  std::array<int, lane_count> count{};
  size_t max_count = 0;
  std::array<Lanes, max_neighbors> u, v, w;
};

// The gradient at the origin of the height function through it; none where neighbors do not determine it. Cubic terms take part
// as far as they explain more than noise would: the quadratic jet has three times less of that. F is the ratio of Fisher's test
// of the larger model, about 1 where the terms explain nothing; shrinking by 1 - c/F is James and Stein's.
std::array<std::optional<dvec2>, lane_count> fit_gradients(const Heights &heights);

} // namespace paradesc
