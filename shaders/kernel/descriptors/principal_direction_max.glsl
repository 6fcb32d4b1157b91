// The unit tangent along which the shape operator bends by k1. A direction has two signs: the largest component is positive.
vec3 principal_direction_max(Terms terms, Center center, Support support) {
  return positive_direction(support.direction_max);
}
