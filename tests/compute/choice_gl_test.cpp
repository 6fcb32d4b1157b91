// The processor computes under AUTO, and the software device what it alone can.
#include "compute/choice.h"

#include <atomic>
#include <string>
#include <vector>

#include "compute/compute.h"
#include "compute/memory.h"
#include "descriptor/registry.h"
#include "engine/paper/faults.h"
#include "support/api_fixture.h"

namespace paradesc {
namespace {

class Choice : public ::testing::Test {
protected:
  void SetUp() override {
    ball = test::sphere(1, {.vertices = 400});
    test::lay_out(ball, {.charts = 6});
    pdesc_options_init(&options);
    options.radius = 0.1;
    options.samples = 16;
  }

  // Without the library that devices are reached through, as on machines without any.
  static std::shared_ptr<Context> open(int32_t backend, bool with_library = true) {
    pdesc_context_options requested;
    pdesc_context_options_init(&requested);
    requested.backend = backend;
    return with_library ? make_context(requested) : make_context(requested, test::FailingDriver().without(test::driver_library));
  }
  static bool has_software() {
    std::string why_not;
    return test::open_context(PDESC_BACKEND_SOFTWARE, why_not) != nullptr;
  }
  std::unique_ptr<Mesh> mesh_on(const std::shared_ptr<Context> &context) const { return make_mesh(context, input_of(ball)); }
  Field compute_on(Mesh &mesh) const {
    const std::vector<int> requested = {find_descriptor("mean_curvature")};
    return compute(mesh, options, requested, [](const char *, double) { return true; });
  }

  // Each option that texture space alone has, with a word that says so.
  struct Need {
    const char *word;
    void (*ask)(pdesc_options &);
  };
  static constexpr Need needs[] = {
      {"relocation affine", [](pdesc_options &o) { o.relocation = PDESC_RELOCATION_AFFINE; }},
      {"relocation paper", [](pdesc_options &o) { o.relocation = PDESC_RELOCATION_PAPER; }},
      {"half floats", [](pdesc_options &o) { o.precision = PDESC_PRECISION_HALF; }},
      {"adaptive sampling", [](pdesc_options &o) { o.adaptive = 0.05; }},
      {"baked buffers", [](pdesc_options &o) { o.buffers = 1; }},
  };

  // Each need by itself, in one sentence that names it and has these words.
  void expect_all_refused(Mesh &mesh, int32_t status, std::initializer_list<const char *> words) {
    const pdesc_options usual = options;
    for (const Need &need : needs) {
      options = usual;
      need.ask(options);
      try {
        compute_on(mesh);
        ADD_FAILURE() << need.word << " was computed";
      } catch (const Error &error) {
        EXPECT_EQ(error.status(), status);
        test::expect_one_sentence(error.what());
        EXPECT_NE(std::string(error.what()).find(need.word), std::string::npos) << need.word << " is not in: " << error.what();
        for (const char *word : words)
          EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << word << " is not in: " << error.what();
      }
    }
    options = usual;
  }

  test::TestMesh ball;
  pdesc_options options;
};

TEST_F(Choice, is_the_processor_and_looks_for_no_device) {
  std::atomic<int> looked = 0;
  pdesc_context_options requested;
  pdesc_context_options_init(&requested);
  const auto context = make_context(requested, [&looked](const char *, void *found) {
    ++looked;
    return found;
  });
  EXPECT_EQ(context->backend, PDESC_BACKEND_CPU);
  const auto mesh = mesh_on(context), by_name = mesh_on(open(PDESC_BACKEND_CPU));
  const Field field = compute_on(*mesh);
  EXPECT_EQ(looked, 0);
  EXPECT_EQ(field.report.backend, PDESC_BACKEND_CPU);
  EXPECT_EQ(field.warnings, "");
  test::expect_same_bits(field.values[0], compute_on(*by_name).values[0]);
}

TEST_F(Choice, is_the_software_device_for_what_texture_space_alone_has_with_a_note) {
  if (!has_software()) GTEST_SKIP() << "no software rasterizer";
  const auto context = open(PDESC_BACKEND_AUTO), software = open(PDESC_BACKEND_SOFTWARE);
  const auto mesh = mesh_on(context), by_name = mesh_on(software);
  const pdesc_options usual = options;
  for (const Need &need : needs) {
    options = usual;
    EXPECT_EQ(backend_for(*context, options), PDESC_BACKEND_CPU);
    need.ask(options);
    EXPECT_EQ(backend_for(*context, options), PDESC_BACKEND_SOFTWARE) << need.word;
    const Field field = compute_on(*mesh), expected = compute_on(*by_name);
    EXPECT_EQ(field.report.backend, PDESC_BACKEND_SOFTWARE) << need.word;
    test::expect_same_bits(field.values[0], expected.values[0]);
    EXPECT_EQ(field.device, software->device.load());
    const std::string note = field.warnings.substr(0, field.warnings.find('\n'));
    EXPECT_NE(note.find(need.word), std::string::npos) << note;
    test::expect_one_sentence(note);
    EXPECT_EQ(expected.warnings.find("Only texture space"), std::string::npos) << "who chose it knows";
    EXPECT_EQ(read_buffer(*mesh, "chart").values, read_buffer(*by_name, "chart").values);
  }
  options = usual;
  EXPECT_EQ(compute_on(*mesh).report.backend, PDESC_BACKEND_CPU) << "a mesh may go on elsewhere";
  EXPECT_THROW(read_buffer(*mesh, "chart"), Error);
  EXPECT_EQ(context->backend, PDESC_BACKEND_CPU);
}

TEST_F(Choice, follows_surface_maps_on_the_processor) {
  const auto context = open(PDESC_BACKEND_AUTO, false);
  const auto mesh = mesh_on(context), by_name = mesh_on(open(PDESC_BACKEND_CPU));
  const float height = 0.5f;
  for (Mesh *each : {mesh.get(), by_name.get()}) set_displacement(each->maps, each->triangles, &height, 1, 1, 0.0, 0.1);
  const std::vector<float> before = compute_on(*mesh_on(context)).values[0];
  const Field field = compute_on(*mesh);
  EXPECT_EQ(field.report.backend, PDESC_BACKEND_CPU);
  EXPECT_EQ(field.warnings, "") << "nothing is missing";
  EXPECT_NE(field.values[0], before);
  test::expect_same_bits(field.values[0], compute_on(*by_name).values[0]);
}

TEST_F(Choice, refuses_what_takes_opengl_where_there_is_none_in_one_sentence) {
  const auto mesh = mesh_on(open(PDESC_BACKEND_AUTO, false));
  expect_all_refused(*mesh, PDESC_ERROR_UNSUPPORTED, {"OpenGL", test::driver_library, "backend gpu"});
  EXPECT_EQ(compute_on(*mesh).report.backend, PDESC_BACKEND_CPU);
}

TEST_F(Choice, refuses_by_the_name_cpu_what_it_does_without_and_names_who_has_it) {
  const auto mesh = mesh_on(open(PDESC_BACKEND_CPU));
  expect_all_refused(*mesh, PDESC_ERROR_INVALID_OPERATION, {"cpu", "software"});
}

TEST_F(Choice, of_the_processor_makes_buffers_and_seed_without_effect) {
  const auto mesh = mesh_on(open(PDESC_BACKEND_AUTO, false));
  const std::vector<float> usual = compute_on(*mesh).values[0];
  options.buffer_size = 512;
  options.seed = 3;
  const Field field = compute_on(*mesh);
  test::expect_same_bits(field.values[0], usual);
  EXPECT_EQ(field.warnings, "") << "nothing is wrong with the values";
}

TEST_F(Choice, needs_no_uv_map_where_texture_space_is_not_asked_for) {
  ball.corner_uvs.clear();
  const auto mesh = mesh_on(open(PDESC_BACKEND_AUTO));
  EXPECT_EQ(compute_on(*mesh).report.backend, PDESC_BACKEND_CPU);
}

TEST_F(Choice, foresees_the_memory_of_what_will_compute) {
  const auto context = open(PDESC_BACKEND_AUTO, false);
  const auto mesh = mesh_on(context);
  const std::vector<int> rows = {find_descriptor("mean_curvature")};
  options.adaptive = 0.05;
  EXPECT_GT(forecast_memory_of(*mesh, backend_for(*context, options), options, rows).device, 0);
  options.adaptive = 0.0;
  EXPECT_EQ(forecast_memory_of(*mesh, backend_for(*context, options), options, rows).device, 0);
}

} // namespace
} // namespace paradesc
