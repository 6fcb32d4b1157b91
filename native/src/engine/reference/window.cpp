// Moments of a window → the least-squares quadratic, Gaussian means and the tensor of gradients.
#include "engine/reference/window.h"

#include <array>
#include <cmath>

#include "kernel/limits.h"

namespace paradesc {

static constexpr double undefined = ReferenceWindow::undefined;

static double gaussian(double rho, double sigma) { return std::exp(-0.5 * rho * rho / (sigma * sigma)); }

static void add_to_quadratic(WindowMoments &moments, const WindowSample &sample) {
  const auto [x, y] = std::array{sample.coordinates.x, sample.coordinates.y};
  const dvec3 first(1, x, y), second(x * x, x * y, y * y);
  const double w = sample.weight;
  moments.area += w;
  moments.first_first += w * glm::outerProduct(first, first);
  moments.first_second += w * glm::outerProduct(first, second);
  moments.second_second += w * glm::outerProduct(second, second);
  moments.f_first += w * sample.value * first;
  moments.f_second += w * sample.value * second;
}

static void add_to_gaussians(WindowMoments &moments, const WindowSample &sample, double sigma) {
  const double w = sample.weight;
  const double narrow = w * gaussian(sample.rho, sigma / GAUSSIANS_RATIO), wide = w * gaussian(sample.rho, sigma);
  moments.narrow += narrow * dvec2(1, sample.value);
  moments.wide += wide * dvec2(1, sample.value);
  const dvec2 s = sample.slope;
  if (std::isnan(s.x)) return; // the gradient does not exist there
  moments.sloped += wide;
  moments.tensor += wide * dvec3(s.x * s.x, s.x * s.y, s.y * s.y);
}

void add_window_sample(WindowMoments &moments, const WindowSample &sample, double sigma) {
  if (sigma > 0)
    add_to_gaussians(moments, sample, sigma);
  else
    add_to_quadratic(moments, sample);
}

static bool fit_quadratic(const WindowMoments &moments, dvec3 &plane, dvec3 &quadratic) {
  const double area = moments.area;
  if (!(area > 0)) return false;
  const dmat3 a = moments.first_first / area, b = moments.first_second / area, d = moments.second_second / area;
  if (!(glm::determinant(a) > JET_LEAST_PLANE)) return false;
  const dmat3 inverse_a = glm::inverse(a), reduce = glm::transpose(b) * inverse_a, rest = d - reduce * b;
  if (!(glm::determinant(rest) > JET_LEAST_QUADRATIC)) return false;
  quadratic = glm::inverse(rest) * (moments.f_second - reduce * moments.f_first) / area;
  plane = inverse_a * (moments.f_first / area - b * quadratic);
  return true;
}

ReferenceWindow finish_window(const WindowMoments &moments, dvec3 tangent, dvec3 bitangent, double radius) {
  ReferenceWindow window;
  dvec3 plane(undefined), quadratic(undefined);
  if (!fit_quadratic(moments, plane, quadratic)) plane = quadratic = dvec3(undefined);
  window.gradient = (plane.y * tangent + plane.z * bitangent) / radius;
  window.laplacian = 2 * (quadratic.x + quadratic.z) / (radius * radius);
  window.narrow = moments.narrow.x > 0 ? moments.narrow.y / moments.narrow.x : undefined;
  window.wide = moments.wide.x > 0 ? moments.wide.y / moments.wide.x : undefined;
  window.tensor = moments.sloped > 0 ? moments.tensor / moments.sloped : dvec3(undefined);
  return window;
}

} // namespace paradesc
