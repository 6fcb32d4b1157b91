// EA (paper eq. 13, 14): the area of the surface within the neighborhood.
float euclidean_area(Terms terms, Center center, Neighborhood neighborhood) {
  return area_finish(terms.area, neighborhood.area / neighborhood.scale, neighborhood);
}
