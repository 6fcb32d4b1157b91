// A torus of 70,000 triangles → milliseconds of every stage of a frame, through the C interface alone: by the clock where a stage
// is a call, else as the field's report says. One chart, many charts, many jumps. preprocessing_bench.cpp has the steps of the
// mesh stage.
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include "support/layout.h"
#include "support/surfaces.h"

namespace paradesc::bench {
namespace {

constexpr int vertices = 35000;

void check(int32_t status) {
  if (status != PDESC_OK) throw std::runtime_error(pdesc_last_error());
}

pdesc_context *context() {
  static pdesc_context *once = [] {
    pdesc_context_options options;
    pdesc_context_options_init(&options);
    pdesc_context *made = nullptr;
    check(pdesc_context_create(&options, &made));
    return made;
  }();
  return once;
}

const test::TestMesh &surface(int charts) {
  static std::map<int, test::TestMesh> kept;
  if (!kept.contains(charts)) {
    test::TestMesh made = test::torus(1.0, 0.4, {.vertices = vertices});
    test::lay_out(made, {.charts = charts});
    kept.emplace(charts, std::move(made));
  }
  return kept.at(charts);
}

pdesc_mesh *make_mesh(int charts) {
  const pdesc_mesh_input input = test::input_of(surface(charts));
  pdesc_mesh *mesh = nullptr;
  check(pdesc_mesh_create(context(), &input, &mesh));
  return mesh;
}

// A mesh after its first frame; left to the process's end.
pdesc_mesh *mesh_of(int charts) {
  static std::map<int, pdesc_mesh *> kept;
  if (!kept.contains(charts)) kept[charts] = make_mesh(charts);
  return kept.at(charts);
}

pdesc_options options_of(int relocation) {
  pdesc_options options;
  pdesc_options_init(&options);
  options.relocation = relocation;
  return options;
}

pdesc_field *compute(pdesc_mesh *mesh, const pdesc_options &options) {
  const char *name = "mean_curvature";
  pdesc_field *field = nullptr;
  check(pdesc_compute(mesh, &options, &name, 1, nullptr, nullptr, &field));
  return field;
}

pdesc_field_report frame(pdesc_mesh *mesh, const pdesc_options &options) {
  pdesc_field *field = compute(mesh, options);
  pdesc_field_report report;
  pdesc_field_report_init(&report);
  check(pdesc_field_get_report(field, &report));
  pdesc_field_destroy(field);
  return report;
}

template <class Body> void guarded(benchmark::State &state, const Body &body) {
  try {
    body();
  } catch (const std::exception &error) {
    state.SkipWithError(error.what());
  }
}

using Stage = double pdesc_field_report::*;

// One stage of the report; charts of the mesh, relocation.
void reported(benchmark::State &state, Stage stage) {
  guarded(state, [&] {
    const auto charts = static_cast<int>(state.range(0));
    const pdesc_options options = options_of(static_cast<int>(state.range(1)));
    pdesc_mesh *mesh = mesh_of(charts);
    frame(mesh, options);                                 // what is made once, and programs
    std::vector<float> moved = surface(charts).positions; // what has not moved need not be baked again
    float factor = 1.0f + 1e-5f;
    for (auto _ : state) {
      for (float &coordinate : moved) coordinate *= factor;
      factor = 1.0f / factor;
      check(pdesc_mesh_set_positions(mesh, moved.data(), surface(charts).vertex_count));
      state.SetIterationTime(frame(mesh, options).*stage);
    }
  });
}

void mesh_stage(benchmark::State &state) {
  guarded(state, [&] {
    for (auto _ : state) pdesc_mesh_destroy(make_mesh(static_cast<int>(state.range(0))));
  });
}

void upload_positions(benchmark::State &state) {
  guarded(state, [&] {
    const test::TestMesh &shape = surface(60);
    pdesc_mesh *mesh = mesh_of(60);
    for (auto _ : state) check(pdesc_mesh_set_positions(mesh, shape.positions.data(), shape.vertex_count));
  });
}

// "position" is read back as it is, "distortion" is made first.
void read_buffer(benchmark::State &state, const char *name, int components) {
  guarded(state, [&] {
    pdesc_mesh *mesh = mesh_of(60);
    frame(mesh, options_of(PDESC_RELOCATION_AFFINE));
    const auto size = static_cast<size_t>(pdesc_mesh_buffer_size(mesh));
    std::vector<float> values(size * size * static_cast<size_t>(components));
    for (auto _ : state) check(pdesc_mesh_read_buffer(mesh, name, values.data(), static_cast<int64_t>(values.size())));
  });
}

void field_values(benchmark::State &state) {
  guarded(state, [&] {
    pdesc_field *field = compute(mesh_of(60), options_of(PDESC_RELOCATION_AFFINE));
    std::vector<float> values(static_cast<size_t>(surface(60).vertex_count));
    for (auto _ : state) check(pdesc_field_values(field, "mean_curvature", values.data(), static_cast<int32_t>(values.size())));
    pdesc_field_destroy(field);
  });
}

constexpr int affine = PDESC_RELOCATION_AFFINE, paper = PDESC_RELOCATION_PAPER;
#define PARADESC_STAGE(name, stage)                                                                                              \
  BENCHMARK_CAPTURE(reported, name, &pdesc_field_report::stage)                                                                  \
      ->Unit(benchmark::kMillisecond)                                                                                            \
      ->UseManualTime()                                                                                                          \
      ->ArgNames({"charts", "relocation"})
BENCHMARK(mesh_stage)->Unit(benchmark::kMillisecond)->UseRealTime()->ArgName("charts")->Arg(1)->Arg(60)->Arg(1000);
BENCHMARK(upload_positions)->Unit(benchmark::kMillisecond)->UseRealTime();
PARADESC_STAGE(prepare, seconds_prepare)->Args({1, affine})->Args({60, affine});
PARADESC_STAGE(bake, seconds_bake)->Args({1, affine})->Args({60, affine});
PARADESC_STAGE(evaluate_one_chart, seconds_evaluate)->Args({1, affine})->Args({1, paper});
PARADESC_STAGE(evaluate_many_charts, seconds_evaluate)->Args({60, affine})->Args({60, paper});
PARADESC_STAGE(evaluate_many_jumps, seconds_evaluate)->Args({1000, affine})->Args({1000, paper});
PARADESC_STAGE(whole_compute, seconds_total)->Args({1, affine})->Args({60, affine})->Args({1000, affine});
BENCHMARK_CAPTURE(read_buffer, read_back, "position", 3)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(read_buffer, distortion_and_read_back, "distortion", 4)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(field_values)->Unit(benchmark::kMillisecond)->UseRealTime();

} // namespace
} // namespace paradesc::bench

BENCHMARK_MAIN();
