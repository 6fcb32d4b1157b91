// An eighth of a turn is left of any angle, and half of that by tan(a - pi/4) = (t - 1) / (t + 1); there the series of the arc
// tangent ends soon.
#include "support/angle.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "support/math.h"

namespace paradesc {

double angle_of(double y, double x) {
  if (std::isunordered(x, y)) return x + y;
  constexpr double eighth = 0.41421356237309503; // tan(pi / 8)
  constexpr int terms = 20;                      // eighth^(2 * 20 + 1) / 41 is below 1e-17
  const double across = std::fabs(x), up = std::fabs(y), longer = std::max(across, up);
  if (longer == 0.0) return 0.0;
  const double slope = std::min(across, up) / longer;
  const bool steep = slope > eighth;
  const double t = steep ? (slope - 1.0) / (slope + 1.0) : slope, square = t * t;
  static constexpr auto odd = [] {
    std::array<double, terms + 1> reciprocals{};
    for (int k = 0; k <= terms; ++k) reciprocals[static_cast<size_t>(k)] = 1.0 / (2 * k + 1);
    return reciprocals;
  }();
  // Four chains, each of every fourth term: processors work at them side by side.
  const double second = square * square, fourth = second * second;
  std::array<double, 4> sums{};
  for (int k = terms; k >= 0; --k) {
    double &sum = sums[static_cast<size_t>(k % 4)];
    sum = odd[static_cast<size_t>(k)] + fourth * sum;
  }
  const double sum = (sums[0] - square * sums[1]) + second * (sums[2] - square * sums[3]);
  double angle = t * sum + (steep ? 0.25 * pi : 0.0);
  if (up > across) angle = 0.5 * pi - angle;
  if (x < 0.0) angle = pi - angle;
  return y < 0.0 ? -angle : angle;
}

} // namespace paradesc
