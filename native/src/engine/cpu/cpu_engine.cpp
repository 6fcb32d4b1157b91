// A pass over a surface → values at centers, by all cores.
#include "engine/cpu/cpu_engine.h"

#include <algorithm>
#include <memory>
#include <string>

#include "descriptor/registry.h"
#include "engine/cpu/summed_surface.h"
#include "engine/memory.h"
#include "support/parallel.h"

namespace paradesc {

namespace {

class CpuSession final : public Session {
public:
  EvaluatePass start(const PassInputs &pass) override {
    const auto summed = std::make_shared<const SummedSurface>(pass, kept_);
    return [&pass, summed](const Centers &centers, std::span<const int> rows, const Part &progress) {
      static const MapValues none;
      CenterResults results = summed->at(centers.list, centers.map ? *centers.map : none, rows, progress);
      scale_values(rows, pass.space.scale, results);
      return results;
    };
  }

  bool gives_map(const Pass &pass, int map_row, const pdesc_options &options) const override {
    const Pass source{Stage::source, {map_row}};
    return fineness_of(pass, options) == fineness_of(source, options) &&
           plan_sums(pass.rows, options, false) == plan_sums(source.rows, options, false);
  }

private:
  SummedMesh kept_;
};

class CpuEngine final : public Engine {
public:
  explicit CpuEngine(int threads) : device_("CPU, " + std::to_string(thread_count(threads)) + " threads") {}
  int32_t backend() const override { return PDESC_BACKEND_CPU; }
  const std::string &device() const override { return device_; }
  std::unique_ptr<Session> open_session() override { return std::make_unique<CpuSession>(); }

private:
  std::string device_;
};

} // namespace

std::shared_ptr<Engine> open_cpu_engine(int threads) { return std::make_shared<CpuEngine>(threads); }

MemoryForecast forecast_cpu_memory(const ComputationSize &size) {
  const Pass finest{Stage::surface, {size.descriptors.begin(), size.descriptors.end()}};
  const auto triangles = static_cast<double>(size.pieces);
  const double divided =
      std::min(2.0 * fineness_of(finest, size.options).samples * size.disks, triangles * static_cast<double>(max_stored_samples));
  const double listed = plan_sums(finest.rows, size.options, false).kind == SumKind::fit ? 0.0 : triangles;
  const int64_t of_sample = bytes_of_sample + (reads_map(size.descriptors) ? static_cast<int64_t>(sizeof(SampleMap)) : 0);
  MemoryForecast memory;
  memory.rough =
      bytes_of_patches(size.pieces, size.piece_points, size.threads) + static_cast<int64_t>(listed + divided) * of_sample;
  memory.host = memory.rough + bytes_of_order * size.piece_points;
  return memory;
}

} // namespace paradesc
