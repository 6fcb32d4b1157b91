// A thread that owns a device, and a session in texture space for each mesh.
#include "engine/paper/paper_engine.h"

#include <algorithm>

#include "descriptor/registry.h"
#include "engine/memory.h"
#include "engine/paper/gl_thread.h"
#include "engine/paper/texture_space.h"

#include "shared.h"

namespace paradesc {

namespace {

class PaperEngine final : public Engine {
public:
  PaperEngine(bool software, int device_index, const DriverSubstitute &substitute)
      : software_(software), thread_(std::make_shared<GlThread>(software, device_index, substitute)) {}
  int32_t backend() const override { return software_ ? PDESC_BACKEND_SOFTWARE : PDESC_BACKEND_GPU; }
  const std::string &device() const override { return thread_->device(); }
  bool lost() const override { return thread_->lost(); }
  std::unique_ptr<Session> open_session() override { return std::make_unique<TextureSpace>(thread_, software_); }

private:
  bool software_;
  std::shared_ptr<GlThread> thread_;
};

} // namespace

std::shared_ptr<Engine> open_paper_engine(bool software, int device_index, const DriverSubstitute &substitute) {
  return std::make_shared<PaperEngine>(software, device_index, substitute);
}

// Returns the bytes that centers keep on the device between the dispatches of their samples.
static int64_t bytes_of_marches(const pdesc_options &options, int64_t centers) {
  constexpr int64_t of_sums = 2048;
  if (options.relocation != PDESC_RELOCATION_PAPER) return std::min<int64_t>(centers, most_centers_of_affine) * of_sums;
  return std::min<int64_t>(centers, most_centers_of_paper) * (of_sums + MAX_VISITS * static_cast<int64_t>(sizeof(VisitData)));
}

static int64_t bytes_of_device(const ComputationSize &size) {
  const pdesc_options &options = size.options;
  const int64_t texels = int64_t{options.buffer_size} * options.buffer_size;
  const int64_t a_texel = (options.precision == PDESC_PRECISION_HALF && !size.surface_maps ? 32 : 48) + 8 +
                          8 // borders, depth and owners of a layout
                          + (reads_map(size.descriptors) ? 16 : 0);
  const int64_t centers = options.evaluate == PDESC_EVALUATE_TEXEL ? static_cast<int64_t>(texels_of_band) : size.wedges;
  int64_t bytes = texels * a_texel + size.triangles * 144 + size.borders * 100 + centers * (200 + 4 * rows_of(size.descriptors)) +
                  bytes_of_marches(options, centers);
  if (reads_map(size.descriptors)) bytes += size.triangles * 48;
  return bytes;
}

MemoryForecast forecast_paper_memory(bool software, const ComputationSize &size) {
  constexpr int64_t rasterizer = 45'000'000; // llvmpipe's bins of triangles to draw
  const pdesc_options &options = size.options;
  MemoryForecast memory;
  memory.device = bytes_of_device(size);
  memory.device_on_host = software ? memory.device + rasterizer : 0;
  memory.host =
      int64_t{options.buffer_size} * options.buffer_size * 32 + size.triangles * 212 + size.wedges * 160 + size.borders * 300;
  return memory;
}

} // namespace paradesc
