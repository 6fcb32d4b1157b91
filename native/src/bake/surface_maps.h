// Images over the caller's UV map → a displaced surface and its normals: here at single positions on triangles; on the device at
// all baked texels (shaders/paper/bake/displace.comp.glsl, with the same formulas).
//
// With p the point, n the interpolated unit normal and h(uv) = (image - midlevel) scale, the displaced point is p + n h. Its
// tangents are those of the smooth surface that n describes, t = e - n (n·e) for an edge e of the triangle, plus the change of n
// h along the edge: without displacement the normal is n itself instead of the facet's normal. The gradient of h is taken over
// two pixels, so that it is continuous where that of the bilinear image is not. A normal map replaces the normal, whether or not
// the surface is displaced.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "bake/distortion.h"
#include "mesh/halfedge.h"
#include "mesh/normals.h"
#include "mesh/triangles.h"

namespace paradesc {

// Rows are bottom-up and repeat beyond [0, 1]; values are bilinear between the centers of pixels.
template <class Pixel> struct Image {
  int width = 0, height = 0;
  std::vector<Pixel> pixels;
};

struct Displacement {
  Image<float> heights;
  float midlevel = 0.0f, scale = 0.0f; // scale in units of the positions
};

struct NormalMap {
  Image<vec4> colors;               // red, green, blue in [0, 1]
  std::vector<vec4> corner_tangent; // (3 * triangle_count) xyz, sign of the bitangent
};

struct SurfaceMaps {
  std::optional<Displacement> displacement;
  std::optional<NormalMap> normal_map;
  int version = 0; // counts changes, so that the device knows when to update
  bool any() const { return displacement || normal_map; }
};

// Throw Error: INVALID_ARGUMENT names the first pixel or tangent that cannot be used; INVALID_OPERATION: there is no UV map.
void set_displacement(SurfaceMaps &maps, const Triangles &triangles, const float *heights, int32_t width, int32_t height,
                      double midlevel, double scale);
void set_normal_map(SurfaceMaps &maps, const Triangles &triangles, const float *rgb, int32_t width, int32_t height,
                    const float *corner_tangents, int32_t corner_count);

struct SurfacePoint {
  vec3 position;    // buffer units
  vec3 normal;      // unit
  float area_ratio; // of the displaced surface to the triangle
};

// The triangles' surface as displaced by the maps.
class DisplacedSurface {
public:
  DisplacedSurface(const SurfaceMaps &maps, const Triangles &triangles, const Normals &normals, const BakeSpace &bake_space)
      : maps_(maps), triangles_(triangles), normals_(normals), bake_space_(bake_space) {}
  // a, b: barycentric coordinates of the triangle's corners 1 and 2.
  SurfacePoint at(int triangle, float a, float b) const;
  // The surface at a corner of its triangle, with a given normal there.
  SurfacePoint at_corner(int corner, vec3 normal, float &shrinkage) const;

private:
  const SurfaceMaps &maps_;
  const Triangles &triangles_;
  const Normals &normals_;
  const BakeSpace &bake_space_;
};

// The normal that a normal map is relative to at a corner: the mesh's own if it has one, since the map was made for that normal.
vec3 frame_normal(const Triangles &triangles, const Normals &normals, size_t corner);

// The points where descriptors are evaluated, as displaced by the maps.
struct DisplacedPoints {
  std::vector<vec3> position; // (point_count) buffer units
  std::vector<vec3> normal;   // (point_count) unit
  float shrinkage = 1.0f;     // ratio of lengths on the base to the displaced surface, 99th percentile over corners; 1 to 4
};

// A point on a seam has a height and a normal at each of its corners; it gets their mean, weighted by angle.
DisplacedPoints displace_points(const SurfaceMaps &maps, const Triangles &triangles, const HalfEdges &half_edges,
                                const Normals &normals, const BakeSpace &bake_space, int threads);

} // namespace paradesc
