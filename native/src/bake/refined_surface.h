// Images and a radius → the surface that they displace as triangles of its own, for whoever sums over triangles.
//
// Triangles of the mesh are divided until their pieces are about as small as the images' pixels, or small against the radius, and
// the corners of the pieces move as displace_points() moves those of the mesh: a point that several triangles have goes to the
// mean of where each of them takes it, so that nothing cracks open. Normals stay those of each triangle.
#pragma once

#include <memory>

#include "bake/surface_maps.h"
#include "mesh/division.h"
#include "mesh/extent.h"

namespace paradesc {

inline constexpr int32_t most_pieces = 1 << 22; // of a surface

// Pixels of the largest map, along both sides.
ivec2 largest_image(const SurfaceMaps &maps);

// For plan_division(). triangles and maps are to outlive it. radius: of the smallest neighborhood, in units of the positions.
MeasureTriangle measure_of_maps(const SurfaceMaps &maps, const Triangles &triangles, double radius);

// The pieces at one moment. The points of the mesh are the first ones, by the same numbers.
struct RefinedSurface {
  Triangles triangles;
  Normals normals;
  Box box;
};

// The mesh, as its maps displace it. Throws Error(INVALID_OPERATION) where that is out of all bounds.
RefinedSurface refine_surface(const SurfaceMaps &maps, const Triangles &triangles, const HalfEdges &half_edges,
                              const Normals &normals, const BakeSpace &bake_space, const Division &division, int threads);

} // namespace paradesc
