// Triangles that no texel carries → samples of their own.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "bake/distortion.h"
#include "bake/surface_maps.h"
#include "sample/cells.h"

#include "shared.h"

namespace paradesc {

// The samples that represent triangles without texels.
struct TexellessSamples {
  std::vector<int32_t> begin; // (cells + 1)
  std::vector<TexellessSample> samples;
  std::vector<vec2> weights; // (samples) weights of the triangle's corners 1 and 2 at the sample
};

// displaced: the surface as maps displace it, else NULL. radius: in buffer units.
TexellessSamples sample_texelless_triangles(const Cells &cells, const Triangles &triangles,
                                            const std::function<vec3(size_t corner)> &normal_of, const BakeSpace &bake_space,
                                            float radius, const DisplacedSurface *displaced = nullptr);

} // namespace paradesc
