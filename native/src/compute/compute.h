// The spine: mesh → half-edges → charts and seams → baked buffers → neighborhood sampler → descriptors → a value at every vertex.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "bake/surface_maps.h"
#include "context.h"
#include "engine/opengl/evaluator.h"
#include "gather/field.h"
#include "mesh/charts.h"
#include "mesh/halfedge.h"
#include "mesh/normals.h"
#include "mesh/patches.h"
#include "mesh/triangles.h"
#include "engine/opengl/cell_buffers.h"
#include "sample/texels.h"

namespace paradesc {

// A mesh's cells of one block size: each radius has its own.
struct CellLayout {
  Cells cells;
  CellSamples samples;              // as the last search chose them
  std::vector<CellData> measured;   // (cells) of the frame that is baked; none until it is asked
  std::vector<vec3> link_points;    // (cells.link_texel) of that frame; none until a search asks
  std::vector<int32_t> texel_cells; // (places of texels) where their searches start; none until it is asked
  std::unique_ptr<CellBuffers> buffers;
};

// What the device keeps of a mesh between frames.
struct DeviceMesh {
  std::unique_ptr<GeometryBuffer> buffer;
  Evaluator evaluator;
  std::unique_ptr<MapBuffer> map; // once an operator was asked for
  BorderGrid grid;
  std::vector<std::unique_ptr<CellLayout>> cells; // of the last radii, that of the last one first
  BufferTexture points;                           // of samples, where centers fetch them often
  BakeVertices vertices;
  std::vector<int32_t> sampled_corners; // of the sites whose ellipses are asked for
  size_t sampled_step = 0;              // every so many sites; 0: none yet
  TexelMap texels;                      // where results go in texel evaluation
  BufferFrame frame;                    // of the last bake
  std::shared_ptr<struct Frame> last;   // what was made for it, while positions and maps stay
  SurfaceMapper mapper;
  int normals_kind = -1;
  TexelCounts counts;
  int bare_triangles = 0;
};

struct Mesh {
  std::shared_ptr<Context> context;
  Triangles triangles;
  HalfEdges half_edges;
  Charts charts;
  std::optional<NormalRings> rings;
  std::optional<Patches> patches; // where they were needed
  SurfaceMaps maps;
  std::unique_ptr<DeviceMesh> device;
  std::shared_ptr<GlThread> gl; // what device was made on: the context may have gone on to another since
  pdesc_mesh_report found{};    // in the mesh and its UV map as they were given
  int private_layout = 0;       // as in pdesc_field_report
  int32_t cut_charts = 0;
  bool fill_tried = false;
  bool overlap_free = false; // no place of the layout in use belongs to two triangles, whatever rasterizers round
  uint64_t version = 0;      // of positions and maps
  Box box;
  double diagonal = 0.0;
  double mean_edge = 0.0;

  Mesh() = default;
  Mesh(const Mesh &) = delete;
  Mesh &operator=(const Mesh &) = delete;
  ~Mesh();
};

std::unique_ptr<Mesh> make_mesh(std::shared_ptr<Context> context, const pdesc_mesh_input &input);
void move_mesh(Mesh &mesh, const float *positions, int32_t vertex_count);
pdesc_mesh_report describe(const Mesh &mesh); // Mesh::found
pdesc_mesh_report report_of(const Mesh &mesh);

// progress(stage, fraction) returns false to cancel.
using Progress = std::function<bool(const char *stage, double fraction)>;

// (size * size, components) of what the last compute baked, row by row from v = 0, in units of the positions; NaN where nothing
// is (chart, neighbor: -1). Throws Error(INVALID_OPERATION) before a compute.
struct ReadBuffer {
  int size = 0, components = 1;
  std::vector<float> values;
};
ReadBuffer read_buffer(Mesh &mesh, const std::string &name);

Field compute(Mesh &mesh, const pdesc_options &options, std::span<const int> descriptors, const Progress &progress);

} // namespace paradesc
