/* A torus by sums, products, quotients and square roots alone, which have the same bits everywhere. */
#ifndef PARADESC_TESTS_TORUS_H
#define PARADESC_TESTS_TORUS_H

/* The place at i of n on a circle, by a rational parametrization of each half. */
static void on_circle(int i, int n, double *x, double *y) {
  const double t = -1.0 + 4.0 * (i % (n / 2)) / n, sign = i < n / 2 ? 1.0 : -1.0;
  *x = sign * (1.0 - t * t) / (1.0 + t * t);
  *y = sign * 2.0 * t / (1.0 + t * t);
}

/* The point at i of `around` and j of `across`. */
static void on_torus(int i, int around, int j, int across, float *position) {
  double x, y, u, v;
  on_circle(i, around, &x, &y);
  on_circle(j, across, &u, &v);
  position[0] = (float)((1.0 + 0.4 * u) * x);
  position[1] = (float)((1.0 + 0.4 * u) * y);
  position[2] = (float)(0.4 * v);
}

#endif
