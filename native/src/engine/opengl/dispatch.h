// Work over many invocations → dispatches that each take a device a fraction of a second, however fast it is.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "engine/opengl/gl.h"
#include "support/progress.h"

namespace paradesc {

// How many invocations the next dispatch may have, if the last had `tile` and took so long: some 30 ms of them. A desktop's
// driver starts a device again that is busy for two seconds, and computations are cancelled between dispatches. At least
// `smallest`, in whole groups.
int next_tile(int tile, double seconds, int smallest, int group);

// Of a computation's tiles: the first one, before it is known how long it takes; what all of them lie between; and what they are
// multiples of.
struct TileSizes {
  int first, smallest, largest, group;
  std::optional<double> seconds = {}; // that each takes, as tests say; else they are measured
};

// Calls compute(begin, end), which returns when the device has finished, for one tile of [begin, end) after the other, and
// then(end of the tile), whose time does not count. Returns what the first tile may be when the same is computed again: what is
// left for the last one may be so little that its time tells nothing but that it is not too much.
template <class Compute, class Then>
int in_tiles(int begin, int end, const TileSizes &sizes, const Compute &compute, const Then &then) {
  int tile = std::min(sizes.first, sizes.largest);
  for (int last = begin; begin < end; begin = last) {
    last = begin + std::min(tile, end - begin);
    Clock clock;
    compute(begin, last);
    const double seconds = sizes.seconds.value_or(clock.lap());
    const int next = std::min(next_tile(tile, seconds, sizes.smallest, sizes.group), sizes.largest);
    if (last - begin == tile || next < tile) tile = next;
    then(last);
  }
  return tile;
}

// Runs the program in use over invocations [first, last) in one dispatch, which knows them by LOCATION_FIRST and LOCATION_LAST.
void dispatch_once(const Gl &gl, int first, int last);

// The same over `count` invocations, in as many dispatches as it takes; first_tile: of the first one, before it is known how long
// they take.
void dispatch_invocations(const Gl &gl, int count, int64_t first_tile);

// The same over the texels of a square buffer, some rows of groups of 8 x 8 a dispatch: LOCATION_FIRST is the row that it begins
// with.
void dispatch_texels(const Gl &gl, int size);

} // namespace paradesc
