// Counts of pieces at a few coarsenings → the least coarsening that makes few enough of them.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

namespace paradesc {

// The divisor of all lengths after so many steps; it is 1 after none.
float coarsening_after(int steps);

// The fewest steps after which a length is at most 1.
int steps_until_short(float length);

// Piece count after `steps` coarsenings, or nullopt as soon as it is known to exceed the limit.
using CountPieces = std::function<std::optional<int64_t>(int steps)>;

// The fewest steps, in (0, last], after which there are at most `most` pieces. Zero steps must give more, and `last` steps must
// not. If the count is not monotonic, the result is some number of steps that suffices where one step less does not. The last
// call of count() that returned a number was for the result.
int fewest_steps(int64_t most, int last, const CountPieces &count);

} // namespace paradesc
