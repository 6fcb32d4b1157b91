// A million triangles → seconds of every step that depends on topology and UV map, and of normals beside them.
//
// PARADESC_BENCH_MESH names a mesh to take instead of the torus, in the format of mesh_file.h.
// PARADESC_BENCH_DUMP names a folder for the arrays that a file could keep; nothing is timed then.
#include <cstdlib>
#include <fstream>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "bench/mesh_file.h"
#include "mesh/cut.h"
#include "mesh/halfedge.h"
#include "mesh/layout.h"
#include "mesh/normals.h"
#include "engine/paper/border_grid.h"
#include "support/layout.h"
#include "support/surfaces.h"

namespace paradesc::test {
namespace {

constexpr int buffer_size = 1024;

TestMesh torus_of_60_charts() {
  TestMesh mesh = torus(1.0, 0.4, {.vertices = 500000, .irregular = false});
  lay_out(mesh, {.charts = 60});
  return mesh;
}

// Every step's input, made once.
struct Made {
  TestMesh mesh;
  Triangles triangles;
  HalfEdges half_edges;
  Charts charts;
  NormalRings rings;
};

const Made &made() {
  static const Made once = [] {
    Made result;
    const char *path = std::getenv("PARADESC_BENCH_MESH");
    result.mesh = path ? bench::read_mesh(path) : torus_of_60_charts();
    result.triangles = read_triangles(input_of(result.mesh));
    result.half_edges = build_half_edges(result.triangles);
    result.charts = build_charts(result.triangles, result.half_edges);
    result.rings = build_normal_rings(result.triangles, result.half_edges);
    return result;
  }();
  return once;
}

// A step of the preprocessing; its time also in seconds per million triangles.
template <class Step> void measure(benchmark::State &state, const Step &step) {
  const Made &from = made();
  for (auto _ : state) benchmark::DoNotOptimize(step(from));
  state.counters["per_million"] = benchmark::Counter(1e-6 * from.triangles.triangle_count,
                                                     benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void triangles(benchmark::State &state) {
  measure(state, [](const Made &from) { return read_triangles(input_of(from.mesh)); });
}
void half_edges(benchmark::State &state) {
  measure(state, [](const Made &from) { return build_half_edges(from.triangles); });
}
void charts(benchmark::State &state) {
  measure(state, [](const Made &from) { return build_charts(from.triangles, from.half_edges); });
}
void normal_rings(benchmark::State &state) {
  measure(state, [](const Made &from) { return build_normal_rings(from.triangles, from.half_edges); });
}
void border_grid(benchmark::State &state) {
  measure(state, [](const Made &from) { return build_border_grid(from.charts, buffer_size); });
}
// Cutting is needed only where the UV map is under suspicion.
void cut(benchmark::State &state) {
  measure(state, [](const Made &from) { return cut_charts(from.half_edges, from.charts); });
}
void layout(benchmark::State &state) {
  measure(state, [](const Made &from) {
    Triangles moved = from.triangles;
    Charts around = from.charts;
    return repack_charts(moved, around);
  });
}
// Normals depend on positions: they are computed every frame.
void normals(benchmark::State &state) {
  measure(state,
          [](const Made &from) { return compute_normals(from.triangles, from.half_edges, from.rings, PDESC_NORMALS_FITTED, 0); });
}
// Every array of indices that depends on topology and UV map alone, but for where the lists of rings begin.
struct Kept {
  const char *name;
  std::span<const int32_t> values;
  size_t limit; // of the values, exclusive
};

std::vector<Kept> kept_arrays(const Made &from) {
  const auto corners = from.triangles.corner_vertex.size(), points = static_cast<size_t>(from.half_edges.point_count);
  const auto vertices = static_cast<size_t>(from.triangles.vertex_count), wedges = from.charts.wedges.size();
  const auto fans = static_cast<size_t>(from.rings.fan_count);
  return {{"twin", from.half_edges.twin, corners},
          {"corner_point", from.half_edges.corner_point, points},
          {"point_vertex", from.half_edges.point_vertex, vertices},
          {"point_half_edge", from.half_edges.point_half_edge, corners},
          {"vertex_point", from.half_edges.vertex_point, points},
          {"triangle_chart", from.charts.triangle_chart, static_cast<size_t>(from.charts.chart_count)},
          {"corner_wedge", from.charts.corner_wedge, wedges},
          {"half_edge_border", from.charts.half_edge_border, from.charts.borders.size()},
          {"point_wedge", from.charts.point_wedge, wedges},
          {"corner_fan", *from.rings.corner_fan, fans},
          {"fan_point", from.rings.fan_point, points},
          {"point_fan", from.rings.point_fan, fans},
          {"fan_vertex", from.rings.fan_vertex, vertices},
          {"ring_vertex", from.rings.ring_vertex, vertices},
          {"face", from.rings.face, corners / 3}};
}

// The least that a reader of such a file has to do: take the arrays over, and look that no index leads astray.
void take_over(benchmark::State &state) {
  measure(state, [](const Made &from) {
    size_t bad = 0;
    std::vector<std::vector<int32_t>> taken;
    for (const Kept &kept : kept_arrays(from)) {
      taken.emplace_back(kept.values.begin(), kept.values.end());
      for (const int32_t value : taken.back()) bad += value < -1 || (value >= 0 && static_cast<size_t>(value) >= kept.limit);
    }
    const std::vector<int32_t> &twin = taken.front();
    for (size_t h = 0; h < twin.size(); ++h) bad += twin[h] >= 0 && twin[static_cast<size_t>(twin[h])] != static_cast<int32_t>(h);
    benchmark::DoNotOptimize(taken.data());
    return bad;
  });
}

void dump(const std::string &folder) {
  for (const Kept &kept : kept_arrays(made())) {
    std::ofstream file(folder + "/" + kept.name, std::ios::binary);
    file.write(reinterpret_cast<const char *>(kept.values.data()), static_cast<std::streamsize>(kept.values.size_bytes()));
  }
}

#define PARADESC_STEP(step) BENCHMARK(step)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime()
PARADESC_STEP(triangles);
PARADESC_STEP(half_edges);
PARADESC_STEP(charts);
PARADESC_STEP(normal_rings);
PARADESC_STEP(border_grid);
PARADESC_STEP(cut);
PARADESC_STEP(layout);
PARADESC_STEP(normals);
PARADESC_STEP(take_over);

} // namespace
} // namespace paradesc::test

int main(int count, char **arguments) {
  if (const char *folder = std::getenv("PARADESC_BENCH_DUMP")) {
    paradesc::test::dump(folder);
    return 0;
  }
  benchmark::Initialize(&count, arguments);
  if (benchmark::ReportUnrecognizedArguments(count, arguments)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
