// Nine places of a triangle that find the means of its turning normals.
#pragma once

#include <array>

namespace paradesc {

struct TrianglePart {
  float weight[3]; // of the corners
  float twelfths;  // of the triangle
};

// The edge midpoints of the four triangles that a triangle's own edge midpoints cut it into. A quadratic has the same mean over
// them as over the triangle.
inline constexpr std::array<TrianglePart, 9> nine_places = [] {
  std::array<TrianglePart, 9> places{};
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < 3; ++i) {
      TrianglePart &place = places[3 * k + i];
      place = {{0.25f, 0.25f, 0.25f}, 2.0f};
      place.weight[k] = 0.5f;
      if (i == 0) continue;
      place = {{0.0f, 0.0f, 0.0f}, 1.0f};
      place.weight[k] = 0.75f;
      place.weight[(k + i) % 3] = 0.25f;
    }
  return places;
}();

} // namespace paradesc
