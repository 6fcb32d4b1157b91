// Images and a radius → the surface that they displace, as triangles of its own, for engines that sum over triangles.
//
// Triangles of the mesh are divided until their pieces are about as small as the images' pixels, or small against the radius.
// Corners of pieces move as displace_points() moves those of the mesh: a point of several triangles goes to the mean of where
// each of them takes it, so that nothing cracks open. Normals stay those of each triangle.
#pragma once

#include <memory>

#include "bake/surface_maps.h"
#include "mesh/division.h"

namespace paradesc {

inline constexpr int32_t most_pieces = 1 << 22; // pieces of a surface

// Width and height of the largest map, in pixels.
ivec2 largest_image(const SurfaceMaps &maps);

// For plan_division(). triangles and maps must outlive the result. radius: of the smallest neighborhood, in units of the
// positions.
MeasureTriangle measure_of_maps(const SurfaceMaps &maps, const Triangles &triangles, double radius);

// The pieces at one moment. The points of the mesh come first, with unchanged numbers.
struct RefinedSurface {
  Triangles triangles;
  Normals normals;
  Box box;
};

// The mesh as displaced by its maps. Throws Error(INVALID_OPERATION) if displaced positions are out of bounds.
RefinedSurface refine_surface(const SurfaceMaps &maps, const Triangles &triangles, const HalfEdges &half_edges,
                              const Normals &normals, const BakeSpace &bake_space, const Division &division, int threads);

} // namespace paradesc
