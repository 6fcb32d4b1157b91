// Mesh + normals → the geometry buffers of paper 3.3, by rasterizing triangles and then chart edges in (u, v).
#pragma once

#include <memory>
#include <vector>

#include "bake/distortion.h"
#include "descriptor/passes.h"
#include "engine/paper/buffer.h"
#include "engine/paper/program.h"
#include "mesh/atlas.h"
#include "mesh/normals.h"
#include "mesh/triangles.h"

#include "shared.h"

namespace paradesc {

// The inputs of a bake. Positions belong to a frame, the rest to the layout.
struct BakeInput {
  const Triangles &triangles;
  const Charts &charts;
  const BakeSpace &bake_space;
};

// A layout draws the triangles once, to find the owner of each texel and the texel's place in the owner. A frame then reads the
// owner's three corners at each texel, so its cost does not depend on the number of triangles.
class GeometryBuffer {
public:
  // half: positions and normals in 16-bit floats.
  GeometryBuffer(const Gl &gl, int size, bool half = false);
  GeometryBuffer(const GeometryBuffer &) = delete;
  GeometryBuffer &operator=(const GeometryBuffer &) = delete;

  // Draw a layout, in steps between which a run may be cancelled: uploads, some triangles at a time, borders, counts.
  void begin_layout(const Charts &charts);
  int triangle_count() const { return triangle_count_; }
  void draw_triangles(ProgramCache &programs, int first, int last);
  void draw_borders(ProgramCache &programs);
  TexelCounts end_layout(ProgramCache &programs);
  // Draw a frame, in steps: corners, some rows at a time.
  void place_corners(const BakeInput &input, const Normals &normals);
  void draw_surface(ProgramCache &programs, int first_row, int last_row);
  // Draws a map's values at points to texels, using the same owners.
  void draw_map(ProgramCache &programs, const HalfEdges &half_edges, const MapValues &points);

  // Bind the textures that samples read: the surface, and the map that was drawn last.
  void bind() const;
  void bind_map() const { gl_.BindTextureUnit(UNIT_MAP, map_.id()); }
  // Binds the layout and the frame's corners, for owner.glsl and metric.glsl.
  void bind_owners() const;
  // Binds for a pass that rewrites position (image 0) and normal (image 1) of baked texels.
  void bind_to_rewrite() const;
  // sigma_u, sigma_v, theta_e, area element of every texel (size * size, 4).
  std::vector<vec4> read_distortion(ProgramCache &programs) const;
  std::vector<vec4> read_position() const; // (size * size) position, area element in buffer units
  std::vector<vec4> read_normal() const;
  std::vector<int32_t> read_ids() const; // (size * size, 2) chart, triangle
  std::vector<vec4> read_map() const;    // (size * size)
  int size() const { return size_; }
  bool half() const { return half_; }
  // The define that shaders which read the buffer's texels are compiled with.
  const char *variant() const { return half_ ? "#define HALF_FLOATS\n" : ""; }
  double megabytes() const; // 10^6 bytes, of all buffers
  // The area element of one stored unit: 16-bit floats end at 65504.
  float area_unit() const { return area_unit_; }

private:
  // State that exists only while a layout is drawn.
  struct Drawing {
    Texture depth;
    BufferTexture edges;
    GLsizei edge_count = 0;
  };
  void begin_drawing(GLenum depth_function) const;
  void draw_screen(GLuint framebuffer, int first_row, int last_row) const;
  TexelCounts count_owners(ProgramCache &programs) const;
  void set_area_unit(const BakeInput &input);

  const Gl &gl_;
  int size_;
  bool half_;
  float area_unit_ = 1.0f;
  double area_in_map_ = 0.0; // of all triangles
  int triangle_count_ = 0;
  Texture position_, normal_, ids_, weights_;
  Texture map_; // made when a map is first drawn
  BufferTexture corner_uvs_, vertices_, values_;
  GlName<&Gl::DeleteFramebuffers> layout_framebuffer_, surface_framebuffer_;
  GlName<&Gl::DeleteVertexArrays> no_attributes_;
  std::unique_ptr<Drawing> drawing_;
};

} // namespace paradesc
