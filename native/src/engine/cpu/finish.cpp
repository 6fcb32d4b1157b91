// Computes each row of the registry with each kernel that adds its terms.
#include "engine/cpu/finish.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>

#include "descriptor/registry.h"
#define KERNEL_TARGET finishing
#include "engine/cpu/kinds.h"

namespace paradesc {

namespace {

// Returns whether a kernel adds all terms of a list, which are separated by spaces.
template <class Kernel> constexpr bool adds(std::string_view terms) {
  using Terms = typename Kernel::Terms;
  if (terms == "gaussians jet") return adds<Kernel>("gaussians"); // The jet removes noise, and triangles leave none.
  if (const size_t space = terms.find(' '); space != std::string_view::npos)
    return adds<Kernel>(terms.substr(0, space)) && adds<Kernel>(terms.substr(space + 1));
  if (terms == "area") return requires(Terms t) {
      t.area;
    };
  if (terms == "ball") return requires(Terms t) {
      t.ball;
    };
  if (terms == "bending") return requires(Terms t) {
      t.bending;
    };
  if (terms == "jet") return requires(Terms t) {
      t.jet;
    };
  if (terms == "gaussians") return requires(Terms t) {
      t.gaussians;
    };
  if (terms == "tensor") return requires(Terms t) {
      t.tensor;
    };
  return terms.empty();
}

void append(std::vector<float> &values, float value) { values.push_back(value); }
void append(std::vector<float> &values, const kernels::Vector<3, float> &value) {
  values.insert(values.end(), {value.x, value.y, value.z});
}

template <class Kernel> struct Finished {
  Kernel kernel;
  typename Kernel::Sums sums;
  typename Kernel::Neighborhood neighborhood;
};

// The function of each row appends its value, or nothing if the kernel does not add its terms.
template <class Kernel> using AppendRow = void (*)(Finished<Kernel> &, std::vector<float> &);

template <class Kernel>
constexpr AppendRow<Kernel> append_rows[] = {
#define APPEND(name, needed)                                                                                                     \
  [](Finished<Kernel> &of, std::vector<float> &values) {                                                                         \
    if constexpr (adds<Kernel>(needed)) append(values, of.kernel.name(of.sums.terms, of.sums.center, of.neighborhood));          \
  },
#define DESCRIPTOR(name, label, description, power, is_signed, neutral, low, high, components, needed) APPEND(name, needed)
#define OPERATOR(name, label, description, power, degree, needs, is_signed, neutral, low, high, components, needed)              \
  APPEND(name, needed)
#include "descriptor/descriptors.def"
#include "descriptor/operators.def"
#undef OPERATOR
#undef DESCRIPTOR
#undef APPEND
};

template <class Part> const float *load(const float *sums, Part &part) {
  static_assert(std::is_trivially_copyable_v<Part>);
  std::memcpy(&part, sums, sizeof part);
  return sums + sizeof part / sizeof(float);
}

template <template <class, class> class Kernel>
void finish_kernel(const EvaluateParams &params, const SumCenter &center, const float *sums, bool boundary,
                   std::span<const int> rows, std::vector<float> &values) {
  using Narrow = Kernel<float, bool>;
  Finished<Narrow> finished{Narrow{params}, {}, {}};
  const auto vector = [](const float *v) { return kernels::Vector<3, float>(v[0], v[1], v[2]); };
  finished.kernel.sums_init(finished.sums, vector(center.position), vector(center.normal), center.value);
  sums = load(sums, finished.sums.moments);
  if constexpr (requires { finished.sums.windows; }) sums = load(sums, finished.sums.windows);
  load(sums, finished.sums.terms);
  finished.sums.moments.hits_boundary = boundary ? 1.0f : 0.0f;
  finished.neighborhood = finished.kernel.finish_neighborhood(finished.sums, 1.0f);
  for (const int row : rows) append_rows<Narrow>[row](finished, values);
}

} // namespace

SumPlan plan_sums(std::span<const int> rows, const pdesc_options &options, bool windows) {
  const bool geodesic = options.distance == PDESC_DISTANCE_GEODESIC, integral = options.estimator == PDESC_ESTIMATOR_INTEGRAL;
  const auto with_geodesic = [&](SumKind euclidean, SumKind along) { return geodesic ? along : euclidean; };
  if (windows) return {with_geodesic(SumKind::windows, SumKind::windows_geodesic)};
  const auto any = [&](std::string_view terms) {
    return std::ranges::any_of(rows, [&](int row) { return uses_terms(row, terms); });
  };
  if (any("jet")) return {with_geodesic(SumKind::jet, SumKind::jet_geodesic)};
  if (options.estimator == PDESC_ESTIMATOR_EXTRAPOLATED)
    return {with_geodesic(SumKind::extrapolated, SumKind::extrapolated_geodesic), false, any("bending")};
  if (integral || geodesic || any("area") || any("ball") || any("bending"))
    return {with_geodesic(SumKind::surface, SumKind::surface_geodesic), integral, any("bending")};
  return {SumKind::fit};
}

void finish(const SumPlan &plan, const EvaluateParams &params, const SumCenter &center, const float *sums, bool boundary,
            std::span<const int> rows, std::vector<float> &values) {
  using namespace kernels;
  if (!(sums[0] > 0.0f)) { // There is no surface; the terms alone cannot tell this from 0.
    for (const int row : rows) values.insert(values.end(), static_cast<size_t>(descriptor_row(row).components), std::nanf(""));
    return;
  }
  const auto by = [&](auto finish_it) { finish_it(params, center, sums, boundary, rows, values); };
  switch (plan.kind) {
  case SumKind::fit:
    return by(finish_kernel<FitKernel>);
  case SumKind::surface:
    return plan.integral ? by(finish_kernel<IntegralKernel>) : by(finish_kernel<SurfaceKernel>);
  case SumKind::surface_geodesic:
    return plan.integral ? by(finish_kernel<IntegralGeodesicKernel>) : by(finish_kernel<SurfaceGeodesicKernel>);
  case SumKind::extrapolated:
    return by(finish_kernel<ExtrapolatedKernel>);
  case SumKind::extrapolated_geodesic:
    return by(finish_kernel<ExtrapolatedGeodesicKernel>);
  case SumKind::jet:
    return by(finish_kernel<JetKernel>);
  case SumKind::jet_geodesic:
    return by(finish_kernel<JetGeodesicKernel>);
  case SumKind::windows:
    return by(finish_kernel<WindowsKernel>);
  case SumKind::windows_geodesic:
    return by(finish_kernel<WindowsGeodesicKernel>);
  }
}

} // namespace paradesc
