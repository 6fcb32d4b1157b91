// Every text that reaches a driver, over the settings that choose one: a compiler that is stricter than this machine's driver
// takes them all, and graphics cards get larger work groups with the same results.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <vector>

#if defined(__unix__)
#include <unistd.h>
#define CAN_START_PROGRAMS // the texts are the same on every system
#endif

#include <gtest/gtest.h>

#include "bake/surface_maps.h"
#include "compute/compute.h"
#include "context.h"
#include "engine/opengl/faults.h"
#include "support/layout.h"
#include "support/run.h"

namespace paradesc {
namespace {

using test::Settings;

// ---- A driver that remembers what it is given. Functions of C have no state of their own.

std::set<std::pair<GLenum, std::string>> texts; // with the stage of each
std::map<GLuint, GLenum> stages;
PFNGLCREATESHADERPROC real_create = nullptr;
PFNGLSHADERSOURCEPROC real_source = nullptr;
PFNGLGETSTRINGPROC real_string = nullptr;
PFNGLDISPATCHCOMPUTEPROC real_dispatch = nullptr;
bool computes = true;

GLuint APIENTRY create_shader(GLenum stage) {
  const GLuint shader = real_create(stage);
  stages[shader] = stage;
  return shader;
}
void APIENTRY shader_source(GLuint shader, GLsizei count, const GLchar *const *strings, const GLint *lengths) {
  std::string text;
  for (GLsizei i = 0; i < count; ++i) text += strings[i];
  texts.emplace(stages[shader], text);
  real_source(shader, count, strings, lengths);
}
void APIENTRY dispatch(GLuint x, GLuint y, GLuint z) {
  if (computes) real_dispatch(x, y, z);
}
const GLubyte *APIENTRY card_name(GLenum name) {
  return name == GL_RENDERER ? reinterpret_cast<const GLubyte *>("Pretended card") : real_string(name);
}
const char *no_device_extensions(void *, int32_t) { return ""; }

// pretended: the software rasterizer shows itself as a graphics card.
std::shared_ptr<Context> open_remembering(bool pretended) {
  test::FailingDriver driver;
  driver.put("glCreateShader", create_shader).put("glShaderSource", shader_source).put("glDispatchCompute", dispatch);
  if (pretended) driver.put("glGetString", card_name).put("eglQueryDeviceStringEXT", no_device_extensions);
  pdesc_context_options requested;
  pdesc_context_options_init(&requested);
  requested.backend = pretended ? PDESC_BACKEND_GPU : PDESC_BACKEND_SOFTWARE;
  return make_context(requested, [put = DriverSubstitute(driver)](const char *name, void *found) {
    const std::string called = name;
    if (called == "glCreateShader") real_create = reinterpret_cast<PFNGLCREATESHADERPROC>(found);
    if (called == "glShaderSource") real_source = reinterpret_cast<PFNGLSHADERSOURCEPROC>(found);
    if (called == "glDispatchCompute") real_dispatch = reinterpret_cast<PFNGLDISPATCHCOMPUTEPROC>(found);
    if (called == "glGetString") real_string = reinterpret_cast<PFNGLGETSTRINGPROC>(found);
    return put(name, found);
  });
}

class ShaderTexts : public ::testing::Test {
protected:
  void SetUp() override {
    std::string why_not;
    if (!test::open_context(PDESC_BACKEND_SOFTWARE, why_not)) GTEST_SKIP() << why_not;
    texts.clear();
    stages.clear();
    mesh = test::saddle(1, {.vertices = 200});
    test::lay_out(mesh, {.charts = 9});
  }

  // Computes every row, or, without operators, those that a driver can finish that computes nothing.
  Field compute_all(const std::shared_ptr<Context> &context, const Settings &settings, bool operators,
                    bool displaced = false) const {
    const auto native = make_mesh(context, input_of(mesh));
    const std::vector<float> heights = {0.4f, 0.5f, 0.6f, 0.5f};
    if (displaced) set_displacement(native->maps, native->triangles, heights.data(), 2, 2, 0.5, 0.05);
    std::vector<int> rows;
    const std::vector<std::string> names = test::registered_descriptors();
    for (size_t row = 0; row < names.size(); ++row)
      if (operators || test::map_degree_of(names[row]) == 0) rows.push_back(static_cast<int>(row));
    const Field field = compute(*native, test::options_of(settings), rows, [](const char *, double) { return true; });
    read_buffer(*native, "distortion");
    return field;
  }

  // Programs are made, and nothing is computed: a software device would take most of a second for each.
  void make_programs(const std::shared_ptr<Context> &context, const Settings &settings) const {
    computes = false;
    try {
      compute_all(context, settings, false);
      ADD_FAILURE() << "nothing was computed, and that was not found out";
    } catch (const Error &error) {
      EXPECT_NE(std::string(error.what()).find("without a result"), std::string::npos) << error.what();
    }
    computes = true;
  }

  test::TestMesh mesh;
};

// One after the other, what differs from the first.
std::vector<Settings> all_settings() {
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

#if defined(CAN_START_PROGRAMS)
// The file that a text is written to: its ending names the stage.
std::string file_name(size_t number, GLenum stage) {
  const char *ending = stage == GL_VERTEX_SHADER ? ".vert" : stage == GL_FRAGMENT_SHADER ? ".frag" : ".comp";
  return std::to_string(number) + ending;
}

// What a command prints, and its exit status.
std::pair<std::string, int> output_of(const std::string &command) {
  std::string output;
  FILE *pipe = popen((command + " 2>&1").c_str(), "r");
  if (!pipe) return {"it could not be started", -1};
  char part[4096];
  while (const size_t count = fread(part, 1, sizeof part, pipe)) output.append(part, count);
  return {output, pclose(pipe)};
}

TEST_F(ShaderTexts, are_taken_by_khronos_own_compiler) {
  if (output_of("glslangValidator --version").second != 0)
    GTEST_SKIP() << "glslangValidator is not installed (package glslang-tools), which reads texts more strictly than drivers do";
  const auto context = open_remembering(false);
  for (const Settings &settings : all_settings()) make_programs(context, settings);
  make_programs(open_remembering(true), all_settings().front());
  // These texts are used only later: operators on a map, displaced texels, ambiguous centers.
  Settings later = all_settings().front();
  later.buffer_size = 64;
  mesh = test::ellipsoid(1, 1, 0.05, {.vertices = 800});
  test::lay_out(mesh, {.charts = 9});
  compute_all(context, later, true, true);
  compute_all(context, later, false);
  for (const char *variant : {"MAP 1", "EXACT 1", "TEXELLESS 1", "LISTED 1", "FACES 1", "FACES 0", "CHORDS 1", "DIRECTIONAL 1",
                              "PAPER 1", "HALF_FLOATS"})
    EXPECT_TRUE(std::ranges::any_of(texts, [&](const auto &text) {
      return text.second.find(std::string("#define ") + variant) != std::string::npos;
    })) << variant;
  std::set<GLenum> seen;
  const auto folder = std::filesystem::temp_directory_path() / ("paradesc_texts_" + std::to_string(getpid()));
  std::filesystem::create_directory(folder);
  std::string files;
  size_t number = 0;
  for (const auto &[stage, text] : texts) {
    const std::string name = file_name(number++, stage);
    std::ofstream(folder / name) << text;
    files += " " + name;
    seen.insert(stage);
  }
  EXPECT_EQ(seen, (std::set<GLenum>{GL_VERTEX_SHADER, GL_FRAGMENT_SHADER, GL_COMPUTE_SHADER}));
  const auto [output, status] = output_of("cd " + folder.string() + " && glslangValidator" + files);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(output.find("ERROR"), std::string::npos) << output.substr(0, 4000);
  std::filesystem::remove_all(folder);
}
#endif

TEST_F(ShaderTexts, have_work_groups_of_64_on_a_card_with_the_same_results) {
  for (const int relocation : {PDESC_RELOCATION_CONNECTED, PDESC_RELOCATION_AFFINE, PDESC_RELOCATION_PAPER}) {
    SCOPED_TRACE(relocation);
    Settings settings = all_settings().front();
    settings.relocation = relocation;
    settings.samples = 8; // what marches on a software device does so in several dispatches else, and adds up in another order
    const auto sizes_of = [&](bool pretended, Field &field) {
      texts.clear();
      field = compute_all(open_remembering(pretended), settings, false);
      std::set<std::string> sizes;
      for (const auto &[stage, text] : texts)
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
