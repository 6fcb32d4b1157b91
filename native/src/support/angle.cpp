// Subtracts from any slope the nearest sixteenth c, by tan(a - atan(c)) = (t - c) / (1 + t c). The arc tangent's series converges
// quickly for the remaining slope.
#include "support/angle.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "support/math.h"

namespace paradesc {

// t - t³/3 + t⁵/5 ..., up to the term in t^(2 last + 1).
static constexpr double series(double t, int last) {
  const double square = t * t;
  double sum = 0.0;
  for (int k = last; k >= 0; --k) sum = 1.0 / (2 * k + 1) - square * sum;
  return t * sum;
}

static constexpr int parts = 16;

// Arc tangents of 0, 1/16 ... 1, each computed from the one before it.
static constexpr auto arc_tangents = [] {
  std::array<double, parts + 1> found{};
  for (int k = 1; k <= parts; ++k)
    found[static_cast<size_t>(k)] =
        found[static_cast<size_t>(k - 1)] + series(parts / static_cast<double>(parts * parts + k * (k - 1)), 6);
  found[parts] = 0.25 * pi;
  return found;
}();

double angle_of(double y, double x) {
  if (std::isunordered(x, y)) return x + y;
  const double across = std::fabs(x), up = std::fabs(y), longer = std::max(across, up);
  if (longer == 0.0) return 0.0;
  const double slope = std::min(across, up) / longer;
  if (std::isnan(slope)) return slope; // both are infinite
  const int part = static_cast<int>(parts * slope + 0.5);
  const double nearest = part / static_cast<double>(parts);
  constexpr int last = 4; // the remaining slope is at most 1/32, and 32^-11 / 11 is below 1e-17
  double angle = arc_tangents[static_cast<size_t>(part)] + series((slope - nearest) / (1.0 + slope * nearest), last);
  if (up > across) angle = 0.5 * pi - angle;
  if (x < 0.0) angle = pi - angle;
  return y < 0.0 ? -angle : angle;
}

} // namespace paradesc
