// Tests which surfels, and which edges between them, meet a ball of the surfels' radius.
#pragma once

#include "engine/cpu/surfels.h"

namespace paradesc {

bool meets_ball(vec3 a, vec3 b, float radius); // the edge from a to b, relative to the ball's center

struct BallEdges {
  const SurfelSource &source;
  const Surfels &surfels;

  float square_to(int32_t surfel, vec3 center) const;  // squared distance of its position
  bool lies_within(int32_t surfel, vec3 center) const; // true: all of its edges lie there, too
  bool meets(int32_t half_edge, vec3 center) const;
  bool meets_between(int32_t neighbor, vec3 center) const; // any edge to this entry of Surfels::neighbor
};

} // namespace paradesc
