// Points of the mesh → quadrature at each.
#include "engine/reference/reference_engine.h"

#include <numeric>

#include "engine/reference/reference.h"
#include "support/parallel.h"

namespace paradesc {

static CenterResults evaluate(const PassInputs &pass, const Centers &centers, std::span<const int> rows, const Part &progress) {
  const Surface &surface = pass.surface;
  const pdesc_options &options = pass.request.options;
  std::vector<int32_t> points(centers.list.size());
  std::iota(points.begin(), points.end(), 0);
  ReferenceSettings settings{pass.radius(), options.estimator, options.distance == PDESC_DISTANCE_GEODESIC};
  settings.map = pass.map;
  settings.map_radius = pass.request.radius;
  settings.map_sigma = pass.pass.stage == Stage::windows ? options.map_sigma * pass.request.radius : 0.0;
  settings.harris_k = options.harris_k;
  settings.points = points;
  ReferenceField field = compute_reference(surface.triangles, surface.half_edges, surface.normals(), settings, rows,
                                           pass.resources.threads, progress);
  CenterResults results;
  results.values = std::move(field.values);
  results.boundary = std::move(field.boundary);
  results.coverage.assign(results.boundary.size(), 1.0f);
  keep_centers(results, points.size(), rows);
  return results;
}

namespace {

class ReferenceSession final : public Session {
public:
  EvaluatePass start(const PassInputs &pass) override {
    return [&pass](const Centers &centers, std::span<const int> rows, const Part &progress) {
      return evaluate(pass, centers, rows, progress);
    };
  }
};

class ReferenceEngine final : public Engine {
public:
  explicit ReferenceEngine(int threads)
      : device_("CPU, " + std::to_string(thread_count(threads)) + " threads (object-space reference)") {}
  int32_t backend() const override { return PDESC_BACKEND_REFERENCE; }
  const std::string &device() const override { return device_; }
  std::unique_ptr<Session> open_session() override { return std::make_unique<ReferenceSession>(); }

private:
  std::string device_;
};

} // namespace

std::shared_ptr<Engine> open_reference_engine(int threads) { return std::make_shared<ReferenceEngine>(threads); }

MemoryForecast forecast_reference_memory(const ComputationSize &size) {
  MemoryForecast memory;
  memory.host = (size.pieces - size.triangles) * 32; // per-thread stamps of floods
  return memory;
}

} // namespace paradesc
