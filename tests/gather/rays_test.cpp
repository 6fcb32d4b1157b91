// Rays and values at what they meet, through the C interface.
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/api_fixture.h"

namespace paradesc::test {
namespace {

constexpr float none = std::numeric_limits<float>::quiet_NaN();

// A square at height 1 that faces up, of two triangles, and rays from below.
struct Scene {
  std::vector<float> positions{0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1};
  std::vector<int32_t> vertices{0, 1, 2, 0, 2, 3};
  std::vector<float> rays{};
  double reach = 2;
  int32_t threads = 1;

  void add(float x, float y) {
    for (const float number : {x, y, 0.0f, 0.0f, 0.0f, 3.0f}) rays.push_back(number);
  }
  int32_t count() const { return static_cast<int32_t>(rays.size() / 6); }

  pdesc_rays_input input() const {
    pdesc_rays_input arguments;
    pdesc_rays_input_init(&arguments);
    arguments.vertex_count = static_cast<int32_t>(positions.size() / 3);
    arguments.triangle_count = static_cast<int32_t>(vertices.size() / 3);
    arguments.ray_count = count();
    arguments.threads = threads;
    arguments.positions = positions.data();
    arguments.triangle_vertices = vertices.data();
    arguments.rays = rays.data();
    arguments.reach = reach;
    return arguments;
  }
};

struct Met {
  std::vector<int32_t> triangles;
  std::vector<float> weights;
};

Met cast(const Scene &scene) {
  const auto count = static_cast<size_t>(scene.count());
  Met met{std::vector<int32_t>(count, -7), std::vector<float>(3 * count, -7)};
  const pdesc_rays_input input = scene.input();
  EXPECT_EQ(pdesc_rays_cast(&input, met.triangles.data(), met.weights.data(), scene.count()), PDESC_OK) << pdesc_last_error();
  return met;
}

std::vector<float> values(const Scene &scene, const Met &met, const std::vector<float> &at_vertices, int32_t components) {
  std::vector<float> found(met.triangles.size() * static_cast<size_t>(components), -7);
  const pdesc_rays_input input = scene.input();
  EXPECT_EQ(pdesc_rays_values(&input, met.triangles.data(), met.weights.data(), at_vertices.data(), components, found.data(),
                              static_cast<int64_t>(found.size())),
            PDESC_OK)
      << pdesc_last_error();
  return found;
}

} // namespace

TEST(Rays, values_are_linear_on_what_is_met) {
  Scene scene;
  scene.add(0.75f, 0.25f);
  scene.add(0.25f, 0.5f);
  scene.add(1.25f, 0.5f); // past the square
  const Met met = cast(scene);
  EXPECT_EQ(met.triangles, (std::vector<int32_t>{0, 1, -1}));
  const std::vector<float> found = values(scene, met, {0, 1, 3, 2}, 1); // x + 2y
  EXPECT_FLOAT_EQ(found[0], 1.25f);
  EXPECT_FLOAT_EQ(found[1], 1.25f);
  EXPECT_TRUE(std::isnan(found[2]));
}

TEST(Rays, a_corner_without_a_value_leaves_the_triangle_to_the_others) {
  Scene scene;
  scene.add(0.75f, 0.25f);
  const Met met = cast(scene);
  EXPECT_FLOAT_EQ(values(scene, met, {5, none, 5, 9}, 1)[0], 5.0f);
  EXPECT_TRUE(std::isnan(values(scene, met, {none, none, none, 9}, 1)[0]));
}

TEST(Rays, directions_have_no_sign_and_the_length_one) {
  Scene scene;
  scene.add(0.75f, 0.25f);
  const std::vector<float> found = values(scene, cast(scene), {1, 0, 0, -1, 0, 0, 1, 0, 0, 0, 1, 0}, 3);
  EXPECT_NEAR(std::abs(found[0]), 1.0f, 1e-6f);
  EXPECT_NEAR(found[1], 0.0f, 1e-6f);
}

TEST(Rays, those_without_direction_or_number_meet_nothing) {
  Scene scene;
  scene.rays = {0.5f, 0.25f, 0, 0, 0, 0, none, 0.25f, 0, 0, 0, 1, 0.5f, 0.25f, 0, 0, 0, std::numeric_limits<float>::infinity()};
  EXPECT_EQ(cast(scene).triangles, (std::vector<int32_t>{-1, -1, -1}));
}

TEST(Rays, what_cannot_be_used_is_refused_in_one_sentence_and_outputs_are_untouched) {
  Scene good;
  good.add(0.75f, 0.25f);
  std::vector<int32_t> triangles(1, -7);
  std::vector<float> weights(3, -7);
  const auto refused = [&](const Scene &scene, int32_t count, const std::string &said) {
    const pdesc_rays_input input = scene.input();
    EXPECT_EQ(pdesc_rays_cast(&input, triangles.data(), weights.data(), count), PDESC_ERROR_INVALID_ARGUMENT);
    EXPECT_NE(std::string(pdesc_last_error()).find(said), std::string::npos) << pdesc_last_error();
    EXPECT_EQ(triangles[0], -7);
  };
  Scene wrong_corner(good);
  wrong_corner.vertices[4] = 4;
  refused(wrong_corner, 1, "Corner 1 of triangle 1 refers to 4, but there are 4.");
  for (const double reach : {0.0, -1.0, static_cast<double>(none), std::numeric_limits<double>::infinity()}) {
    Scene scene(good);
    scene.reach = reach;
    refused(scene, 1, "The reach is");
  }
  refused(good, 2, "room for 2");
  const pdesc_rays_input input = good.input();
  const int32_t wrong = 2;
  float value = -7;
  const std::vector<float> at_vertices(4, 1.0f);
  EXPECT_EQ(pdesc_rays_values(&input, &wrong, weights.data(), at_vertices.data(), 1, &value, 1), PDESC_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(std::string(pdesc_last_error()), "Ray 0 refers to 2, but there are 2.");
  EXPECT_EQ(value, -7);
  EXPECT_EQ(pdesc_rays_values(&input, triangles.data(), weights.data(), at_vertices.data(), 2, &value, 2),
            PDESC_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(pdesc_rays_cast(nullptr, triangles.data(), weights.data(), 1), PDESC_ERROR_INVALID_ARGUMENT);
}

TEST(Rays, they_are_cancelled_from_progress_and_outputs_are_untouched) {
  Scene scene;
  for (int i = 0; i < 5000; ++i) scene.add(0.5f, 0.25f);
  pdesc_rays_input input = scene.input();
  input.progress = [](void *, const char *stage, double) -> int32_t {
    EXPECT_STREQ(stage, "rays");
    return 0;
  };
  std::vector<int32_t> triangles(5000, -7);
  std::vector<float> weights(15000, -7);
  EXPECT_EQ(pdesc_rays_cast(&input, triangles.data(), weights.data(), 5000), PDESC_ERROR_CANCELLED);
  EXPECT_EQ(triangles, std::vector<int32_t>(5000, -7));
}

TEST(Rays, threads_change_nothing) {
  Scene scene;
  for (int i = 0; i < 9000; ++i) scene.add(static_cast<float>(i) / 8000, static_cast<float>(i % 97) / 96);
  const Met one = cast(scene);
  scene.threads = 3;
  const Met three = cast(scene);
  EXPECT_EQ(one.triangles, three.triangles);
  EXPECT_EQ(one.weights, three.weights);
}

} // namespace paradesc::test
