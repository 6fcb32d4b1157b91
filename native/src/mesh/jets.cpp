// Neighbors → moments → normal equations → quadratic and cubic gradients, blended.
#include "mesh/jets.h"

#include <algorithm>
#include <cmath>

namespace paradesc {
namespace {

constexpr int spare_neighbors = 2;             // more than coefficients
constexpr size_t cubic_terms = 4, columns = 9; // of the full problem; without its first four columns it is the quadratic one
using Gram = std::array<std::array<Lanes, columns + 1>, columns + 1>; // its upper half
using Scale = std::array<Lanes, columns + 1>;

// Sums of u^(degree - k) v^k over the neighbors, and of the same times w: all that the normal equations are made of.
struct JetMoments {
  static constexpr size_t max_degree = 6;
  std::array<std::array<Lanes, max_degree + 1>, max_degree + 1> sum{}; // (degree, k)
  std::array<std::array<Lanes, 4>, 4> sum_w{};
  Lanes sum_ww{};

  void add(const Lanes &u, const Lanes &v, const Lanes &w) {
    std::array<Lanes, max_degree + 1> power; // of one degree
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

// Normal equations of w = a jet without constant term, gradient last, then the heights themselves. Columns are scaled to unit
// length; scale keeps the factors, which are no numbers where a column vanishes.
void make_gram(const Heights &heights, Gram &gram, Scale &scale) {
  struct Monomial {
    size_t degree, k;
  };
  constexpr std::array<Monomial, columns> monomials{{{3, 0}, {3, 1}, {3, 2}, {3, 3}, {2, 0}, {2, 1}, {2, 2}, {1, 0}, {1, 1}}};
  JetMoments moments;
  for (size_t i = 0; i < heights.max_count; ++i) moments.add(heights.u[i], heights.v[i], heights.w[i]);
  for (size_t a = 0; a < columns; ++a) {
    const Monomial own = monomials[a];
    for (size_t b = a; b < columns; ++b) gram[a][b] = moments.sum[own.degree + monomials[b].degree][own.k + monomials[b].k];
    gram[a][columns] = moments.sum_w[own.degree][own.k];
  }
  gram[columns][columns] = moments.sum_ww;
  for (size_t a = 0; a < columns; ++a)
    for (size_t lane = 0; lane < lane_count; ++lane) scale[a][lane] = 1.0 / std::sqrt(gram[a][a][lane]);
  scale[columns] = Lanes{} + 1.0;
  for (size_t a = 0; a <= columns; ++a)
    for (size_t b = a; b <= columns; ++b) gram[a][b] *= scale[a] * scale[b];
}

struct Gradient {
  Lanes u, v;
  Lanes residual;    // sum of squares
  Lanes least_pivot; // of 1; not above what is enough, or no number, where the neighbors do not determine it
};

// Eliminates from column `first` on. Higher orders go first, so that the last two pivots show how well the neighbors determine
// the gradient alone.
template <size_t first> Gradient solve_gradient(Gram gram, const Scale &scale) {
  Gradient gradient;
  gradient.least_pivot = gram[first][first];
  for (size_t k = first; k < columns; ++k) {
    const Lanes pivot = gram[k][k], inverse = 1.0 / pivot;
    gradient.least_pivot = pivot > gradient.least_pivot ? gradient.least_pivot : pivot; // no number stays none
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

} // namespace

std::array<std::optional<dvec2>, lane_count> fit_gradients(const Heights &heights) {
  constexpr double least_gain = 3; // c: 19 times of 20, noise alone gives less than 3.6 with two rings of 18 neighbors
  constexpr double least_pivot = 1e-5;
  constexpr int quadratic_columns = static_cast<int>(columns - cubic_terms), all_columns = static_cast<int>(columns);
  Gram gram;
  Scale scale;
  make_gram(heights, gram, scale);
  const Gradient quadratic = solve_gradient<cubic_terms>(gram, scale), cubic = solve_gradient<0>(gram, scale);
  std::array<std::optional<dvec2>, lane_count> gradients;
  for (size_t lane = 0; lane < lane_count; ++lane) {
    const int count = heights.count[lane];
    if (count < quadratic_columns + spare_neighbors || !(quadratic.least_pivot[lane] > least_pivot)) continue;
    dvec2 gradient(quadratic.u[lane], quadratic.v[lane]);
    if (count >= all_columns + spare_neighbors && cubic.least_pivot[lane] > least_pivot) {
      const double left = std::max(cubic.residual[lane], 0.0);
      const double gain = (std::max(quadratic.residual[lane], 0.0) - left) / static_cast<double>(cubic_terms);
      const double noise = left / (count - all_columns);
      const double share = gain > least_gain * noise ? 1 - least_gain * noise / gain : 0;
      gradient += share * (dvec2(cubic.u[lane], cubic.v[lane]) - gradient);
    }
    gradients[lane] = gradient;
  }
  return gradients;
}

} // namespace paradesc
