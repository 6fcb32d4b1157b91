// Mesh + normals + metric → the geometry buffers of paper 3.3, by rasterizing triangles and then chart edges in (u, v).
#pragma once

#include <vector>

#include "bake/distortion.h"
#include "gpu/buffer.h"
#include "gpu/program.h"
#include "mesh/charts.h"
#include "mesh/normals.h"
#include "mesh/triangles.h"

namespace paradesc {

// A vertex of the bake: the corners of one site that share a normal. Depends on topology and on which corners share one.
struct BakeVertices {
  std::vector<int32_t> corner; // (bake vertices) one corner that stands for it
  std::vector<uint32_t> index; // (3 * triangle_count) bake vertex of each corner; of triangles on no chart all the same
};
// corner_group: corners of one site with the same group share a normal; empty: none do.
BakeVertices build_bake_vertices(const Triangles &triangles, const Charts &charts, const std::vector<int32_t> &corner_group);

// What one frame brings to the bake.
struct BakeInput {
  const Triangles &triangles;
  const Charts &charts;
  const BakeVertices &vertices;
  const Normals &normals;
  const std::vector<vec4> &forms;
  const BufferFrame &frame;
  int threads = 0;
};

struct TexelCounts {
  int covered = 0;     // texels with at least one owner
  int overlapping = 0; // texels that several triangles claim
};

class GeometryBuffer {
public:
  // half: positions and normals in 16-bit floats.
  GeometryBuffer(const Gl &gl, int size, bool half = false);
  ~GeometryBuffer();
  GeometryBuffer(const GeometryBuffer &) = delete;
  GeometryBuffer &operator=(const GeometryBuffer &) = delete;

  void bake(ProgramCache &programs, const BakeInput &input, bool topology_changed);
  // The same in steps, so that a run can be cancelled between: uploads, clear, triangles so many at a time, borders.
  void upload_topology(const BakeInput &input); // where it changed, first
  void upload(const BakeInput &input);
  void clear();
  int triangle_count() const { return index_count_ / 3; }
  void draw(ProgramCache &programs, int first_triangle, int last_triangle);
  void draw_borders(ProgramCache &programs);
  // Counts the triangles that own each texel; after bake.
  TexelCounts count_owners(ProgramCache &programs);
  // Binds what samples read.
  void bind() const;
  // Binds for a pass that rewrites position (image 0) and normal (image 1) of baked texels.
  void bind_to_rewrite() const;
  // sigma_u, sigma_v, theta_e, area element of every texel (size * size, 4); after bake.
  std::vector<vec4> read_distortion(ProgramCache &programs) const;
  std::vector<vec4> read_position() const; // (size * size) position, area element in buffer units
  std::vector<vec4> read_normal() const;
  std::vector<int32_t> read_ids() const; // (size * size, 2) chart, triangle
  int size() const { return size_; }
  bool half() const { return half_; }
  double megabytes() const; // 10^6 bytes, of all buffers
  // What one unit of the stored area element stands for: 16-bit floats end at 65504.
  float area_unit() const { return area_unit_; }

private:
  void begin_drawing() const;
  void draw_triangles(int first, int last) const;
  void set_area_unit(const BakeInput &input);
  void use(GLuint program) const;

  const Gl &gl_;
  int size_;
  bool half_;
  float area_unit_ = 1.0f;
  Texture position_, normal_, ids_, depth_;
  ListTexture forms_;
  Buffer position_normal_, uv_chart_, index_, edges_;
  GLuint framebuffer_ = 0, vertex_array_ = 0;
  GLsizei index_count_ = 0, edge_count_ = 0;
};

} // namespace paradesc
