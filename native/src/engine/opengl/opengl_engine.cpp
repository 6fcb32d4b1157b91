// A thread that owns a device, and a session in texture space for each mesh.
#include "engine/opengl/opengl_engine.h"

#include <algorithm>
#include <cmath>

#include "descriptor/registry.h"
#include "engine/memory.h"
#include "engine/opengl/connected_triangles.h"
#include "engine/opengl/gl_thread.h"
#include "engine/opengl/texture_space.h"

#include "shared.h"

namespace paradesc {

namespace {

class OpenglEngine final : public Engine {
public:
  OpenglEngine(bool software, int device_index, const DriverSubstitute &substitute)
      : software_(software), thread_(std::make_shared<GlThread>(software, device_index, substitute)) {}
  int32_t backend() const override { return software_ ? PDESC_BACKEND_SOFTWARE : PDESC_BACKEND_GPU; }
  const std::string &device() const override { return thread_->device(); }
  // Shaders store chart numbers in floats, which are exact up to 2^24, and there may be as many charts as triangles.
  Abilities abilities() const override {
    return {.texture_space = true, .surface_maps = true, .texels = true, .max_triangles = 1 << 24};
  }
  bool lost() const override { return thread_->lost(); }
  std::unique_ptr<Session> open_session() override { return open_texture_space(thread_, software_); }

private:
  bool software_;
  std::shared_ptr<GlThread> thread_;
};

} // namespace

std::shared_ptr<Engine> open_opengl_engine(bool software, int device_index, const DriverSubstitute &substitute) {
  return std::make_shared<OpenglEngine>(software, device_index, substitute);
}

static bool reads_map(std::span<const int> descriptors) {
  return std::ranges::any_of(descriptors, [](int row) { return descriptor_row(row).needs != MapNeeds::nothing; });
}

// Bytes of the rings that a device fits normals to. The mesh keeps a copy of its own.
static int64_t bytes_of_rings(const ComputationSize &size) {
  return device_may_fit_normals(size.options, size.surface_maps) ? size.points * 250 : 0;
}

// Cells near the centers of one cell are listed once for all of these centers, together with their neighbors. The number depends
// on how much of the buffers the map fills, which is not yet known, so the worst case is assumed.
static int64_t bytes_of_near_cells(const ComputationSize &size, int64_t centers) {
  constexpr double of_cell = 84, of_neighbor = 16, neighbors = 7, spare = 1.125; // CellBuffers::make_room
  constexpr double beyond = 1.7;                                                 // blocks that a list reaches beyond the radius
  constexpr double cut_by_border = 4;  // one in so many blocks along a chart's border makes one more cell
  constexpr double of_triangle = 2.31; // the square of a side, in areas of a regular triangle
  const pdesc_options &options = size.options;
  const double texels = static_cast<double>(options.buffer_size) * options.buffer_size;
  const double all_texels = static_cast<double>(options.texels) * options.texels;
  const double share = options.evaluate == PDESC_EVALUATE_TEXEL ? std::min(1.0, static_cast<double>(centers) / all_texels) : 1.0;
  double most = 0.0;
  for (const double filled : {1.0, 0.9, 0.8, 0.7, 0.6, 0.5}) {
    const double covered = filled * texels, radius = std::sqrt(covered / (pi * std::max(size.disks, 1.0)));
    const double block = block_size(radius, options.samples, options.buffer_size), across = (radius + beyond * block) / block;
    const double side = std::sqrt(of_triangle * covered / static_cast<double>(std::max<int64_t>(size.triangles, 1)));
    const double cells = covered / (block * block) + static_cast<double>(size.borders) * side / (cut_by_border * block);
    const double near_one = std::min(cells, pi * across * across * cells * block * block / covered);
    most = std::max(most, share * std::min(cells, static_cast<double>(centers)) * near_one);
  }
  return static_cast<int64_t>(spare * most * (of_cell + neighbors * of_neighbor));
}

static int64_t bytes_of_device(bool software, const ComputationSize &size) {
  const pdesc_options &options = size.options;
  const int64_t texels = int64_t{options.buffer_size} * options.buffer_size;
  const int64_t a_texel = (options.precision == PDESC_PRECISION_HALF && !size.surface_maps ? 32 : 48) + 8 + 8 +
                          8 // borders, cells, depth and owners of a layout
                          + (reads_map(size.descriptors) ? 16 : 0);
  const int64_t centers = options.evaluate == PDESC_EVALUATE_TEXEL ? 32768 : size.wedges;
  int64_t bytes = texels * a_texel + bytes_of_rings(size) + size.triangles * 76 + size.points * 24 + size.wedges * 32 +
                  size.borders * 100 + centers * (200 + 4 * rows_of(size.descriptors));
  if (options.relocation == PDESC_RELOCATION_CONNECTED) {
    const int64_t ranges_of_center =
        options.adaptive > 0.0 ? 1024 : 512; // some 120 near cells, each with up to as many ranges as leaves
    bytes += std::min<int64_t>(texels * 5 / 4, max_listed_points) * 32 // samples
             + bytes_of_near_cells(size, centers) +
             std::min(centers * ranges_of_center, int64_t{most_ranges(software)}) * bytes_of_range +
             size.triangles * 56 // patches
             + bytes_of_floods(centers, expected_patches(static_cast<double>(size.triangles) / std::max(size.disks, 1e-6)));
  }
  if (reads_map(size.descriptors)) bytes += size.wedges * 32;
  if (options.relocation == PDESC_RELOCATION_PAPER) bytes += int64_t{16384} * MAX_VISITS * 64 + 16384 * 2048;
  if (options.relocation == PDESC_RELOCATION_AFFINE) bytes += int64_t{65536} * 2048;
  return bytes;
}

MemoryForecast forecast_opengl_memory(bool software, const ComputationSize &size) {
  constexpr int64_t rasterizer = 45'000'000; // llvmpipe's bins of triangles to draw
  const pdesc_options &options = size.options;
  MemoryForecast memory;
  memory.device = bytes_of_device(software, size);
  memory.device_on_host = software ? memory.device + rasterizer : 0;
  memory.host = bytes_of_results(size) + bytes_of_rings(size) + int64_t{options.buffer_size} * options.buffer_size * 32 +
                size.triangles * 100 + size.wedges * 160 + size.borders * 300;
  if (options.relocation == PDESC_RELOCATION_CONNECTED) memory.host += size.triangles * 16; // patches
  if (options.evaluate == PDESC_EVALUATE_TEXEL)
    memory.host += int64_t{options.texels} * options.texels * (60 + 16 * rows_of(size.descriptors));
  return memory;
}

} // namespace paradesc
