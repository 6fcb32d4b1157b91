// Every text that reaches a driver, over the settings that choose one: where texts come from, and that graphics cards get larger
// work groups with the same results.
#include "engine/paper/shader_texts.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "descriptor/registry.h"

namespace paradesc {
namespace {

using test::all_settings;
using test::file_of;
using test::Program;
using test::recording;
using test::Settings;
using test::ShaderTexts;

TEST_F(ShaderTexts, come_from_every_file_and_in_every_variant) {
  send_all();
  std::set<std::string> used;
  for (const Program &program : recording.programs)
    for (const auto &[stage, text] : program) used.insert(file_of(text));
  for (const EmbeddedShader &file : embedded_shaders())
    EXPECT_TRUE(!std::string(file.text).starts_with("#version") || used.contains(file.path)) << file.path;
  for (const char *variant : {"MAP 1", "FACES 1", "FACES 0", "CHORDS 1", "DIRECTIONAL 1", "PAPER 1", "PAPER 0", "HALF_FLOATS"})
    EXPECT_TRUE(std::ranges::any_of(recording.programs, [&](const Program &program) { return test::defines(program, variant); }))
        << variant;
}

TEST_F(ShaderTexts, that_draw_have_no_storage_buffers_which_opengl_promises_to_compute_shaders_alone) {
  send_all();
  for (const Program &program : recording.programs)
    for (const auto &[stage, text] : program)
      EXPECT_TRUE(stage == GL_COMPUTE_SHADER || text.find("layout(std430") == std::string::npos) << file_of(text);
}

TEST_F(ShaderTexts, that_evaluate_are_all_among_those_that_settings_can_choose) {
  send_all();
  std::set<Program> known = test::record_all(false);
  known.merge(test::record_all(true));
  for (const Program &program : recording.programs) {
    const std::string &text = program.begin()->second;
    EXPECT_TRUE(file_of(text) != "paper/evaluate/evaluate.comp.glsl" || known.contains(program)) << text.substr(0, 600);
  }
}

// The longest of all programs.
TEST_F(ShaderTexts, of_the_papers_way_with_integrals_and_operators_on_a_map_are_computed) {
  Settings settings = all_settings().front();
  settings.buffer_size = 64;
  settings.relocation = PDESC_RELOCATION_PAPER;
  settings.estimator = PDESC_ESTIMATOR_INTEGRAL;
  const Field field = compute_all(test::open_recording(false), settings, true);
  const auto count = static_cast<size_t>(pdesc_descriptor_count());
  ASSERT_GE(field.values.size(), count);
  for (size_t row = 0; row < count; ++row)
    EXPECT_EQ(std::ranges::any_of(field.values[row], [](float value) { return std::isfinite(value); }),
              descriptors()[row].name != std::string("standard_error")) // texels do not know the noise of positions
        << row;
}

TEST_F(ShaderTexts, have_work_groups_of_64_on_a_card_with_the_same_results) {
  if (test::on_card()) GTEST_SKIP() << "a software device is compared with itself";
  for (const int relocation : {PDESC_RELOCATION_AFFINE, PDESC_RELOCATION_PAPER}) {
    SCOPED_TRACE(relocation);
    Settings settings = all_settings().front();
    settings.relocation = relocation;
    settings.samples = 8; // what marches on a software device does so in several dispatches else, and adds up in another order
    const auto sizes_of = [&](bool pretended, Field &field) {
      test::begin_recording();
      field = compute_all(test::open_recording(pretended), settings, false);
      std::set<std::string> sizes;
      for (const Program &program : recording.programs)
        for (const auto &[stage, text] : program)
          if (const size_t at = text.find("#define GROUP_SIZE "); at != std::string::npos) sizes.insert(text.substr(at + 19, 2));
      return sizes;
    };
    Field small, large;
    EXPECT_EQ(sizes_of(false, small), std::set<std::string>{"16"});
    EXPECT_EQ(sizes_of(true, large), std::set<std::string>{"64"});
    EXPECT_EQ(large.report.backend, PDESC_BACKEND_GPU);
    ASSERT_EQ(small.values.size(), large.values.size());
    for (size_t i = 0; i < small.values.size(); ++i) test::expect_same_bits(small.values[i], large.values[i]);
  }
}

} // namespace
} // namespace paradesc
