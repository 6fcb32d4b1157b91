// A mesh in texture space (the paper's method): baked buffers, cells of their texels, neighborhoods among them, sums in shaders.
//
// Each stage is made by one function from inputs that the function does not change, and is kept under its key (support/keyed.h).
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "bake/bake_vertices.h"
#include "bake/distortion.h"
#include "bake/surface_maps.h"
#include "descriptor/passes.h"
#include "engine/engine.h"
#include "engine/opengl/cell_buffers.h"
#include "engine/opengl/connected_triangles.h"
#include "engine/opengl/device_surface.h"
#include "engine/opengl/evaluator.h"
#include "engine/opengl/geometry_buffer.h"
#include "engine/opengl/gl_thread.h"
#include "engine/opengl/map_buffer.h"
#include "engine/opengl/neighborhood_search.h"
#include "engine/opengl/surface_mapper.h"
#include "sample/centers.h"
#include "sample/starts.h"
#include "sample/texels.h"
#include "support/keyed.h"

namespace paradesc {

// ---- Keys: the inputs that a stage was made from

struct AtlasSize {
  int atlas; // the atlas's version
  int size;  // texels along a side
  bool operator==(const AtlasSize &) const = default;
};

struct LayoutKey {
  AtlasSize atlas;
  bool half;     // the buffers hold 16-bit floats
  uint64_t fans; // NormalsOnDemand::fans_version
  bool operator==(const LayoutKey &) const = default;
};

struct SurfaceKey {
  uint64_t positions;              // the positions' version
  int maps;                        // the maps' version
  std::array<uint64_t, 3> normals; // NormalsOnDemand::key
  bool fits_normals;               // on the device
  bool operator==(const SurfaceKey &) const = default;
};

struct BakeKey {
  LayoutKey layout;
  SurfaceKey surface;
  bool operator==(const BakeKey &) const = default;
};

struct SamplesKey {
  BakeKey bake;
  CellSampling sampling;
  bool operator==(const SamplesKey &) const = default;
};

// ---- Values

struct BakedLayout {
  TexelCounts counts;
  int texelless_triangles = 0; // triangles on charts that got no texel
};

// The key of centers at vertices: whether each wedge starts alone, and the seed.
using CentersKey = std::pair<bool, uint32_t>;

// Centers at vertices that start in cells, in the order in which they are evaluated.
struct OrderedCenters {
  Starts starts;
  Centers centers;
  std::vector<int32_t> vertices;  // (centers)
  std::vector<int32_t> triangles; // (centers) one triangle each
  uint64_t version = 0;           // differs from that of any other starts of the session
};

// The key of placed centers: OrderedCenters' version, and SurfaceKey::fits_normals.
using PlacedKey = std::pair<uint64_t, bool>;

// Ordered centers on the device, which gives them positions and normals.
struct PlacedCenters {
  Buffer data; // CenterData
  Places places;
};

// The places where centers start to search for their neighborhoods.
struct SearchStarts {
  const Starts &starts;
  std::span<const int32_t> triangles; // (centers) one triangle each
  uint64_t version;                   // of both arrays
};

// The cells of one block size: each radius has its own.
struct CellSet {
  Cells cells;
  std::unique_ptr<CellBuffers> buffers;
  Keyed<BakeKey, bool> measured;                // the bake whose cells and links the buffers hold
  Keyed<SamplesKey, TexellessSamples> samples;  // the samples they hold; the value has those of triangles without texels
  CellSampling room;                            // sampling for which the buffers' lists have had room
  int flood_room = 0;                           // patches that floods had room for, see ConnectedTriangles
  int ambiguous = 0;                            // expected number of ambiguous centers, somewhat above the last one
  int tile = 0;                                 // centers per dispatch that take about the intended time
  Keyed<int, std::vector<int32_t>> texel_cells; // by the map's size: (texel centers) cells that their searches start from
  Keyed<CentersKey, OrderedCenters> centers;    // at vertices
  Keyed<PlacedKey, std::unique_ptr<PlacedCenters>> placed;
};

// The surface of one computation.
struct Frame {
  BakeKey key;
  BakeSpace space;
  const DisplacedPoints *displaced = nullptr; // if maps displace the surface
  float enlargement = ellipse_enlargement;    // of sampling ellipses over the radius
  std::vector<vec4> links;                    // from seam_links, if samples march
  std::vector<int32_t> seams;                 // from number_seams, in the paper's relocation
  double radius_in_texels = 0.0;
};

// The inputs of one computation, borrowed.
struct Job {
  const Surface &surface;
  const Request &request;
  const Resources &resources;
  const Progress &progress;
  const pdesc_options &options() const { return request.options; }
  bool connected() const { return request.options.relocation == PDESC_RELOCATION_CONNECTED; }
  const Charts &charts() const { return surface.atlases.current().charts; }
  const Triangles &triangles(const Frame &frame) const { // as measured
    return frame.displaced ? frame.displaced->triangles : surface.triangles;
  }
};

class TextureSpace final : public Session {
public:
  TextureSpace(std::shared_ptr<GlThread> thread, bool software) : gl_(std::move(thread)), software_(software) {}
  ~TextureSpace() override;

  Computed compute(const Surface &surface, const Request &request, const Resources &resources, const Progress &progress) override;
  int buffer_size() const override;
  ReadBuffer read_buffer(const std::string &name, const Atlas &atlas) override;
  int64_t bytes_kept_for_others() const override;

private:
  using Work = std::function<void(const Gl &, ProgramCache &)>;

  // These objects live on the device: they are made, used and destroyed on its thread.
  struct OnDevice {
    DeviceSurface surface;
    std::unique_ptr<GeometryBuffer> buffer;
    Evaluator evaluator;
    std::unique_ptr<MapBuffer> map;              // if an operator was asked for
    std::vector<std::unique_ptr<CellSet>> cells; // of recent radii, the last one's first
    BufferTexture points;                        // of samples, if they are listed
    NeighborhoodSearch search;
    ConnectedTriangles connected;
    SurfaceMapper mapper;
  };

  // bake_stage.cpp
  Frame bake(const Job &job);
  bool fits_normals(const Job &job) const;
  void bake_layout(const Job &job, const BakeKey &baked);
  void bake_surface(const Job &job, const Frame &frame);
  void step(const Work &work);
  std::vector<vec4> ellipses(const Job &job, const BakeSpace &space, int step);
  void measure_radius(const Job &job, Frame &frame, double radius);
  static CenterOptions center_options(const Job &job, const Frame &frame, double radius);
  std::vector<CenterData> describe(const Job &job, const Frame &frame, const Centers &centers, double radius);

  // neighborhood_stage.cpp
  void use_cells(const Job &job, const Frame &frame);
  CellSet &cells() { return *device_->cells.front(); }
  const TexellessSamples &list_samples(const Job &job, const Frame &frame, const CellSampling &sampling);
  void prepare_search(const Job &job, const Frame &frame, const CellSampling &sampling, const SearchStarts &starts);
  void prepare_check(const Job &job, const Frame &frame, const SearchStarts &starts);
  bool had_room(const SearchCounts &counts, bool anew = false);
  bool floods_had_room(int patches);
  const BufferTexture *listed_points(const Job &job);
  void list_points(size_t centers);
  const OrderedCenters &ordered_centers(const Job &job, const Frame &frame);
  const PlacedCenters &placed_centers(const Job &job, const Frame &frame, const OrderedCenters &ordered);

  // evaluate_stage.cpp
  EvaluateSettings settings_of(const Job &job, const Frame &frame);
  const std::vector<float> &evaluate(const Job &job, const EvaluateSettings &settings, const Frame &frame,
                                     const std::function<void()> &search, const Progress &progress, double from, double to);
  void evaluate_tiles(const Job &job, const EvaluateSettings &settings, int count, const Progress &progress, double from,
                      double to);
  void check_connected(const EvaluateSettings &settings, int first, int end, const Progress &progress, double from, double to);
  CenterResults results_of(const EvaluateSettings &settings, const Frame &frame, const std::vector<float> &rows,
                           std::span<const int32_t> order);
  CenterResults evaluate_centers(const Job &job, const EvaluateSettings &settings, const Frame &frame, const Centers &centers,
                                 const std::function<void()> &search, const Progress &progress);
  void bake_map(const Job &job, const Centers &centers, const TexellessSamples &texelless, const MapValues &values);

  // texture_space.cpp
  void at_vertices(const Job &job, Frame &frame, Computed &computed);
  void at_texels(const Job &job, Frame &frame, Computed &computed);
  const TexelMap &texel_map(const Job &job, const Frame &frame);

  std::shared_ptr<GlThread> gl_;
  bool software_;
  std::unique_ptr<OnDevice> device_ = std::make_unique<OnDevice>();

  Keyed<AtlasSize, BorderGrid> grid_;
  Keyed<std::pair<int, uint64_t>, BakeVertices> vertices_; // by the atlas's version, and LayoutKey::fans
  Keyed<LayoutKey, BakedLayout> layout_;                   // the layout that the buffers' owners are of
  Keyed<SurfaceKey, std::optional<DisplacedPoints>> displaced_;
  Keyed<BakeKey, BakeSpace> baked_;                                  // the bake that the buffers hold
  Keyed<std::pair<int, int>, std::vector<int32_t>> ellipse_corners_; // by the atlas's version and the step
  Keyed<AtlasSize, TexelMap> texels_;
  Evaluated evaluated_;                   // results of the last passes: a new array would take as long to allocate
  uint64_t last_version_ = 0;             // of the last starts
  std::vector<int32_t> patch_codes_;      // Patches::code, if they are on the device
  uint64_t checked_starts_ = 0;           // version of the starts that device_->connected has
  Keyed<SurfaceKey, bool> patches_;       // the surface on which they were measured
  Keyed<SamplesKey, bool> listed_points_; // the samples whose points device_->points holds
};

// The side, in texels, of the blocks that cells are cut by: about half the radius, so that a neighborhood meets a few dozen cells
// at every radius.
int block_size(double radius_in_texels, int samples, int buffer_size);

// Returns whether nothing on the processor needs the normals of these options. The device then fits them itself, unless there are
// creases or it cannot list the rings.
bool device_may_fit_normals(const pdesc_options &options, bool surface_maps);

std::unique_ptr<Session> open_texture_space(std::shared_ptr<GlThread> thread, bool software);

} // namespace paradesc
