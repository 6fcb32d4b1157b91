// (2/pi) atan2(k1 + k2, k1 - k2): paper eq. (9), with the sign that makes convex positive. It is undefined on a plane.
float shape_index(Terms terms, Center center, Neighborhood neighborhood) {
  if (!(max(abs(neighborhood.k1), abs(neighborhood.k2)) * neighborhood.radius >= float(PLANE_THRESHOLD))) return NOT_A_NUMBER;
  return 2.0f / PI * atan(neighborhood.k1 + neighborhood.k2, neighborhood.k1 - neighborhood.k2);
}
