// Paper eq. (5): the mean of |n - n_i|^2/rho^2. With the shape operator as control variate, only the part that |S e|^2 does not
// explain is averaged, and the exact mean (k1^2 + k2^2)/2 of |S e|^2 is added.
float local_bending_energy(Terms terms, Center center, Neighborhood neighborhood) {
#if VARIATE
  float weight = terms.bending.moments.x + terms.bending.moments.z;
#else
  float weight = terms.bending.weight;
#endif
  if (!(weight > 0.0f)) return NOT_A_NUMBER;
#if VARIATE
  if (!(neighborhood.variate > 0.0f)) return terms.bending.energy / weight;
  float explained = normal_curvature(square(neighborhood.shape), terms.bending.moments) / weight;
  float exact = exact_means(neighborhood).x;
  return max(terms.bending.energy / weight + neighborhood.variate * (exact - explained), 0.0f);
#else
  return terms.bending.energy / weight;
#endif
}
