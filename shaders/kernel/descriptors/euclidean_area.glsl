// EA (paper eq. 13, 14): the area of the surface within the neighborhood.
float euclidean_area(Terms terms, Center center, Support support) {
  return area_finish(terms.area, support.area / support.scale, support);
}
