// Values of a map at the points of a mesh → a texture of them beside the geometry buffers, by rasterizing the same triangles and
// chart edges: a texel has the map's value at the surface point that it holds.
#pragma once

#include "bake/gbuffer.h"
#include "image/passes.h"
#include "mesh/halfedge.h"

#include "shared.h"

namespace paradesc {

struct MapInput {
  const Triangles &triangles;
  const HalfEdges &half_edges;
  const Charts &charts;
  const BakeVertices &vertices;
  const MapValues &values; // (point_count)
};

class MapBuffer {
public:
  MapBuffer(const Gl &gl, int size);
  ~MapBuffer();
  MapBuffer(const MapBuffer &) = delete;
  MapBuffer &operator=(const MapBuffer &) = delete;

  void bake(ProgramCache &programs, const MapInput &input);
  // Binds what samples read.
  void bind() const { gl_.BindTextureUnit(UNIT_MAP, map_.id()); }
  std::vector<vec4> read() const; // (size * size)
  int size() const { return size_; }

private:
  void upload(const MapInput &input);

  const Gl &gl_;
  int size_;
  Texture map_, depth_;
  Buffer vertices_, index_, edges_, edge_ends_;
  GLuint framebuffer_ = 0, vertex_array_ = 0;
  GLsizei index_count_ = 0, edge_count_ = 0;
};

} // namespace paradesc
