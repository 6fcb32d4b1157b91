// The piece count is roughly quadratic in length, so a cheap count at a large coarsening predicts the coarsening wanted. Guesses
// approach from that side, where counts are small: a count that runs into the limit takes as long as the limit is high.
#include "mesh/coarsening.h"

#include <algorithm>

namespace paradesc {

static constexpr float step = 1.25f;

float coarsening_after(int steps) {
  float coarsening = 1.0f;
  for (; steps > 0; --steps) coarsening *= step;
  return coarsening;
}

int steps_until_short(float length) {
  int steps = 0;
  for (float coarsening = 1.0f; coarsening < length; coarsening *= step) ++steps;
  return steps;
}

// Predicts how many steps finer still stay within `most`, assuming that the piece count grows with the square of the length.
static int steps_left(int64_t pieces, int64_t most) {
  constexpr double growth = static_cast<double>(step) * static_cast<double>(step);
  int steps = 0;
  for (double grown = growth * static_cast<double>(std::max<int64_t>(pieces, 1)); grown <= static_cast<double>(most);
       grown *= growth)
    ++steps;
  return steps;
}

// Strides grow with every try, so that the search ends in bisection where the predictions are poor.
int fewest_steps(int64_t most, int last, const CountPieces &count) {
  int too_few = 0, enough = last;
  int64_t pieces = count(last).value();
  for (int tries = 0; enough - too_few > 1; ++tries) {
    const int stride = 1 << tries / 2, guess = enough - std::max(stride, steps_left(pieces, most));
    int steps = guess > too_few ? guess : too_few + stride;
    if (steps >= enough) steps = (too_few + enough) / 2;
    if (const std::optional<int64_t> counted = count(steps)) {
      enough = steps;
      pieces = *counted;
    } else {
      too_few = steps;
    }
  }
  return enough;
}

} // namespace paradesc
