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
#include "engine/paper/evaluator.h"
#include "engine/paper/gl_thread.h"
#include "engine/paper/recorder.h"
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
  Settings plain{
      .radius = 0.08, .samples = 16, .buffer_size = 128, .relocation = PDESC_RELOCATION_AFFINE, .texels = 16, .map_sigma = 0.5};
  std::vector<Settings> all = {plain};
  auto vary = [&](auto member, auto value) {
    all.push_back(plain);
    all.back().*member = value;
  };
  vary(&Settings::estimator, PDESC_ESTIMATOR_INTEGRAL);
  vary(&Settings::estimator, PDESC_ESTIMATOR_EXTRAPOLATED);
  vary(&Settings::variance_reduction, PDESC_VARIANCE_REDUCTION_NONE);
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

// Sends all programs to a driver: one after the other what settings choose, and what is used only later, operators on a map and
// displaced texels.
inline void ShaderTexts::send_all() {
  static std::set<Program> sent; // once for all tests of a process
  if (sent.empty()) {
    const auto context = open_recording(false);
    for (const Settings &settings : all_settings()) make_programs(context, settings);
    make_programs(open_recording(true), all_settings().front());
    Settings later = all_settings().front();
    later.buffer_size = 64;
    compute_all(context, later, true, true);
    later.precision = PDESC_PRECISION_HALF;
    compute_all(context, later, true);
    sent = recording.programs;
  }
  recording.programs = sent;
}

// ---- Every program that evaluates centers

struct Variant : EvaluateSettings {
  bool half = false;
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

// Returns the rows of each pass if every descriptor is asked for.
inline std::vector<std::vector<int>> rows_of_passes() {
  std::vector<int> every_row;
  for (int row = 0; row < pdesc_descriptor_count(); ++row) every_row.push_back(row);
  std::vector<std::vector<int>> rows;
  for (const Pass &pass : plan_passes(every_row, find_map(nullptr))) rows.push_back(pass.rows);
  return rows;
}

inline std::vector<Variant> all_variants() {
  std::vector<Variant> all(1);
  multiply(all, &Variant::rows, rows_of_passes());
  multiply(all, &Variant::estimator, {PDESC_ESTIMATOR_SHAPE_OPERATOR, PDESC_ESTIMATOR_INTEGRAL, PDESC_ESTIMATOR_EXTRAPOLATED});
  multiply(all, &Variant::geodesic_ball, {false, true});
  multiply(all, &Variant::adaptive, {0.0f, 0.1f});
  multiply(all, &Variant::half, {false, true});
  multiply(all, &Variant::displaced, {false, true});
  std::erase_if(all, [](const Variant &variant) { return variant.half && variant.displaced; }); // see bake_stage.cpp
  multiply(all, &Variant::paper, {false, true});
  multiply(all, &Variant::ellipse, {PDESC_ELLIPSE_CENTER, PDESC_ELLIPSE_DIRECTIONAL});
  multiply(all, &Variant::chords, {false, true});
  return all;
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
  multiply(all, &Variant::paper, {false, true});
  return all;
}

// As the library composes them; the driver neither compiles nor computes. pretended: for a card.
inline std::set<Program> record(std::vector<Variant> variants, bool pretended) {
  const std::set<Program> before = std::exchange(recording.programs, {});
  recording.compiles = false;
  GlThread(!pretended && !on_card(), -1, recording_driver(pretended)).run([&](const Gl &gl, ProgramCache &programs) {
    for (Variant &variant : variants) {
      variant.descriptors = variant.rows;
      variant.map = descriptor_row(variant.rows[0]).needs != MapNeeds::nothing;
      evaluate_program(gl, programs, variant, variant.half ? "#define HALF_FLOATS\n" : "");
    }
  });
  recording.compiles = true;
  return std::exchange(recording.programs, before);
}

inline std::set<Program> record_all(bool pretended) { return record(all_variants(), pretended); }
inline std::set<Program> record_plain(bool pretended) { return record(plain_variants(), pretended); }

} // namespace paradesc::test
