// Rows grouped by their needs → passes; the values of one pass → the map that the next one reads.
#include "descriptor/passes.h"

#include <algorithm>
#include <limits>
#include <string>

#include "descriptor/registry.h"
#include "support/error.h"

#include "kernel/limits.h"

namespace paradesc {

bool Pass::makes_map() const {
  return stage == Stage::source || std::find(rows.begin(), rows.end(), gradient_row()) != rows.end();
}

static void add_once(std::vector<int> &rows, int row) {
  if (std::find(rows.begin(), rows.end(), row) == rows.end()) rows.push_back(row);
}

static Stage stage_of(int row) {
  const MapNeeds needs = descriptor_row(row).needs;
  return needs == MapNeeds::nothing ? Stage::surface : needs == MapNeeds::value ? Stage::map : Stage::windows;
}

std::vector<Pass> plan_passes(std::span<const int> requested, int map_row) {
  std::vector<Pass> passes{{Stage::surface, {}}, {Stage::source, {}}, {Stage::map, {}}, {Stage::windows, {}}};
  auto rows = [&](Stage stage) -> std::vector<int> & { return passes[static_cast<size_t>(stage)].rows; };
  for (const int row : requested) {
    rows(stage_of(row)).push_back(row);
    if (stage_of(row) != Stage::surface) add_once(rows(Stage::source), map_row);
    if (descriptor_row(row).needs == MapNeeds::gradient) add_once(rows(Stage::map), gradient_row());
  }
  std::erase_if(passes, [](const Pass &pass) { return pass.rows.empty(); });
  return passes;
}

namespace {

struct Done {
  Pass pass;
  CenterResults results;
  const std::vector<float> *find(int row) const {
    const auto found = std::find(pass.rows.begin(), pass.rows.end(), row);
    return found == pass.rows.end() ? nullptr : &results.values[found - pass.rows.begin()];
  }
};

} // namespace

// Copies the map's values or gradients, if a pass computed them, into the map.
static void update_map(const Done &done, int map_row, MapValues &map) {
  if (done.pass.stage == Stage::source) {
    for (const float f : *done.find(map_row)) map.emplace_back(0.0f, 0.0f, 0.0f, f);
  } else if (const std::vector<float> *gradient = done.pass.stage == Stage::map ? done.find(gradient_row()) : nullptr) {
    const float *g = gradient->data();
    for (size_t k = 0; k < map.size(); ++k) map[k] = vec4(g[3 * k], g[3 * k + 1], g[3 * k + 2], map[k].w);
  }
}

CenterResults run_passes(std::span<const int> requested, int map_row, const RunPass &run) {
  const std::vector<Pass> passes = plan_passes(requested, map_row);
  const auto count = static_cast<int>(passes.size());
  MapValues map;
  std::vector<Done> done;
  for (const Pass &pass : passes) {
    const bool with_map = pass.stage == Stage::map || pass.stage == Stage::windows;
    done.push_back({pass, run(pass, with_map ? &map : nullptr, static_cast<int>(done.size()), count)});
    update_map(done.back(), map_row, map);
  }
  std::vector<std::vector<float>> values;
  for (const int row : requested)
    for (const Done &one : done)
      if (const std::vector<float> *found = stage_of(row) == one.pass.stage ? one.find(row) : nullptr) values.push_back(*found);
  CenterResults results = std::move(done[0].results);
  results.values = std::move(values);
  return results;
}

int samples_of(const Pass &pass, const pdesc_options &options) {
  const bool more = pass.stage == Stage::source || pass.stage == Stage::map;
  return more ? std::max(options.samples, std::min(4 * options.samples, 4096)) : options.samples;
}

double radius_of(const Pass &pass, const pdesc_options &options, double radius) {
  return pass.stage == Stage::windows ? WINDOW_RADIUS * options.map_sigma * radius : radius;
}

int find_map(const char *name) {
  const int row = find_descriptor(name ? name : "sphere_volume_normalized");
  const DescriptorRow &found = descriptor_row(row);
  if (found.needs != MapNeeds::nothing || found.components != 1)
    throw Error(PDESC_ERROR_INVALID_ARGUMENT, "The descriptor '" + std::string(found.name) +
                                                  "' cannot be the map of an operator; choose one of the surface that has one "
                                                  "component.");
  return row;
}

} // namespace paradesc
