// A mesh in texture space (the paper's method): baked buffers, samples that march over them from each center, sums in shaders.
//
// Each stage is made by one function from inputs that the function does not change, and is kept under its key (support/keyed.h).
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "bake/distortion.h"
#include "bake/surface_maps.h"
#include "engine/engine.h"
#include "engine/paper/centers.h"
#include "engine/paper/evaluator.h"
#include "engine/paper/geometry_buffer.h"
#include "engine/paper/gl_thread.h"
#include "engine/paper/surface_mapper.h"
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
  bool half; // the buffers hold 16-bit floats
  bool operator==(const LayoutKey &) const = default;
};

struct SurfaceKey {
  uint64_t positions;              // the positions' version
  int maps;                        // the maps' version
  std::array<uint64_t, 3> normals; // NormalsOnDemand::key
  bool operator==(const SurfaceKey &) const = default;
};

struct BakeKey {
  LayoutKey layout;
  SurfaceKey surface;
  bool operator==(const BakeKey &) const = default;
};

// ---- Values

struct BakedLayout {
  TexelCounts counts;
  int texelless_triangles = 0; // triangles on charts that got no texel
};

// The surface of one computation.
struct Frame {
  BakeKey key;
  BakeSpace space;
  const DisplacedPoints *displaced = nullptr; // if maps displace the surface
  float enlargement = ellipse_enlargement;    // of sampling ellipses over the radius
  std::vector<vec4> links;                    // from seam_links
  std::vector<int32_t> seams;                 // from number_seams, in the paper's relocation
  double radius_in_texels = 0.0;
};

// The inputs of one computation, borrowed.
struct Job {
  const Surface &surface;
  const Request &request;
  const Resources &resources;
  const pdesc_options &options() const { return request.options; }
  // The default, connected, is beyond samples that march; affine stands for it.
  bool paper() const { return request.options.relocation == PDESC_RELOCATION_PAPER; }
  const Charts &charts() const { return surface.atlases.current().charts; }
};

class TextureSpace final : public Session {
public:
  TextureSpace(std::shared_ptr<GlThread> thread, bool software) : gl_(std::move(thread)), software_(software) {}
  ~TextureSpace() override;

  void prepare(const Surface &surface, const Request &request, const Resources &resources, const Progress &progress,
               pdesc_field_report &report) override;
  EvaluatePass start(const PassInputs &pass) override;
  int buffer_size() const override;
  ReadBuffer read_buffer(const std::string &name, const Atlas &atlas) override;

private:
  using Work = std::function<void(const Gl &, ProgramCache &)>;

  // These objects live on the device: they are made, used and destroyed on its thread.
  struct OnDevice {
    std::unique_ptr<GeometryBuffer> buffer;
    Evaluator evaluator;
    SurfaceMapper mapper;
  };

  // bake_stage.cpp
  Frame bake(const Job &job);
  void bake_layout(const Job &job, const LayoutKey &key);
  void bake_surface(const Job &job, const Frame &frame);
  void step(const Work &work);
  void measure_radius(const Job &job, Frame &frame);

  // evaluate_stage.cpp
  EvaluateSettings settings_of(const PassInputs &pass, const Job &job, std::span<const int> rows) const;
  CenterResults evaluate(const PassInputs &pass, const std::vector<vec4> &ellipses, const Centers &centers,
                         std::span<const int> rows, const Part &progress);
  void evaluate_tiles(const Resources &resources, const EvaluateSettings &settings, const Part &progress);
  CenterResults results_of(const EvaluateSettings &settings, size_t count, const std::vector<int32_t> &numbers) const;

  std::shared_ptr<GlThread> gl_;
  bool software_;
  std::unique_ptr<OnDevice> device_ = std::make_unique<OnDevice>();

  Keyed<AtlasSize, BorderGrid> grid_;
  Keyed<LayoutKey, BakedLayout> layout_; // the layout that the buffers' owners are of
  Keyed<SurfaceKey, std::optional<DisplacedPoints>> displaced_;
  Keyed<BakeKey, BakeSpace> baked_; // the bake that the buffers hold
  Frame frame_;                     // of the last prepare()
  std::vector<float> rows_;         // results of the last centers: a new array would take as long to allocate
};

} // namespace paradesc
