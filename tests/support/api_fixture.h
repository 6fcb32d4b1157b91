// Fixture for the tests of the C interface: a small mesh, and refusals with their sentences.
#pragma once

#include <algorithm>
#include <cctype>
#include <initializer_list>
#include <string>
#include <vector>

#include "paradesc/paradesc.h"
#include "support/layout.h"
#include "support/run.h"
#include "support/sentence.h"
#include "support/surfaces.h"

namespace paradesc::test {

inline std::string lower(std::string text) {
  for (char &c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

// The call failed with the code, and left one sentence that names each offender.
inline void expect_refused(int32_t status, int32_t code, std::initializer_list<const char *> offenders) {
  const std::string sentence = pdesc_last_error();
  EXPECT_EQ(status, code) << sentence;
  expect_one_sentence(sentence);
  for (const char *offender : offenders)
    EXPECT_NE(lower(sentence).find(lower(offender)), std::string::npos) << "no \"" << offender << "\" in: " << sentence;
}

// Values of a map (size * size, components), all of which are set.
inline std::vector<float> map_of(const pdesc_field *field, const char *name, size_t components = 1) {
  const auto size = static_cast<size_t>(pdesc_field_map_size(field));
  std::vector<float> values(size * size * components, sentinel);
  EXPECT_EQ(pdesc_field_map(field, name, values.data(), static_cast<int64_t>(values.size())), PDESC_OK) << pdesc_last_error();
  EXPECT_EQ(std::count(values.begin(), values.end(), sentinel), 0);
  return values;
}

// A small ball on six charts and the reference backend, which every machine has.
class Api : public ::testing::Test {
protected:
  void SetUp() override {
    ball = sphere(1, {.vertices = 400});
    lay_out(ball, {.charts = 6});
    input = input_of(ball);
    std::string why_not;
    context = open_context(PDESC_BACKEND_REFERENCE, why_not);
    ASSERT_TRUE(context) << why_not;
    pdesc_options_init(&options);
    options.radius = 0.1;
  }

  void expect_mesh_refused(std::initializer_list<const char *> offenders) {
    pdesc_mesh *mesh = never_mesh();
    expect_refused(pdesc_mesh_create(context.get(), &input, &mesh), PDESC_ERROR_INVALID_ARGUMENT, offenders);
    EXPECT_EQ(mesh, never_mesh()) << "output was touched on failure";
  }

  void expect_compute_refused(int32_t code, std::initializer_list<const char *> offenders, const char *name = "mean_curvature") {
    const Mesh mesh = make_mesh(context.get(), ball);
    ASSERT_TRUE(mesh);
    pdesc_field *field = never_field();
    expect_refused(pdesc_compute(mesh.get(), &options, &name, 1, nullptr, nullptr, &field), code, offenders);
    EXPECT_EQ(field, never_field()) << "output was touched on failure";
  }

  std::vector<float> mean_curvature(pdesc_mesh *mesh, pdesc_progress progress = nullptr, void *user = nullptr) {
    const char *name = "mean_curvature";
    pdesc_field *field = nullptr;
    EXPECT_EQ(pdesc_compute(mesh, &options, &name, 1, progress, user, &field), PDESC_OK) << pdesc_last_error();
    const Field owner(field);
    std::vector<float> values(static_cast<size_t>(ball.vertex_count), sentinel);
    EXPECT_EQ(pdesc_field_values(field, name, values.data(), ball.vertex_count), PDESC_OK) << pdesc_last_error();
    return values;
  }

  pdesc_mesh *never_mesh() { return reinterpret_cast<pdesc_mesh *>(&sentinel_address); }
  pdesc_field *never_field() { return reinterpret_cast<pdesc_field *>(&sentinel_address); }

  int sentinel_address = 0; // its address is the sentinel of output handles
  TestMesh ball;
  pdesc_mesh_input input;
  pdesc_options options;
  Context context;
};

} // namespace paradesc::test
