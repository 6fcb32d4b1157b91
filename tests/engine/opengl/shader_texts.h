// Every program that the library can send to a driver: by computing with all settings, and by composing all variants.
#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "bake/surface_maps.h"
#include "compute/compute.h"
#include "context.h"
#include "descriptor/passes.h"
#include "descriptor/registry.h"
#include "engine/opengl/evaluator.h"
#include "engine/opengl/gl_thread.h"
#include "engine/opengl/neighborhood_search.h"
#include "engine/opengl/recorder.h"
#include "shared.h"
#include "support/device.h"
#include "support/error.h"
#include "support/layout.h"
#include "support/run.h"

namespace paradesc::test {

inline std::shared_ptr<paradesc::Context> open_recording(bool pretended) {
  pdesc_context_options requested;
  pdesc_context_options_init(&requested);
  requested.backend = pretended ? PDESC_BACKEND_GPU : device_backend();
  return make_context(requested, recording_driver(pretended));
}

inline bool defines(const Program &program, const std::string &words) {
  return std::ranges::any_of(
      program, [&](const auto &stage) { return (stage.second + "\n").find("#define " + words + "\n") != std::string::npos; });
}

// The path of the file that a text was composed from: program.cpp lists the files at its end.
inline std::string file_of(const std::string &text) {
  const size_t at = text.rfind("// 0: ") + 6;
  return text.substr(at, text.find('\n', at) - at);
}

class ShaderTexts : public ::testing::Test {
protected:
  void SetUp() override {
    std::string why_not;
    if (!open_context(device_backend(), why_not)) GTEST_SKIP() << why_not;
    begin_recording();
    mesh = saddle(1, {.vertices = 200});
    lay_out(mesh, {.charts = 9});
  }

  // Computes every row, or, without operators, those that a driver can finish that computes nothing.
  paradesc::Field compute_all(const std::shared_ptr<paradesc::Context> &context, const Settings &settings, bool operators,
                              bool displaced = false) const {
    const auto native = paradesc::make_mesh(context, input_of(mesh));
    move_mesh(*native, mesh.positions.data(), mesh.vertex_count); // devices fit the normals of meshes that move
    const std::vector<float> heights = {0.4f, 0.5f, 0.6f, 0.5f};
    if (displaced) set_displacement(native->maps, native->triangles, heights.data(), 2, 2, 0.5, 0.05);
    std::vector<int> rows;
    const std::vector<std::string> names = registered_descriptors();
    for (size_t row = 0; row < names.size(); ++row)
      if (operators || map_degree_of(names[row]) == 0) rows.push_back(static_cast<int>(row));
    const paradesc::Field field =
        paradesc::compute(*native, options_of(settings), rows, [](const char *, double) { return true; });
    read_buffer(*native, "distortion");
    return field;
  }

  // Programs are made, and nothing is computed: a software device would take most of a second for each.
  void make_programs(const std::shared_ptr<paradesc::Context> &context, const Settings &settings) const {
    recording.computes = false;
    try {
      compute_all(context, settings, false);
      ADD_FAILURE() << "nothing was computed, and that was not found out";
    } catch (const Error &error) {
      EXPECT_NE(std::string(error.what()).find("without a result"), std::string::npos) << error.what();
    }
    recording.computes = true;
  }

  void send_all();

  TestMesh mesh;
};

// ---- The settings that choose a text

// One after the other, what differs from the first.
inline std::vector<Settings> all_settings() {
  Settings plain{.radius = 0.08, .samples = 16, .buffer_size = 128, .texels = 16, .map_sigma = 0.5};
  std::vector<Settings> all = {plain};
  auto vary = [&](auto member, auto value) {
    all.push_back(plain);
    all.back().*member = value;
  };
  vary(&Settings::estimator, PDESC_ESTIMATOR_INTEGRAL);
  vary(&Settings::estimator, PDESC_ESTIMATOR_EXTRAPOLATED);
  vary(&Settings::variance_reduction, PDESC_VARIANCE_REDUCTION_NONE);
  vary(&Settings::distance, PDESC_DISTANCE_GEODESIC);
  vary(&Settings::precision, PDESC_PRECISION_HALF);
  vary(&Settings::adaptive, 0.1);
  vary(&Settings::evaluate, PDESC_EVALUATE_TEXEL);
  for (const int relocation : {PDESC_RELOCATION_AFFINE, PDESC_RELOCATION_PAPER}) {
    plain.relocation = relocation;
    all.push_back(plain);
    vary(&Settings::estimator, PDESC_ESTIMATOR_INTEGRAL);
    vary(&Settings::distance, PDESC_DISTANCE_GEODESIC);
    vary(&Settings::precision, PDESC_PRECISION_HALF);
    vary(&Settings::adaptive, 0.1);
    vary(&Settings::geodesic, PDESC_GEODESIC_CHORDS);
    vary(&Settings::ellipse, PDESC_ELLIPSE_DIRECTIONAL);
  }
  return all;
}

// Sends all programs to a driver: one after the other what settings choose, and what is used only later, operators on a map,
// displaced texels and ambiguous centers.
inline void ShaderTexts::send_all() {
  static std::set<Program> sent; // once for all tests of a process
  if (sent.empty()) {
    const auto context = open_recording(false);
    for (const Settings &settings : all_settings()) make_programs(context, settings);
    make_programs(open_recording(true), all_settings().front());
    Settings later = all_settings().front();
    later.buffer_size = 64;
    mesh = ellipsoid(1, 1, 0.05, {.vertices = 800});
    lay_out(mesh, {.charts = 9});
    compute_all(context, later, true, true);
    compute_all(context, later, false);
    later.precision = PDESC_PRECISION_HALF;
    compute_all(context, later, true);
    sent = recording.programs;
  }
  recording.programs = sent;
}

// ---- Every program that evaluates centers, or finds their neighborhoods

struct Variant : EvaluateSettings {
  bool half = false, texelless = false, listed = false;
  std::vector<int> rows;
};

// Each of these with each value.
template <class Owner, class Value>
void multiply(std::vector<Variant> &all, Value Owner::*member, const std::vector<std::type_identity_t<Value>> &values) {
  std::vector<Variant> product;
  for (const Variant &variant : all)
    for (const Value &value : values) {
      product.push_back(variant);
      product.back().*member = value;
    }
  all.swap(product);
}

// What is computed together where everything is asked for.
inline std::vector<std::vector<int>> rows_of_passes() {
  std::vector<int> every_row;
  for (int row = 0; row < pdesc_descriptor_count(); ++row) every_row.push_back(row);
  std::vector<std::vector<int>> rows;
  for (const Pass &pass : plan_passes(every_row, find_map(nullptr))) rows.push_back(pass.rows);
  return rows;
}

inline std::vector<Variant> all_variants() {
  std::vector<Variant> connected(1);
  multiply(connected, &Variant::rows, rows_of_passes());
  multiply(connected, &Variant::estimator,
           {PDESC_ESTIMATOR_SHAPE_OPERATOR, PDESC_ESTIMATOR_INTEGRAL, PDESC_ESTIMATOR_EXTRAPOLATED});
  multiply(connected, &Variant::geodesic_ball, {false, true});
  multiply(connected, &Variant::adaptive, {0.0f, 0.1f});
  multiply(connected, &Variant::half, {false, true});
  multiply(connected, &Variant::displaced, {false, true});
  std::erase_if(connected, [](const Variant &variant) { return variant.half && variant.displaced; }); // see bake_stage.cpp
  std::vector<Variant> marching = connected;
  multiply(connected, &Variant::relocation, {PDESC_RELOCATION_CONNECTED});
  multiply(connected, &Variant::texelless, {false, true});
  multiply(connected, &Variant::listed, {false, true});
  multiply(connected, &Variant::exact, {false, true});
  multiply(marching, &Variant::relocation, {PDESC_RELOCATION_AFFINE, PDESC_RELOCATION_PAPER});
  multiply(marching, &Variant::ellipse, {PDESC_ELLIPSE_CENTER, PDESC_ELLIPSE_DIRECTIONAL});
  multiply(marching, &Variant::chords, {false, true});
  connected.insert(connected.end(), marching.begin(), marching.end());
  return connected;
}

// One descriptor alone, and all of a pass, in the ways that most are asked for.
inline std::vector<Variant> plain_variants() {
  std::vector<Variant> all;
  for (int row = 0; row < pdesc_descriptor_count(); ++row) {
    all.emplace_back();
    all.back().rows = {row};
  }
  for (const std::vector<int> &rows : rows_of_passes()) {
    all.emplace_back();
    all.back().rows = rows;
  }
  multiply(all, &Variant::relocation, {PDESC_RELOCATION_CONNECTED, PDESC_RELOCATION_AFFINE, PDESC_RELOCATION_PAPER});
  multiply(all, &Variant::listed, {false, true});
  multiply(all, &Variant::exact, {false, true});
  std::erase_if(all, [](const Variant &variant) {
    return variant.relocation != PDESC_RELOCATION_CONNECTED && (variant.listed || variant.exact);
  });
  return all;
}

inline std::vector<SearchVariant> search_variants(const std::vector<int> &all_words) {
  std::vector<SearchVariant> all;
  for (const bool over_links : {false, true})
    for (const bool exact : {false, true})
      for (const bool halves : {false, true})
        for (const bool texelless : {false, true})
          for (const bool fine : {false, true})
            for (const int words : all_words) all.push_back({over_links, exact, halves, texelless, fine, words});
  return all;
}

// As the library composes them; the driver neither compiles nor computes. pretended: for a card.
inline std::set<Program> record(std::vector<Variant> variants, const std::vector<SearchVariant> &searches, bool pretended) {
  const std::set<Program> before = std::exchange(recording.programs, {});
  recording.compiles = false;
  GlThread(!pretended && !on_card(), -1, recording_driver(pretended)).run([&](const Gl &gl, ProgramCache &programs) {
    const MapBuffer map(gl, 1);
    const BufferTexture points;
    for (Variant &variant : variants) {
      variant.descriptors = variant.rows;
      variant.map = descriptor_row(variant.rows[0]).needs == MapNeeds::nothing ? nullptr : &map;
      variant.points = variant.listed ? &points : nullptr;
      evaluate_program(gl, programs, variant, variant.half ? "#define HALF_FLOATS\n" : "", variant.texelless);
    }
    for (const SearchVariant &variant : searches) neighborhoods_program(gl, programs, variant);
    for (const int patches : flood_rooms()) flood_program(gl, programs, patches);
  });
  recording.compiles = true;
  return std::exchange(recording.programs, before);
}

inline std::set<Program> record_all(bool pretended) {
  return record(all_variants(), search_variants({1, 2, 3, 4, 5, 6, 7, 8, 16, 32}), pretended);
}
inline std::set<Program> record_plain(bool pretended) { return record(plain_variants(), search_variants({2}), pretended); }

} // namespace paradesc::test
