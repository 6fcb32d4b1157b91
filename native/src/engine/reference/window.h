// Quadrature points of one neighborhood with a map on them → the inputs of the operators' definitions.
#pragma once

#include <limits>

#include "support/math.h"

namespace paradesc {

struct WindowSample {
  dvec2 coordinates; // tangent coordinates of d = q - p, in units of r
  double rho;        // |d|
  double value;      // f - f(p)
  dvec2 slope;       // r grad f in the tangent plane of p; NaN if it is undefined
  double weight;
};

// Sums over samples. first: 1, x, y; second: xx, xy, yy.
struct WindowMoments {
  double area = 0;
  dmat3 first_first{0}, first_second{0}, second_second{0};
  dvec3 f_first{0}, f_second{0};
  dvec2 narrow{0}, wide{0}; // Gaussians of sigma/GAUSSIANS_RATIO and sigma: integral, and integral times f
  double sloped = 0;        // integral of the wide Gaussian where f has a slope
  dvec3 tensor{0};          // integral of the wide Gaussian times slope slope^T: xx, xy, yy
};
// sigma 0: sums for the quadratic; else for Gaussian windows. No pass needs both.
void add_window_sample(WindowMoments &moments, const WindowSample &sample, double sigma);

// Members are NaN if they are undefined; all are without a map.
struct ReferenceWindow {
  static constexpr double undefined = std::numeric_limits<double>::quiet_NaN();
  dvec3 gradient{undefined};                   // of the least-squares quadratic of f, in object space
  double laplacian = undefined;                // trace of its Hessian
  double narrow = undefined, wide = undefined; // means of f - f(p) in the windows
  dvec3 tensor{undefined};                     // mean of (r grad f)(r grad f)^T in the wide one
  double harris_k = 0;
};
ReferenceWindow finish_window(const WindowMoments &moments, dvec3 tangent, dvec3 bitangent, double radius);

} // namespace paradesc
