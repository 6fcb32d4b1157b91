// The unit tangent along which the shape operator bends by k1. A direction has two signs: the largest component is positive.
vec3 principal_direction_max(Terms terms, Center center, Neighborhood neighborhood) {
  return positive_direction(neighborhood.direction_max);
}
