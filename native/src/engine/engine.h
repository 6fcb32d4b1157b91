// The seam between a computation and the engine that runs it: an engine evaluates one pass at centers, points of the surface.
// Passes, creases, texels, images and reports are above it (compute/evaluate).
//
// An engine is opened once per context; a session is its state for one mesh, kept between computations. Nothing outside an
// engine's folder knows how it works; callers ask what it can do (Abilities).
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bake/distortion.h"
#include "bake/surface_maps.h"
#include "descriptor/passes.h"
#include "descriptor/results.h"
#include "mesh/atlas.h"
#include "mesh/creases.h"
#include "mesh/division.h"
#include "mesh/facets.h"
#include "mesh/normals.h"
#include "sample/center_point.h"
#include "sample/texels.h"
#include "support/progress.h"

namespace paradesc {

// The abilities of an engine. A computation beyond them is refused before a session sees it.
struct Abilities {
  bool texture_space = false; // needs a UV map, and has buffers to read
  bool surface_maps = false;  // follows displacement and normal maps; otherwise it gets the displaced surface
  bool texels = false;        // evaluates at texels of a map; this may need a UV map although the rest does not
  bool any_options = false;   // passes over options of texture space, which others without it refuse
  double prepared = 0.0;      // share of the progress that Session::prepare covers
  int32_t max_triangles = std::numeric_limits<int32_t>::max();
};

struct Resources {
  int threads = 0;                         // as in pdesc_context_options
  int64_t memory_limit = 0;                // as in pdesc_context_options
  int smallest_tile = 128;                 // centers of the smallest tile; no result may depend on it
  std::optional<double> tile_seconds = {}; // the time of each tile if tests set it; otherwise it is measured
  int64_t memory_held = 0;                 // bytes of the mesh and its results, which count against the limit
};

// The mesh that a surface was divided from.
struct DividedMesh {
  const Triangles &triangles;
  const HalfEdges &half_edges;
  const Division &division;
};

// A mesh at one moment, borrowed for one computation. For an engine that does not follow surface maps it is the mesh as displaced
// by them, with its triangles divided.
struct Surface {
  const Triangles &triangles;
  const HalfEdges &half_edges;
  NormalsOnDemand normals;
  const Creases *creases; // near these, curvature is that of the solid; or null
  const SurfaceMaps &maps;
  const Box &box;                                   // of the positions
  Atlases &atlases;                                 // an engine in texture space may replace the layout
  uint64_t positions_version;                       // differs whenever positions do
  uint64_t topology_version = 0;                    // differs whenever triangles do
  std::optional<DividedMesh> divided = {};          // its points are the surface's first ones, and its layout is the atlas
  std::function<const Facets &()> facets = nullptr; // for these normals and creases; computed on first use

  // The number of points at which results are wanted: the mesh's points.
  int32_t wanted_points() const { return divided ? divided->half_edges.point_count : half_edges.point_count; }
  // Maps a place on the mesh to the surface.
  TrianglePlace place(TrianglePlace on_mesh) const { return divided ? divided->division.at(on_mesh) : on_mesh; }
};

// The request: what to compute on a surface.
struct Request {
  const pdesc_options &options;
  std::span<const int> descriptors; // rows of the registry
  double radius;                    // in units of the positions
};

// The inputs of one pass, borrowed.
struct PassInputs {
  const Surface &surface;
  const Request &request;
  const BakeSpace &space; // of the surface
  const Pass &pass;
  const MapValues *map; // at points; or null
  const Resources &resources;

  // The radius in units of the positions, and in those of the space.
  double radius() const { return radius_of(pass, request.options, request.radius); }
  float scaled_radius() const { return static_cast<float>(radius() * space.scale); }
};

inline constexpr size_t texels_of_band = size_t{1} << 17; // the most that are centers at once

// Some points of the surface at which a pass is evaluated, borrowed.
struct Centers {
  const CenterPoints &list;
  const MapValues *map;                  // of the pass at each center, and perhaps further ones; or null
  std::span<const TexelCenter> texels{}; // the centers as texels; empty: the centers are the first points
  int map_size = 0;                      // texels along a side of their map
};

// progress: gets the share of the centers that is done, and may throw. Returns values of some of the pass's rows, and of
// others that need no more sums.
using Part = std::function<void(double)>;
using EvaluatePass = std::function<CenterResults(const Centers &centers, std::span<const int> rows, const Part &progress)>;

// Values of a baked buffer (size * size, components), row by row from v = 0, in units of the positions; NaN off the charts
// (chart, neighbor: -1).
struct ReadBuffer {
  int size = 0, components = 1;
  std::vector<float> values;
};

class Session {
public:
  virtual ~Session() = default;
  // Makes what all passes of a computation share, and reports on it. This call and the next one throw Error: CANCELLED, or the
  // failure. The session stays usable.
  virtual void prepare(const Surface &, const Request &, const Resources &, const Progress &, pdesc_field_report &) {}
  // Readies the sums of a pass. The function returned borrows the pass and the session.
  virtual EvaluatePass start(const PassInputs &pass) = 0;
  // Returns whether a pass over the surface gives the values of this row with the bits of a pass for the map alone.
  virtual bool gives_map(const Pass &, int, const pdesc_options &) const { return false; }
  // Side of the last baked buffers in texels; 0: there are none.
  virtual int buffer_size() const { return 0; }
  // Returns nothing, of size 0, if there are no buffers. Throws Error(INVALID_ARGUMENT) that lists the available names.
  virtual ReadBuffer read_buffer(const std::string &, const Atlas &) { return {}; }
};

class Engine {
public:
  virtual ~Engine() = default;
  virtual int32_t backend() const = 0; // pdesc_backend
  virtual const std::string &device() const = 0;
  virtual bool lost() const { return false; } // nothing more can be computed here
  virtual std::unique_ptr<Session> open_session() = 0;
};

// The sizes that determine the memory of a computation.
struct ComputationSize {
  int64_t triangles, points, wedges, borders;
  int64_t pieces, piece_points; // of the surface that is summed over: the mesh's unless maps divide it
  bool surface_maps;            // the mesh has some
  double disks;                 // approximate ratio of the surface's area to a disk of the radius
  int threads;                  // of the processor
  const pdesc_options &options;
  std::span<const int> descriptors;
};

// Bytes at the peak of one computation.
struct MemoryForecast {
  int64_t mesh = 0;           // held by the mesh between computations
  int64_t host = 0;           // in addition to the mesh
  int64_t rough = 0;          // the part of `host` that only a rough or creased surface takes, and checks once that is known
  int64_t device = 0;         // textures and buffers
  int64_t device_on_host = 0; // the part of `device` in host memory: all of it for a software rasterizer
  int64_t total() const { return mesh + host + device_on_host; } // host memory
};

} // namespace paradesc
