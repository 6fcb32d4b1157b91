// Neighbors → moments → normal equations → quadratic and cubic gradients, blended. Compiled once for each set of instructions,
// under the name KERNEL_TARGET. The variants must not share any code, not even a function of the standard library.
#include "mesh/jets.h"

#include "support/targets.h"

namespace paradesc {
namespace KERNEL_TARGET {
namespace {

constexpr int spare_neighbors = 2;             // needed in addition to the number of coefficients
constexpr size_t cubic_terms = 4, columns = 9; // of the full problem; without its first four columns it is the quadratic one
// The number of fans that the processor computes at once. Compilers split wider vectors inefficiently.
#if defined(__AVX512F__)
constexpr int lane_count = 8;
#elif defined(__AVX2__)
constexpr int lane_count = 4;
#else
constexpr int lane_count = 2;
#endif
using Lanes [[gnu::vector_size(lane_count * sizeof(double))]] = double;
Lanes load(const FanLanes &from, int first) {
  Lanes lanes;
  __builtin_memcpy(&lanes, reinterpret_cast<const double *>(&from) + first, sizeof lanes);
  return lanes;
}
struct Gram {
  Lanes of[columns + 1][columns + 1]; // the upper half
  Lanes *operator[](size_t row) { return of[row]; }
};
struct Scale {
  Lanes of[columns + 1];
  Lanes &operator[](size_t column) { return of[column]; }
};

// Sums of u^(degree - k) v^k over the neighbors, and the same sums weighted by w: all that the normal equations need.
struct JetMoments {
  static constexpr size_t max_degree = 6;
  Lanes sum[max_degree + 1][max_degree + 1] = {}; // (degree, k)
  Lanes sum_w[4][4] = {};
  Lanes sum_ww{};

  void add(const Lanes &u, const Lanes &v, const Lanes &w) {
    Lanes power[max_degree + 1]; // of one degree
    power[0] = Lanes{} + 1.0;
    for (size_t degree = 1; degree <= max_degree; ++degree) {
      power[degree] = power[degree - 1] * v;
      for (size_t k = 0; k < degree; ++k) power[k] *= u;
      for (size_t k = 0; k <= degree; ++k) sum[degree][k] += power[k];
      if (degree > 3) continue;
      for (size_t k = 0; k <= degree; ++k) sum_w[degree][k] += power[k] * w;
    }
    sum_ww += w * w;
  }
};

// Normal equations of w = a jet without constant term: the gradient's columns come last, then the heights. Columns are scaled to
// unit length; scale keeps the factors, which are NaN or infinite for a zero column.
void make_gram(const Heights &heights, int first, Gram &gram, Scale &scale) {
  struct Monomial {
    size_t degree, k;
  };
  constexpr Monomial monomials[columns] = {{3, 0}, {3, 1}, {3, 2}, {3, 3}, {2, 0}, {2, 1}, {2, 2}, {1, 0}, {1, 1}};
  JetMoments moments;
  for (size_t i = 0; i < heights.max_count; ++i)
    moments.add(load(heights.u[i], first), load(heights.v[i], first), load(heights.w[i], first));
  for (size_t a = 0; a < columns; ++a) {
    const Monomial own = monomials[a];
    for (size_t b = a; b < columns; ++b) gram[a][b] = moments.sum[own.degree + monomials[b].degree][own.k + monomials[b].k];
    gram[a][columns] = moments.sum_w[own.degree][own.k];
  }
  gram[columns][columns] = moments.sum_ww;
  for (size_t a = 0; a < columns; ++a)
    for (int lane = 0; lane < lane_count; ++lane) scale[a][lane] = 1.0 / __builtin_sqrt(gram[a][a][lane]);
  scale[columns] = Lanes{} + 1.0;
  for (size_t a = 0; a <= columns; ++a)
    for (size_t b = a; b <= columns; ++b) gram[a][b] *= scale[a] * scale[b];
}

struct Gradient {
  Lanes u, v;
  Lanes residual;    // sum of squares
  Lanes least_pivot; // relative to 1; too small, or NaN, if the neighbors do not determine the gradient
};

// Eliminates from column `first` on. Higher orders are eliminated first, so that the last two pivots tell how well the neighbors
// determine the gradient alone.
template <size_t first> Gradient solve_gradient(Gram gram, Scale &scale) {
  Gradient gradient;
  gradient.least_pivot = gram[first][first];
  for (size_t k = first; k < columns; ++k) {
    const Lanes pivot = gram[k][k], inverse = 1.0 / pivot;
    gradient.least_pivot = pivot > gradient.least_pivot ? gradient.least_pivot : pivot; // keeps a NaN
    for (size_t a = k + 1; a <= columns; ++a) {
      const Lanes factor = gram[k][a] * inverse;
      for (size_t b = a; b <= columns; ++b) gram[a][b] -= factor * gram[k][b];
    }
  }
  constexpr size_t u = columns - 2, v = columns - 1;
  const Lanes slope = gram[v][columns] / gram[v][v];
  gradient.v = slope * scale[v];
  gradient.u = (gram[u][columns] - gram[u][v] * slope) / gram[u][u] * scale[u];
  gradient.residual = gram[columns][columns];
  return gradient;
}

double larger(double a, double b) { return a > b ? a : b; }

// Fits the fans from `first` on.
void fit_lanes(const Heights &heights, int first, Gradients &gradients) {
  constexpr double least_gain = 3; // c: 19 times of 20, noise alone gives less than 3.6 with two rings of 18 neighbors
  constexpr double least_pivot = 1e-5;
  constexpr int quadratic_columns = static_cast<int>(columns - cubic_terms), all_columns = static_cast<int>(columns);
  Gram gram;
  Scale scale;
  make_gram(heights, first, gram, scale);
  const Gradient quadratic = solve_gradient<cubic_terms>(gram, scale), cubic = solve_gradient<0>(gram, scale);
  for (int lane = 0; lane < lane_count; ++lane) {
    const int fan = first + lane, count = heights.count[fan];
    gradients.exists[fan] = count >= quadratic_columns + spare_neighbors && quadratic.least_pivot[lane] > least_pivot;
    if (!gradients.exists[fan]) continue;
    double share = 0.0;
    gradients.noise[fan] = larger(quadratic.residual[lane], 0.0) / (count - quadratic_columns);
    if (count >= all_columns + spare_neighbors && cubic.least_pivot[lane] > least_pivot) {
      const double left = larger(cubic.residual[lane], 0.0);
      const double gain = (larger(quadratic.residual[lane], 0.0) - left) / static_cast<double>(cubic_terms);
      const double noise = left / (count - all_columns);
      if (gain > least_gain * noise) share = 1 - least_gain * noise / gain;
      gradients.noise[fan] = noise;
    }
    const auto blend = [&](double of_quadratic, double of_cubic) {
      return share > 0.0 ? of_quadratic + share * (of_cubic - of_quadratic) : of_quadratic;
    };
    gradients.u[fan] = blend(quadratic.u[lane], cubic.u[lane]);
    gradients.v[fan] = blend(quadratic.v[lane], cubic.v[lane]);
  }
}

void fit(const Heights &heights, Gradients &gradients) {
  for (int first = 0; first < fan_lanes; first += lane_count) fit_lanes(heights, first, gradients);
}

} // namespace
} // namespace KERNEL_TARGET

PARADESC_TARGET(FitGradients, fit_gradients) = KERNEL_TARGET::fit;

} // namespace paradesc
