// The size of a tile follows from the time that the last tile took.
#include "engine/paper/dispatch.h"

#include <algorithm>

#include "support/math.h"

#include "shared.h"

namespace paradesc {

int next_tile(int tile, double seconds, int smallest, int group) {
  const double scale = std::clamp(0.03 / std::max(seconds, 1e-4), 0.25, 4.0);
  return std::max(smallest, static_cast<int>(std::min(tile * scale, 1e9)) / group * group);
}

void dispatch_texels(const Gl &gl, int size) {
  constexpr int side = 8, first_tile = 1 << 20; // texels
  const int groups = (size + side - 1) / side, rows = std::max(1, first_tile / (size * side));
  in_tiles(
      0, groups, {rows, 1, groups, 1},
      [&](int first, int last) {
        gl.Uniform1i(LOCATION_FIRST, first * side);
        gl.DispatchCompute(static_cast<GLuint>(groups), static_cast<GLuint>(last - first), 1);
        if (last < groups) gl.Finish();
      },
      [](int) {});
}

} // namespace paradesc
