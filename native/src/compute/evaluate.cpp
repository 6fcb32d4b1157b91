// Passes → values at points and texels, blended at creases. Read evaluate() as the table of contents.
#include "compute/evaluate.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "compute/centers.h"
#include "compute/memory.h"
#include "descriptor/registry.h"
#include "engine/creases/blend.h"

namespace paradesc {

namespace {

// One pass of an engine, with values blended at creases.
class RunningPass {
public:
  RunningPass(Session &session, const PassInputs &of)
      : of_(of), evaluate_(session.start(of)),
        creases_(of.surface, of.pass.rows, of.radius(), of.request.options.estimator, of.resources) {}

  // Evaluates the first `count` points.
  CenterResults at_points(std::span<const int> rows, int32_t count, const Part &progress) const {
    const CenterPoints points = centers_at_points(of_.surface, of_.space, count, of_.resources.threads);
    return blended({points, of_.map}, rows, progress,
                   [&](std::span<const int> needed, CenterResults &results) { creases_.at_points(needed, results, progress); });
  }

  // Evaluates the texels [first, last).
  CenterResults at_texels(const TexelMap &texels, size_t first, size_t last, std::span<const int> rows,
                          const Part &progress) const {
    MapValues map;
    if (of_.map) map = map_at_texels(of_.surface, texels, *of_.map, first, last, of_.resources.threads);
    const CenterPoints points = centers_at_texels(of_.surface, of_.space, texels, first, last, of_.resources.threads);
    const Centers centers{points, of_.map ? &map : nullptr, std::span(texels.centers).subspan(first, last - first), texels.size};
    return blended(centers, rows, progress, [&](std::span<const int> needed, CenterResults &results) {
      creases_.at_texels(needed, texels, first, results, progress);
    });
  }

private:
  // Evaluates these rows and those that the blend needs, blends, and keeps the former.
  template <class Blend>
  CenterResults blended(const Centers &centers, std::span<const int> rows, const Part &progress, const Blend &blend) const {
    const std::vector<int> needed = creases_.needed(rows);
    CenterResults results = evaluate_(centers, needed, creases_.before(progress));
    blend(needed, results);
    results.values.resize(rows.size());
    return results;
  }

  const PassInputs &of_;
  EvaluatePass evaluate_;
  CreaseBlend creases_;
};

} // namespace

// Returns the values at points that later passes read from the map. The values of other rows stay empty.
static CenterResults values_for_map(const RunningPass &running, const Pass &pass, int points, const Part &progress) {
  CenterResults results;
  results.values.resize(pass.rows.size());
  for (size_t i = 0; i < pass.rows.size(); ++i)
    if (pass.stage == Stage::source || pass.rows[i] == gradient_row())
      results.values[i] = std::move(running.at_points(std::span(&pass.rows[i], 1), points, progress).values[0]);
  return results;
}

// Computes a pass at texels, band by band, and adds it to the results.
static void add_texels(const RunningPass &running, const Pass &pass, std::span<const int> requested, const TexelMap &texels,
                       const Part &progress, CenterResults &all) {
  std::vector<int> rows;
  std::vector<size_t> places; // indices in `requested`
  for (size_t k = 0; k < requested.size(); ++k)
    if (pass.stage != Stage::source && std::ranges::find(pass.rows, requested[k]) != pass.rows.end()) {
      rows.push_back(requested[k]);
      places.push_back(k);
    }
  const size_t count = rows.empty() ? 0 : texels.centers.size();
  double refined = 0.0;
  for (size_t first = 0, last = 0; first < count; first = last) {
    last = std::min(first + texels_of_band, count);
    const CenterResults found = running.at_texels(texels, first, last, rows, [&](double done) {
      progress((static_cast<double>(first) + done * static_cast<double>(last - first)) / static_cast<double>(count));
    });
    for (size_t i = 0; i < rows.size(); ++i) {
      const size_t width = found.values[i].size() / (last - first);
      std::ranges::copy(found.values[i], all.values[places[i]].begin() + static_cast<ptrdiff_t>(first * width));
    }
    std::ranges::copy(found.boundary, all.boundary.begin() + static_cast<ptrdiff_t>(first));
    std::ranges::copy(found.coverage, all.coverage.begin() + static_cast<ptrdiff_t>(first));
    refined += found.refined_share * static_cast<double>(last - first);
  }
  if (count > 0) all.refined_share = refined / static_cast<double>(count);
}

static const TexelMap &texels_of(Mesh &mesh, const Surface &surface, int size, int threads) {
  const auto key = [&] { return std::pair(surface.atlases.current().version, size); };
  if (const TexelMap *const kept = mesh.texels.find(key())) return *kept;
  mesh.texels.clear();
  TexelMap made = lay_out_texels(surface, size, threads); // may replace the atlas
  return mesh.texels.get(key(), [&] { return std::move(made); });
}

// Lays out the texels if they are to be evaluated, and makes what the engine's passes share.
static const TexelMap *prepare(Mesh &mesh, const Surface &surface, const Request &request, const Progress &progress,
                               pdesc_field_report &report) {
  const Resources resources = resources_of(*mesh.context);
  const pdesc_options &options = request.options;
  const bool at_texels = options.evaluate == PDESC_EVALUATE_TEXEL && abilities_of(mesh.engine->backend()).texels;
  Clock clock;
  if (at_texels) texels_of(mesh, surface, options.texels, resources.threads);
  report.seconds_prepare = clock.lap();
  mesh.session->prepare(surface, request, resources, progress, report); // may replace the atlas, too
  return at_texels ? &texels_of(mesh, surface, options.texels, resources.threads) : nullptr;
}

// Runs all passes. at_texels: gets the values there, if there are texels; the results are then unfinished.
static CenterResults run(Mesh &mesh, const Surface &surface, const Request &request, const TexelMap *texels,
                         const Progress &progress, CenterResults &at_texels) {
  const pdesc_options &options = request.options;
  Resources resources = resources_of(*mesh.context);
  const MemoryForecast memory = forecast_memory_of(mesh, mesh.engine->backend(), options, request.descriptors);
  resources.memory_held = memory.total() - memory.rough;
  const BakeSpace space = bake_space_of(surface.box);
  const double begin = abilities_of(mesh.engine->backend()).prepared;
  const int32_t points = surface.half_edges.point_count;
  const int map_row = find_map(options.map_descriptor);
  std::vector<float> of_map; // values at points, if they are known before the map's own pass
  const auto run_pass = [&](const Pass &pass, const MapValues *map, int number, int count) {
    const Part part = [&](double done) { check_cancel(progress, "evaluate", begin + (1.0 - begin) * (number + done) / count); };
    part(0.0);
    if (pass.stage == Stage::source && !of_map.empty()) {
      CenterResults results;
      results.values = {std::move(of_map)};
      return results;
    }
    const PassInputs inputs{surface, request, space, pass, map, resources};
    const RunningPass running(*mesh.session, inputs);
    if (!texels) {
      // A map that later passes read is needed on the whole surface.
      const int32_t wanted = pass.makes_map() ? points : surface.wanted_points();
      CenterResults results = running.at_points(pass.rows, wanted, part);
      const auto row = std::ranges::find(pass.rows, map_row);
      if (wanted == points && pass.stage == Stage::surface && row != pass.rows.end() &&
          mesh.session->gives_map(pass, map_row, options))
        of_map = results.values[row - pass.rows.begin()];
      return results;
    }
    constexpr double share = 0.7; // of the progress: texels, before the points are evaluated
    add_texels(
        running, pass, request.descriptors, *texels, [&](double done) { part(share * done); }, at_texels);
    return values_for_map(running, pass, points, [&](double done) { part(share + (1.0 - share) * done); });
  };
  return run_passes(request.descriptors, map_row, run_pass);
}

CenterResults evaluate(Mesh &mesh, const Surface &surface, const Request &request, const Progress &progress, Field &field) {
  pdesc_field_report &report = field.report;
  const TexelMap *const texels = prepare(mesh, surface, request, progress, report);
  Clock clock;
  CenterResults at_texels;
  if (texels) at_texels = unknown_results(texels->centers.size(), request.descriptors);
  CenterResults results = run(mesh, surface, request, texels, progress, at_texels);
  const Atlas &atlas = surface.atlases.current();
  if (texels) {
    results = look_up(*texels, at_texels, atlas.charts, mesh.context->threads);
    field.maps = images_of(*texels, at_texels, request.descriptors);
    field.map_size = texels->size;
    report.places = static_cast<int32_t>(texels->centers.size());
  } else {
    keep_centers(results, static_cast<size_t>(surface.wanted_points()), request.descriptors);
    const auto has_place = [](float coverage) { return !std::isnan(coverage); };
    report.places = static_cast<int32_t>(std::ranges::count_if(results.coverage, has_place));
  }
  check_cancel(progress, "evaluate", 1.0);
  if (texels || abilities_of(mesh.engine->backend()).texture_space) {
    report.private_layout = atlas.layout;
    report.cut_charts = atlas.cut_charts;
  }
  report.refined_share = results.refined_share;
  report.seconds_evaluate = clock.lap();
  return results;
}

} // namespace paradesc
