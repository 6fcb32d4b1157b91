// Compares distances of surfels and of edges with the radius.
#include "engine/cpu/ball_edges.h"

#include <algorithm>

namespace paradesc {

float BallEdges::square_to(int32_t surfel, vec3 center) const {
  const vec3 gap = surfels.surfel[surfel].position - center;
  return dot(gap, gap);
}

bool BallEdges::lies_within(int32_t surfel, vec3 center) const {
  const float room = surfels.radius - surfels.surfel[surfel].reach;
  return room > 0.0f && square_to(surfel, center) < room * room;
}

bool meets_ball(vec3 a, vec3 b, float radius) {
  const float square = radius * radius, of_a = dot(a, a) - square, of_b = dot(b, b) - square;
  if (of_a < 0.0f || of_b < 0.0f) return true;
  const vec3 way = b - a;
  const float along = -dot(a, way), length = dot(way, way);
  return along > 0.0f && along < length && of_a * length < along * along;
}

bool BallEdges::meets(int32_t half_edge, vec3 center) const {
  return meets_ball(source.position(half_edge) - center, source.position(next_corner(half_edge)) - center, surfels.radius);
}

bool BallEdges::meets_between(int32_t neighbor, vec3 center) const {
  const int32_t *const edge = surfels.edge.data();
  return std::any_of(edge + surfels.edge_begin[neighbor], edge + surfels.edge_begin[neighbor + 1],
                     [&](int32_t half_edge) { return meets(half_edge, center); });
}

} // namespace paradesc
