// What an engine found, as if the surface were smooth → what holds where creases are near: curvature there is that of the solid.
#pragma once

#include <optional>
#include <span>

#include "engine/creases/near.h"
#include "engine/engine.h"
#include "sample/texels.h"

namespace paradesc {

// For one radius, in units of the positions. Does nothing where the surface has no creases, where maps displace it, or where none
// of the rows follows from curvature.
class CreaseBlend {
public:
  CreaseBlend(const Surface &surface, std::span<const int> rows, double radius, int threads);

  CreaseBlend(const CreaseBlend &) = delete;
  CreaseBlend &operator=(const CreaseBlend &) = delete;

  // results: of some of the rows, at points, in units of the positions. Rows that follow from no curvature stay.
  void at_points(std::span<const int> rows, CenterResults &results) const;
  // Of texels [first, …).
  void at_texels(std::span<const int> rows, const TexelMap &texels, size_t first, CenterResults &results) const;

private:
  template <class FindPlace>
  void blend(std::span<const int> rows, size_t count, const FindPlace &place, CenterResults &results) const;

  const Surface &surface_;
  double radius_;
  int threads_;
  std::optional<CreasedSurface> creased_;
  std::optional<NearCreases> near_;
};

} // namespace paradesc
