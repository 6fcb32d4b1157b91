// Height and normal images over baked buffers → the displaced surface at every texel (bake/surface_maps.h has the formulas).
#pragma once

#include "bake/surface_maps.h"
#include "engine/paper/geometry_buffer.h"

namespace paradesc {

class SurfaceMapper {
public:
  // Rewrites position, area element and normal of every texel of a buffer baked from this input.
  void run(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer, const BakeInput &input, const Normals &normals,
           const SurfaceMaps &maps);

private:
  void upload_images(const Gl &gl, const SurfaceMaps &maps);
  void upload_corners(const Gl &gl, const BakeInput &input, const Normals &normals, const SurfaceMaps &maps);

  int version_ = 0;
  Texture heights_, colors_;
  BufferTexture input_uvs_, tangents_;
};

} // namespace paradesc
