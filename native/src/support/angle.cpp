// An eighth of a turn is left of any angle, and half of that by tan(a - pi/4) = (t - 1) / (t + 1); there the series of the arc
// tangent ends soon.
#include "support/angle.h"

#include <algorithm>
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
  double sum = 0.0;
  for (int k = terms; k >= 0; --k) sum = 1.0 / (2 * k + 1) - square * sum;
  double angle = t * sum + (steep ? 0.25 * pi : 0.0);
  if (up > across) angle = 0.5 * pi - angle;
  if (x < 0.0) angle = pi - angle;
  return y < 0.0 ? -angle : angle;
}

} // namespace paradesc
