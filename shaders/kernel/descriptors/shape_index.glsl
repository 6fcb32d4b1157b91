// (2/pi) atan2(k1 + k2, k1 - k2): paper eq. (9), turned so that convex is positive. A plane has none.
float shape_index(Terms terms, Center center, Support support) {
  if (!(max(abs(support.k1), abs(support.k2)) * support.radius >= float(PLANE_THRESHOLD))) return NOT_A_NUMBER;
  return 2.0f / PI * atan(support.k1 + support.k2, support.k1 - support.k2);
}
