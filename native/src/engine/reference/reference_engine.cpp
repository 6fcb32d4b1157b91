// Points of the mesh → quadrature at each, pass by pass.
#include "engine/reference/reference_engine.h"

#include <numeric>

#include "descriptor/passes.h"
#include "engine/creases/blend.h"
#include "engine/memory.h"
#include "engine/reference/reference.h"
#include "support/parallel.h"

namespace paradesc {

namespace {

class ReferenceSession final : public Session {
public:
  Computed compute(const Surface &surface, const Request &request, const Resources &resources, const Progress &progress) override;
};

class ReferenceEngine final : public Engine {
public:
  explicit ReferenceEngine(int threads)
      : device_("CPU, " + std::to_string(thread_count(threads)) + " threads (object-space reference)") {}
  int32_t backend() const override { return PDESC_BACKEND_REFERENCE; }
  const std::string &device() const override { return device_; }
  Abilities abilities() const override { return {}; }
  std::unique_ptr<Session> open_session() override { return std::make_unique<ReferenceSession>(); }

private:
  std::string device_;
};

} // namespace

static CenterResults at_all_points(ReferenceField &&field, int point_count) {
  CenterResults results = results_at_points(point_count);
  results.values = std::move(field.values);
  results.boundary = std::move(field.boundary);
  return results;
}

Computed ReferenceSession::compute(const Surface &surface, const Request &request, const Resources &resources,
                                   const Progress &progress) {
  const pdesc_options &options = request.options;
  const int points = surface.half_edges.point_count;
  ReferenceSettings settings{request.radius, options.estimator, options.distance == PDESC_DISTANCE_GEODESIC};
  settings.map_radius = request.radius;
  std::vector<int32_t> wanted(static_cast<size_t>(surface.wanted_points()));
  std::iota(wanted.begin(), wanted.end(), 0);
  settings.harris_k = options.harris_k;
  Clock clock;
  Computed computed;
  computed.results =
      run_passes(points, request.descriptors, find_map(options.map_descriptor),
                 [&](const Pass &pass, const MapValues *map, int number, int count) {
                   settings.map = map;
                   // A pass whose values later passes read as a map must cover the whole surface.
                   settings.points = pass.makes_map() ? std::span<const int32_t>() : std::span<const int32_t>(wanted);
                   settings.radius = radius_of(pass, options, request.radius);
                   settings.map_sigma = pass.stage == Stage::windows ? options.map_sigma * request.radius : 0.0;
                   const auto part = [&](double fraction) { return progress("evaluate", (number + fraction) / count); };
                   CenterResults results =
                       at_all_points(compute_reference(surface.triangles, surface.half_edges, surface.normals(), settings,
                                                       pass.rows, resources.threads, part),
                                     points);
                   CreaseBlend(surface, pass.rows, settings.radius, resources.threads).at_points(pass.rows, results);
                   return results;
                 });
  check_cancel(progress, "evaluate", 1.0); // other threads may have finished the last points
  keep_centers(computed.results, wanted.size(), request.descriptors);
  computed.report.places = surface.wanted_points();
  computed.report.refined_share = 1.0;
  computed.report.seconds_evaluate = clock.lap();
  return computed;
}

std::shared_ptr<Engine> open_reference_engine(int threads) { return std::make_shared<ReferenceEngine>(threads); }

MemoryForecast forecast_reference_memory(const ComputationSize &size) {
  MemoryForecast memory;
  memory.host = bytes_of_results(size) + (size.pieces - size.triangles) * 32; // per-thread stamps of floods
  return memory;
}

} // namespace paradesc
