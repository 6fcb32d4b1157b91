// How far normals lie from those that the shape operator says, as a root mean square: an angle where it is small.
float roughness(Terms terms, Center center, Neighborhood neighborhood) {
  return neighborhood.roughness;
}
