// GA (paper eq. 11 to 14): the area of the surface within r along it.
float geodesic_area(Terms terms, Center center, Neighborhood neighborhood) {
  return neighborhood.area > 0.0f ? area_finish(terms.area, terms.area.inside, neighborhood) : NOT_A_NUMBER;
}
