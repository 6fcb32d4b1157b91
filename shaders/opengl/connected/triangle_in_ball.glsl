// The area that a triangle shares with the unit ball around the origin.
//
// The ball meets the triangle's plane in a disk. The area that a triangle shares with a disk around the origin is a sum over its
// edges of the signed area shared with the triangle from the origin to the edge: a straight part within the disk, and sectors.

// a, b: ends of an edge, in the plane through the origin with this normal. square: of the disk's radius.
float area_under_edge(vec3 normal, vec3 a, vec3 b, float square) {
  vec3 way = b - a;
  float size = dot(way, way), along = dot(a, way), root = sqrt(max(along * along - size * (dot(a, a) - square), 0.0));
  float first = clamp((-along - root) / size, 0.0, 1.0), last = clamp((-along + root) / size, 0.0, 1.0);
  vec3 into = a + first * way, out_of = a + last * way;
  // The angles beside the straight part, as complex numbers: the argument of their product is the sum of both angles.
  vec2 before = first > 0.0 ? vec2(dot(a, into), dot(normal, cross(a, into))) : vec2(1.0, 0.0);
  vec2 after = last < 1.0 ? vec2(dot(out_of, b), dot(normal, cross(out_of, b))) : vec2(1.0, 0.0);
  float angle = atan(before.y * after.x + before.x * after.y, before.x * after.x - before.y * after.y);
  return 0.5 * ((last - first) * dot(normal, cross(a, way)) + square * angle);
}

float triangle_in_ball(vec3 a, vec3 b, vec3 c) {
  vec3 twice = cross(b - a, c - a);
  float size = length(twice);
  if (max(max(dot(a, a), dot(b, b)), dot(c, c)) <= 1.0) return 0.5 * size;
  if (!(size > 0.0)) return 0.0;
  vec3 normal = twice / size;
  float height = dot(normal, a), square = 1.0 - height * height;
  if (square <= 0.0) return 0.0;
  a -= height * normal;
  b -= height * normal;
  c -= height * normal;
  return max(area_under_edge(normal, a, b, square) + area_under_edge(normal, b, c, square) + area_under_edge(normal, c, a, square), 0.0);
}

// The part of a triangle where the linear function with these values at its corners is below 0.
float part_below_zero(vec3 values) {
  bvec3 below = lessThan(values, vec3(0.0));
  if (below.x == below.y && below.y == below.z) return below.x ? 1.0 : 0.0;
  // The corner whose sign differs from the others' is cut off; its share of the area is the product of its shares of both sides.
  vec3 alone = below.y == below.z ? values.xyz : below.x == below.z ? values.yzx : values.zxy;
  float cut_off = alone.x * alone.x / ((alone.x - alone.y) * (alone.x - alone.z));
  return alone.x < 0.0 ? cut_off : 1.0 - cut_off;
}

// The part of a small triangle's area in the ball, to some 0.5 % of a disk over all triangles, treating the rim as straight
// within each. squares: of the corners' distances; sides: the sum of squared sides. Between corners, squared distances are below
// their linear interpolation: by a twelfth of that sum in the mean over a triangle.
float part_in_ball(vec3 squares, float sides) {
  return all(lessThanEqual(squares, vec3(1.0))) ? 1.0 : part_below_zero(squares - (1.0 + sides / 12.0));
}
