// The unit tangent along which the shape operator bends by k2. A direction has two signs: the largest component is positive.
vec3 principal_direction_min(Terms terms, Center center, Neighborhood neighborhood) {
  return positive_direction(neighborhood.direction_min);
}
