// The spine: mesh → half-edges → charts and seams → baked buffers → neighborhood sampler → descriptors → a value at every vertex.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>

#include "bake/surface_maps.h"
#include "descriptor/evaluate.h"
#include "gather/field.h"
#include "gpu/gl_thread.h"
#include "mesh/charts.h"
#include "mesh/halfedge.h"
#include "mesh/normals.h"
#include "mesh/triangles.h"
#include "sample/cells.h"

namespace paradesc {

struct Context {
  int backend = PDESC_BACKEND_REFERENCE; // the one in use
  int threads = 0;
  std::unique_ptr<GlThread> gl; // absent in the reference backend
  std::string device;
  std::string fallback;
  std::mutex mutex; // one call at a time
};

std::shared_ptr<Context> make_context(const pdesc_context_options &options);

// What the device keeps of a mesh between frames.
struct DeviceMesh {
  std::unique_ptr<GeometryBuffer> buffer;
  Evaluator evaluator;
  BorderGrid grid;
  Cells cells;
  BakeVertices vertices;
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
  SurfaceMaps maps;
  std::unique_ptr<DeviceMesh> device;
  bool private_layout = false; // charts were laid out afresh, since the UV map's share texture space
  double diagonal = 0.0;
  double mean_edge = 0.0;

  Mesh() = default;
  Mesh(const Mesh &) = delete;
  Mesh &operator=(const Mesh &) = delete;
  ~Mesh();
};

std::unique_ptr<Mesh> make_mesh(std::shared_ptr<Context> context, const pdesc_mesh_input &input);
void move_mesh(Mesh &mesh, const float *positions, int32_t vertex_count);
pdesc_mesh_report report_of(const Mesh &mesh);

// progress(stage, fraction) returns false to cancel.
using Progress = std::function<bool(const char *stage, double fraction)>;

Field compute(Mesh &mesh, const pdesc_options &options, std::span<const int> descriptors, const Progress &progress);

} // namespace paradesc
