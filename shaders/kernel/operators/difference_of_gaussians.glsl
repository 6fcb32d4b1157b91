// The mean of f in a Gaussian window of sigma/1.6 less that in a window of sigma. On a full disk the slope of f contributes
// nothing to either mean, so its contribution to sums over points is removed. Over triangles there is next to nothing to remove.
float difference_of_gaussians(Terms terms, Center center, Neighborhood neighborhood) {
  vec4 narrow = terms.gaussians.narrow, wide = terms.gaussians.wide;
  if (!(narrow.x > 0.0f) || !(wide.x > 0.0f)) return NOT_A_NUMBER;
  vec3 difference =
      vec3(narrow.y, narrow.z, narrow.w) / narrow.x - vec3(wide.y, wide.z, wide.w) / wide.x;
#ifndef WIDE_NEIGHBORS
  Jet jet = jet_finish(terms.jet);
  if (neighborhood.variate > 0.0f && jet.exists)
    difference.x -= neighborhood.variate * (jet.plane.y * difference.y + jet.plane.z * difference.z);
#endif
  return difference.x;
}
