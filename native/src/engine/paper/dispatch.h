// Work over many invocations → dispatches that each take a device a fraction of a second, on fast and slow devices alike.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "engine/paper/gl.h"
#include "support/progress.h"

namespace paradesc {

// The number of invocations for the next dispatch, if `tile` of them took `seconds`: it aims at some 30 ms. A desktop's driver
// resets a device that is busy for two seconds, and computations are cancelled between dispatches. The result is at least
// `smallest`, in whole groups.
int next_tile(int tile, double seconds, int smallest, int group);

// Sizes of a computation's tiles: the first one, before any time is known; the limits of all; and the number that they are
// multiples of.
struct TileSizes {
  int first, smallest, largest, group;
  std::optional<double> seconds = {}; // the time of each tile if tests set it; otherwise it is measured
};

// Calls compute(begin, end), which returns when the device has finished, for one tile of [begin, end) after another. After each
// it calls then(end of the tile), whose time does not count.
template <class Compute, class Then>
void in_tiles(int begin, int end, const TileSizes &sizes, const Compute &compute, const Then &then) {
  int tile = std::min(sizes.first, sizes.largest);
  for (int last = begin; begin < end; begin = last) {
    last = begin + std::min(tile, end - begin);
    Clock clock;
    compute(begin, last);
    const double seconds = sizes.seconds.value_or(clock.lap());
    tile = std::min(next_tile(tile, seconds, sizes.smallest, sizes.group), sizes.largest);
    then(last);
  }
}

// Runs the program in use over the texels of a square buffer, some rows of 8 x 8 groups per dispatch. LOCATION_FIRST is the first
// row of a dispatch.
void dispatch_texels(const Gl &gl, int size);

} // namespace paradesc
