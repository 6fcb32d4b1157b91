// Work over many invocations → dispatches that each take a device a fraction of a second, however fast it is.
#pragma once

#include <cstdint>

#include "engine/opengl/gl.h"

namespace paradesc {

// How many invocations the next dispatch may have, if the last had `tile` and took so long: some 30 ms of them. A desktop's
// driver starts a device again that is busy for two seconds, and computations are cancelled between dispatches. At least
// `smallest`, in whole groups.
int next_tile(int tile, double seconds, int smallest, int group);

// Runs the program in use over invocations [first, last) in one dispatch, which knows them by LOCATION_FIRST and LOCATION_LAST.
void dispatch_once(const Gl &gl, int first, int last);

// The same over `count` invocations, in as many dispatches as it takes; first_tile: of the first one, before it is known how long
// they take.
void dispatch_invocations(const Gl &gl, int count, int64_t first_tile);

// The same over the texels of a square buffer, some rows of groups of 8 x 8 a dispatch: LOCATION_FIRST is the row that it begins
// with.
void dispatch_texels(const Gl &gl, int size);

} // namespace paradesc
