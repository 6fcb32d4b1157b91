// Counts of pieces at a few coarsenings → the least coarsening that makes few enough of them.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

namespace paradesc {

// Lengths are divided by it; 1 after no step.
float coarsening_after(int steps);

// The fewest steps after which a length is at most 1.
int steps_until_short(float length);

// How many pieces there are after so many steps; nothing if that is more than allowed, which may be told as soon as it is known.
using CountPieces = std::function<std::optional<int64_t>(int steps)>;

// The fewest steps after which there are at most that many pieces: between 0, after which there are more, and last, after which
// there are not. If more steps can make more pieces, then some number of steps that does it where one less does not. The last
// count that gave a number was of what is returned.
int fewest_steps(int64_t most, int last, const CountPieces &count);

} // namespace paradesc
