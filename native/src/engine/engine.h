// The seam between what is computed and what computes it: a mesh and options in, values at centers of evaluation out.
//
// An engine is opened once for a context; a session is what it keeps of one mesh between computations. Nothing outside an
// engine's folder knows how it works; what it can do is asked (Abilities).
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bake/surface_maps.h"
#include "descriptor/results.h"
#include "mesh/atlas.h"
#include "mesh/creases.h"
#include "mesh/division.h"
#include "mesh/facets.h"
#include "mesh/normals.h"
#include "support/progress.h"

namespace paradesc {

// A computation beyond these abilities is refused before a session sees it.
struct Abilities {
  bool texture_space = false; // it needs a UV map, has buffers to read, and has results for each wedge of a point
  bool surface_maps = false;  // it follows displacement and normal maps; else it is given the surface that they make
  bool texels = false;        // it evaluates at texels of a map, for which alone it may need a UV map
  int32_t max_triangles = std::numeric_limits<int32_t>::max();
};

struct Resources {
  int threads = 0;                         // as in pdesc_context_options
  int64_t memory_limit = 0;                // likewise
  int smallest_tile = 128;                 // centers of the smallest tile, which no result may depend on
  std::optional<double> tile_seconds = {}; // that each tile takes, as tests say; else they are measured
};

// The mesh that a surface was divided from.
struct DividedMesh {
  const Triangles &triangles;
  const HalfEdges &half_edges;
  const Division &division;
};

// A mesh at one moment, borrowed for one computation; or, for an engine that does not follow surface maps, what they make of it:
// its triangles divided and displaced.
struct Surface {
  const Triangles &triangles;
  const HalfEdges &half_edges;
  NormalsOnDemand normals;
  const Creases *creases; // beside which curvature is that of the solid; or null
  const SurfaceMaps &maps;
  const Box &box;                                   // of the positions
  Atlases &atlases;                                 // an engine in texture space may ask for a better one
  uint64_t positions_version;                       // differs whenever positions do
  uint64_t topology_version = 0;                    // differs whenever triangles do
  std::optional<DividedMesh> divided = {};          // whose points are the surface's first ones, and whose layout is the atlas
  std::function<const Facets &()> facets = nullptr; // with these normals, beside the creases; made when first asked for

  // Points at which results are wanted: the mesh's.
  int32_t wanted_points() const { return divided ? divided->half_edges.point_count : half_edges.point_count; }
  // A place on the mesh → on the surface.
  TrianglePlace place(TrianglePlace on_mesh) const { return divided ? divided->division.at(on_mesh) : on_mesh; }
};

// What to compute of it.
struct Request {
  const pdesc_options &options;
  std::span<const int> descriptors; // rows of the registry
  double radius;                    // in units of the positions
};

struct Computed {
  CenterResults results;
  pdesc_field_report report{};            // what the engine knows of it; the rest is 0
  std::vector<std::vector<float>> images; // as images_of, if texels were evaluated
  int image_size = 0;
};

// Values of a baked buffer (size * size, components), row by row from v = 0, in units of the positions; NaN where nothing is
// (chart, neighbor: -1).
struct ReadBuffer {
  int size = 0, components = 1;
  std::vector<float> values;
};

// Throws Error(INVALID_OPERATION).
[[noreturn]] void refuse_to_read_buffers();

class Session {
public:
  virtual ~Session() = default;
  // Throws Error: CANCELLED, or what failed. The session stays usable.
  virtual Computed compute(const Surface &surface, const Request &request, const Resources &resources,
                           const Progress &progress) = 0;
  // Texels along a side of the buffers that were baked last; 0: none are there.
  virtual int buffer_size() const { return 0; }
  // Throws Error(INVALID_OPERATION) if none are there, INVALID_ARGUMENT with the names there are.
  virtual ReadBuffer read_buffer(const std::string &, const Atlas &) { refuse_to_read_buffers(); }
  // Bytes that are kept for other radii: by chance, and so no part of what one computation takes.
  virtual int64_t bytes_kept_for_others() const { return 0; }
};

class Engine {
public:
  virtual ~Engine() = default;
  virtual int32_t backend() const = 0; // pdesc_backend
  virtual const std::string &device() const = 0;
  virtual Abilities abilities() const = 0;
  virtual bool lost() const { return false; } // nothing more can be computed here
  virtual std::unique_ptr<Session> open_session() = 0;
};

// The sizes that determine the memory of a computation.
struct ComputationSize {
  int64_t triangles, points, wedges, borders;
  int64_t pieces, piece_points; // of the surface that is summed over: the mesh's, unless it is divided for its maps
  bool surface_maps;            // the mesh has some
  double disks;                 // of the radius that the surface has the area of, about
  int threads;                  // that compute on the processor
  const pdesc_options &options;
  std::span<const int> descriptors;
};

// Bytes at the peak of one computation.
struct MemoryForecast {
  int64_t mesh = 0;           // what a mesh holds between computations
  int64_t host = 0;           // beside it
  int64_t device = 0;         // textures and buffers
  int64_t device_on_host = 0; // of the device's, what the host's memory holds: a software rasterizer's is all there
  int64_t total() const { return mesh + host + device_on_host; } // of the host's
};

} // namespace paradesc
