// A triangle whose points move along their normals, p + n h → its edges, its normal and the ratio of its areas. Compiled as GLSL
// for texels and as C++ for vertices.
struct Displaced {
  vec3 edge1; // from corner 0, as displaced
  vec3 edge2;
  vec3 normal;
  float area_ratio;
};

vec3 unit_or(vec3 v, vec3 other) {
  float span = length(v);
  return span > 0.0f ? v / span : other;
}

vec3 without_normal(vec3 v, vec3 n) { return v - n * dot(n, v); }

// The change of an edge by displacement. Along the edge the interpolated normal, of length span, changes by `turn`, and (u, v) by
// `way`. height: h and its gradient by (u, v).
vec3 change_of_edge(vec3 turn, vec2 way, vec3 n, float span, vec3 height) {
  return without_normal(turn, n) * (height.x / span) + n * dot(vec2(height.y, height.z), way);
}

Displaced displace(vec3 edge1, vec3 edge2, vec3 change1, vec3 change2, vec3 n) {
  Displaced result;
  result.edge1 = edge1 + change1;
  result.edge2 = edge2 + change2;
  vec3 t1 = without_normal(edge1, n), t2 = without_normal(edge2, n);
  float side = dot(cross(t1, t2), n) < 0.0f ? -1.0f : 1.0f;
  float base = length(cross(edge1, edge2));
  result.normal = unit_or(side * cross(t1 + change1, t2 + change2), n);
  result.area_ratio = base > 0.0f ? length(cross(result.edge1, result.edge2)) / base : 1.0f;
  return result;
}
