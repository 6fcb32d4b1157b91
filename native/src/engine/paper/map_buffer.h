// Values of a map at the points of a mesh → a texture beside the geometry buffers: each texel has the map's value at its surface
// point.
#pragma once

#include "descriptor/passes.h"
#include "engine/paper/geometry_buffer.h"
#include "mesh/halfedge.h"

#include "shared.h"

namespace paradesc {

struct MapInput {
  const HalfEdges &half_edges;
  const MapValues &values; // (point_count)
};

class MapBuffer {
public:
  MapBuffer(const Gl &gl, int size) : gl_(gl), size_(size), map_(gl, size, size, GL_RGBA32F) {}

  // Interpolates the values to texels by the owners of the buffer's texels.
  void bake(ProgramCache &programs, GeometryBuffer &buffer, const MapInput &input);
  // Binds the texture that samples read.
  void bind() const { gl_.BindTextureUnit(UNIT_MAP, map_.id()); }
  std::vector<vec4> read() const; // (size * size)
  int size() const { return size_; }

private:
  const Gl &gl_;
  int size_;
  Texture map_;
};

} // namespace paradesc
