// Values that an engine computed as if the surface were smooth → values that are valid near creases, where curvature is the
// solid's. SolidMeasure's weight is the solid's share.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "engine/creases/solid.h"
#include "engine/engine.h"
#include "sample/texels.h"

namespace paradesc {

// The memory of facets, of FaceRows, of shape operators at points, and of the marks of threads.
constexpr int64_t bytes_of_creased_triangle(int threads) { return 120 + 128 + 20 + 4 * int64_t{threads}; }

// Blends values for one radius, in units of the positions. Shape operators are blended, and all that follows from them is computed
// anew, so that K = k1 k2 everywhere. Other values, and the numbers of the integral estimator, are blended one by one. Does nothing if the surface has no creases, if maps displace it, or if
// none of the rows depends on curvature.
class CreaseBlend {
public:
  // estimator: pdesc_estimator. Throws Error if there is too little memory.
  CreaseBlend(const Surface &surface, std::span<const int> rows, double radius, int32_t estimator, const Resources &resources);

  CreaseBlend(const CreaseBlend &) = delete;
  CreaseBlend &operator=(const CreaseBlend &) = delete;

  // Returns the progress function for the steps before blending. It covers half of the pass, since blending often takes as long.
  Part before(const Part &whole) const;

  // Returns the rows, and after them those of the shape operator, if it has to be known.
  std::vector<int> needed(std::span<const int> rows) const;

  // results: of some of the rows and what they need, at the first points, in units of the positions. Rows that do not depend on curvature stay
  // unchanged. whole: gets the progress of the second half; without it the caller's cancel scope remains.
  void at_points(std::span<const int> rows, CenterResults &results, const Part &whole = {}) const;
  // Blends the results of texels from `first` on.
  void at_texels(std::span<const int> rows, const TexelMap &texels, size_t first, CenterResults &results,
                 const Part &whole = {}) const;

private:
  bool is_of_shape(int row) const;
  bool changes(std::span<const int> rows) const;
  template <class FindPlace>
  void blend(std::span<const int> rows, size_t count, const FindPlace &place, CenterResults &results, const Part &whole) const;

  const Surface &surface_;
  double radius_;
  bool blends_curvatures_;
  int threads_;
  std::optional<SolidSurface> solid_;
};

} // namespace paradesc
