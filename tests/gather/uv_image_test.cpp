// Images over a UV map through the C interface: what each texel shows, known in closed form.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "support/api_fixture.h"
#include "support/cancel.h"

namespace paradesc::test {
namespace {

constexpr float none = std::numeric_limits<float>::quiet_NaN();
constexpr float sentinel = -12345.678f;

// Triangles whose corners have values of their own, unless said otherwise.
struct Drawing {
  int32_t size = 8, components = 1, threads = 1;
  std::vector<float> uvs{}, values{};
  std::vector<int32_t> corners{};
  std::vector<float> map{}, map_uvs{};
  int32_t map_size = 0;
  int32_t numbers = 0;
  pdesc_progress progress = nullptr;
  void *user = nullptr;

  void add(std::vector<float> uv, std::vector<float> of_corners) {
    uvs.insert(uvs.end(), uv.begin(), uv.end());
    values.insert(values.end(), of_corners.begin(), of_corners.end());
    for (int i = 0; i < 3; ++i) corners.push_back(static_cast<int32_t>(corners.size()));
  }

  pdesc_uv_image_input input() const {
    pdesc_uv_image_input arguments;
    pdesc_uv_image_input_init(&arguments);
    arguments.size = size;
    arguments.triangle_count = static_cast<int32_t>(uvs.size() / 6);
    arguments.value_count = static_cast<int32_t>(values.size()) / components;
    arguments.components = components;
    arguments.threads = threads;
    arguments.uvs = uvs.data();
    arguments.triangle_values = corners.data();
    arguments.values = values.data();
    arguments.map = map_size ? map.data() : nullptr;
    arguments.map_size = map_size;
    arguments.numbers = numbers;
    arguments.map_uvs = map_uvs.data();
    arguments.progress = progress;
    arguments.user = user;
    return arguments;
  }

  int64_t floats() const { return int64_t{size} * size * components; }

  std::vector<float> draw() const {
    std::vector<float> image(static_cast<size_t>(floats()), sentinel);
    const pdesc_uv_image_input arguments = input();
    EXPECT_EQ(pdesc_uv_image_draw(&arguments, image.data(), floats()), PDESC_OK) << pdesc_last_error();
    return image;
  }
};

void add_square(Drawing &drawing, float value) {
  drawing.add({0, 0, 1, 0, 0, 1}, {value, value, value});
  drawing.add({1, 1, 0, 1, 1, 0}, {value, value, value});
}

float at(const std::vector<float> &image, int size, int column, int row) {
  return image[static_cast<size_t>(row) * static_cast<size_t>(size) + static_cast<size_t>(column)];
}

// NaN equals NaN.
void expect_same_bits(const std::vector<float> &image, const std::vector<float> &expected) {
  ASSERT_EQ(image.size(), expected.size());
  for (size_t i = 0; i < image.size(); ++i) {
    if (std::isnan(expected[i])) {
      EXPECT_TRUE(std::isnan(image[i])) << "texel " << i << " is " << image[i];
    } else {
      EXPECT_EQ(image[i], expected[i]) << "texel " << i;
    }
  }
}

// Triangles on several tiles that overlap one another and leave a quarter bare; a few of their values are none.
Drawing crowd(int32_t size) {
  Drawing drawing{.size = size};
  for (int i = 0; i < 40; ++i) {
    const auto t = static_cast<float>(i);
    const float last = i % 5 ? std::fmod(0.83f * t, 1.0f) : 0.5f;
    drawing.add({std::fmod(0.37f * t, 1.7f) - 0.3f, 0.75f * std::fmod(0.11f * t, 1.0f), std::fmod(0.53f * t, 1.0f),
                 0.75f * std::fmod(0.71f * t, 1.0f), std::fmod(0.29f * t, 2.3f) - 0.9f, 0.75f * last},
                {std::sin(t), i % 7 ? std::cos(t) : none, t});
  }
  return drawing;
}

TEST(UvImage, of_a_linear_function_is_that_function_at_the_centers_of_texels) {
  Drawing drawing{.size = 64};
  const auto f = [](double u, double v) { return 3.0 * u - 2.0 * v + 0.25; };
  const auto corner = [&](double u, double v) { return static_cast<float>(f(u, v)); };
  drawing.add({0, 0, 1, 0, 0, 1}, {corner(0, 0), corner(1, 0), corner(0, 1)});
  drawing.add({1, 1, 1, 0, 0, 1}, {corner(1, 1), corner(1, 0), corner(0, 1)}); // wound the other way
  const auto image = drawing.draw();
  for (int row = 0; row < 64; ++row)
    for (int column = 0; column < 64; ++column)
      EXPECT_NEAR(at(image, 64, column, row), f((column + 0.5) / 64, (row + 0.5) / 64), 4e-7); // rounded to a float below 4
}

TEST(UvImage, shows_a_triangle_at_the_centers_within_it_and_on_its_border_and_nowhere_else) {
  Drawing drawing;
  drawing.add({1.5f / 8, 1.5f / 8, 5.5f / 8, 1.5f / 8, 1.5f / 8, 5.5f / 8}, {7, 7, 7}); // its corners are centers
  const auto image = drawing.draw();
  for (int row = 0; row < 8; ++row)
    for (int column = 0; column < 8; ++column) {
      const bool inside = column >= 1 && row >= 1 && column + row <= 6;
      EXPECT_EQ(!std::isnan(at(image, 8, column, row)), inside) << column << ", " << row;
    }
}

TEST(UvImage, shows_the_last_of_triangles_that_overlap) {
  for (const bool turned : {false, true}) {
    Drawing drawing{.size = 4};
    if (turned) drawing.add({1, 0, 1, 1, 0, 0}, {2, 2, 2});
    drawing.add({0, 0, 1, 0, 0, 1}, {1, 1, 1});
    if (!turned) drawing.add({1, 0, 1, 1, 0, 0}, {2, 2, 2});
    const auto image = drawing.draw();
    EXPECT_EQ(at(image, 4, 2, 0), turned ? 1.0f : 2.0f); // in both
    EXPECT_EQ(at(image, 4, 0, 0), turned ? 1.0f : 2.0f); // in the first and on the border of the other
    EXPECT_EQ(at(image, 4, 0, 2), 1.0f);
    EXPECT_EQ(at(image, 4, 3, 2), 2.0f);
    EXPECT_TRUE(std::isnan(at(image, 4, 2, 3)));
  }
}

TEST(UvImage, shows_no_triangle_without_area_nor_one_of_coordinates_that_are_none) {
  Drawing drawing;
  const float huge = std::numeric_limits<float>::infinity();
  drawing.add({0.1f, 0.1f, 0.9f, 0.9f, 0.5f, 0.5f}, {1, 1, 1});
  drawing.add({0.3f, 0.3f, 0.3f, 0.3f, 0.3f, 0.3f}, {1, 1, 1});
  drawing.add({huge, 0.1f, 0.9f, -huge, 0.1f, 0.9f}, {1, 1, 1});
  for (const float x : drawing.draw()) EXPECT_TRUE(std::isnan(x));
}

TEST(UvImage, takes_a_coordinate_that_is_nan_for_0) {
  Drawing drawing, expected;
  drawing.add({none, 0, 1, none, 0, 1}, {1, 2, 3});
  expected.add({0, 0, 1, 0, 0, 1}, {1, 2, 3});
  expect_same_bits(drawing.draw(), expected.draw());
}

TEST(UvImage, repeats_like_a_texture) {
  for (const auto &[u, v] : {std::pair{3.0f, 0.0f}, {-2.0f, 5.0f}, {0.75f, 0.0f}, {0.0f, -0.5f}}) {
    Drawing drawing{.size = 16}, around{.size = 16};
    drawing.add({u, v, u + 0.5f, v, u, v + 0.5f}, {1, 2, 3});
    const auto image = drawing.draw();
    around.add({0, 0, 0.5f, 0, 0, 0.5f}, {1, 2, 3});
    const auto home = around.draw();
    for (int row = 0; row < 16; ++row)
      for (int column = 0; column < 16; ++column) {
        const int to_column = (column + static_cast<int>(16 * u) + 64) % 16, to_row = (row + static_cast<int>(16 * v) + 160) % 16;
        const float here = at(home, 16, column, row), there = at(image, 16, to_column, to_row);
        EXPECT_TRUE(here == there || (std::isnan(here) && std::isnan(there))) << here << ", " << there;
      }
  }
}

TEST(UvImage, of_a_triangle_larger_than_a_tile_shows_its_upper_right_tile) {
  Drawing drawing{.size = 4};
  drawing.add({0, 0, 4, 0, 0, 4}, {0, 4, 0}); // the value is u
  const auto image = drawing.draw();
  // At (0.375, 0.375): the tiles (0, 0) to (3, 3) of which u + v <= 4 meet it; rows of tiles come one after another.
  EXPECT_EQ(at(image, 4, 1, 1), 0.375f); // of the tile (0, 3)
  EXPECT_EQ(at(image, 4, 0, 0), 0.125f);
  EXPECT_EQ(at(image, 4, 3, 3), 0.875f); // of the tile (0, 2): at (0, 3), u + v is 4.75
}

// The same by drawing each tile of each triangle in turn, later ones over earlier ones: texels show a triangle's number.
std::vector<float> drawn_one_by_one(const Drawing &drawing) {
  std::vector<float> image(static_cast<size_t>(drawing.floats()), none);
  for (size_t triangle = 0; triangle < drawing.uvs.size() / 6; ++triangle) {
    const float *uv = drawing.uvs.data() + 6 * triangle;
    const double left = std::floor(std::min({uv[0], uv[2], uv[4]})), right = std::ceil(std::max({uv[0], uv[2], uv[4]}));
    const double bottom = std::floor(std::min({uv[1], uv[3], uv[5]})), top = std::ceil(std::max({uv[1], uv[3], uv[5]}));
    for (double v = bottom; v < std::clamp(top, bottom + 1, bottom + 16); ++v)
      for (double u = left; u < std::clamp(right, left + 1, left + 16); ++u)
        for (int texel = 0; texel < drawing.size * drawing.size; ++texel) {
          double from[3][2];
          for (int i = 0; i < 3; ++i) {
            from[i][0] = (uv[2 * i] - u) * drawing.size - (texel % drawing.size + 0.5);
            from[i][1] = (uv[2 * i + 1] - v) * drawing.size - (texel / drawing.size + 0.5);
          }
          int left_of = 0, right_of = 0;
          for (int i = 0; i < 3; ++i) {
            const auto &a = from[i], &b = from[(i + 1) % 3];
            const double turn = a[0] * b[1] - a[1] * b[0];
            left_of += turn >= 0.0;
            right_of += turn <= 0.0;
          }
          if (left_of != right_of && (left_of == 3 || right_of == 3))
            image[static_cast<size_t>(texel)] = drawing.values[3 * triangle];
        }
  }
  return image;
}

TEST(UvImage, over_many_unit_squares_shows_what_drawing_them_one_by_one_shows) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> place(-3.0f, 3.0f), reach(0.001f, 1.0f);
  for (const float wide : {0.2f, 1.0f, 4.0f, 30.0f})
    for (const float tall : {0.0001f, 0.3f, 5.0f}) { // needles, too
      Drawing drawing{.size = 24};
      for (int i = 0; i < 40; ++i) {
        const float x = place(random), y = place(random), value = static_cast<float>(i);
        const auto u = [&] { return x + wide * reach(random); };
        const auto v = [&] { return y + tall * reach(random); };
        drawing.add({x, y, u(), v(), u(), v()}, {value, value, value});
      }
      SCOPED_TRACE(std::to_string(wide) + " x " + std::to_string(tall));
      expect_same_bits(drawing.draw(), drawn_one_by_one(drawing));
    }
}

int32_t count(void *user, const char *, double) {
  ++*static_cast<int *>(user);
  return 1;
}

// A terrain whose UVs are meters: each square is two triangles over 3 x 3 unit squares. It asks whether to go on between rows of
// unit squares, which tells how many it drew.
TEST(UvImage, draws_no_unit_square_that_others_hide) {
  const auto patience = cancel_patience;
  cancel_patience = std::chrono::milliseconds(0);
  Drawing drawing{.size = 128};
  for (int i = 0; i < 60; ++i)
    for (int j = 0; j < 60; ++j) {
      const auto u = 3.0f * static_cast<float>(i), v = 3.0f * static_cast<float>(j);
      drawing.add({u, v, u + 3, v, u, v + 3}, {1, 2, 3});
      drawing.add({u + 3, v + 3, u, v + 3, u + 3, v}, {1, 2, 3});
    }
  int asked = 0;
  drawing.progress = count;
  drawing.user = &asked;
  for (const float x : drawing.draw()) EXPECT_FALSE(std::isnan(x));
  EXPECT_LT(asked, 100);
  cancel_patience = patience;
}

TEST(UvImage, leaves_out_corners_without_a_value) {
  Drawing drawing;
  drawing.add({0, 0, 2, 0, 0, 2}, {none, 6, 6});
  for (const float x : drawing.draw()) EXPECT_EQ(x, 6.0f);
  drawing.values = {none, none, std::numeric_limits<float>::infinity()};
  for (const float x : drawing.draw()) EXPECT_TRUE(std::isnan(x));
}

TEST(UvImage, gives_directions_no_sign_and_length_1) {
  Drawing drawing{.size = 16, .components = 3};
  drawing.add({0, 0, 2, 0, 0, 2}, {1, 0, 0, -1, 0, 0, 1, 0, 0});
  const auto image = drawing.draw();
  for (size_t i = 0; i < image.size(); i += 3) {
    EXPECT_EQ(std::abs(image[i]), 1.0f);
    EXPECT_EQ(image[i + 1], 0.0f);
    EXPECT_EQ(image[i + 2], 0.0f);
  }
}

TEST(UvImage, draws_up_to_six_numbers_as_each_by_itself) {
  std::vector<float> together;
  std::vector<std::vector<float>> alone(6);
  Drawing six{.components = 6};
  six.numbers = 1;
  for (int corner = 0; corner < 3; ++corner)
    for (size_t number = 0; number < 6; ++number) {
      const float value = static_cast<float>(number) - 3.5f * static_cast<float>(corner) * static_cast<float>(number % 4);
      together.push_back(value);
      alone[number].push_back(value);
    }
  six.add({0.1f, 0, 1, 0.2f, 0, 0.9f}, together);
  const std::vector<float> image = six.draw();
  for (size_t number = 0; number < 6; ++number) {
    Drawing one;
    one.add({0.1f, 0, 1, 0.2f, 0, 0.9f}, alone[number]);
    const std::vector<float> expected = one.draw();
    std::vector<float> found;
    for (size_t texel = 0; texel < expected.size(); ++texel) found.push_back(image[6 * texel + number]);
    expect_same_bits(found, expected);
  }
  six.components = 7;
  const pdesc_uv_image_input input = six.input();
  std::vector<float> untouched(static_cast<size_t>(six.floats()), sentinel);
  expect_refused(pdesc_uv_image_draw(&input, untouched.data(), six.floats()), PDESC_ERROR_INVALID_ARGUMENT, {"components", "7"});
}

TEST(UvImage, lets_corners_share_values) {
  Drawing drawing, apart;
  drawing.add({0, 0, 1, 0, 0, 1}, {1, 2, 3});
  drawing.uvs.insert(drawing.uvs.end(), {1, 1, 1, 0, 0, 1});
  drawing.corners.insert(drawing.corners.end(), {0, 1, 2});
  apart.add({0, 0, 1, 0, 0, 1}, {1, 2, 3});
  apart.add({1, 1, 1, 0, 0, 1}, {1, 2, 3});
  expect_same_bits(drawing.draw(), apart.draw());
}

TEST(UvImage, takes_values_from_a_map_of_its_own_size_texel_for_texel) {
  Drawing drawing{.size = 4};
  add_square(drawing, -1);
  drawing.map_uvs = drawing.uvs;
  drawing.map_size = 4;
  for (int i = 0; i < 16; ++i) drawing.map.push_back(static_cast<float>(i * i));
  expect_same_bits(drawing.draw(), drawing.map);
}

TEST(UvImage, looks_a_map_up_bilinearly_and_takes_the_corners_where_it_has_nothing) {
  Drawing drawing{.size = 8};
  add_square(drawing, -1);
  drawing.map_uvs = drawing.uvs;
  drawing.map_size = 4;
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) drawing.map.push_back(column < 2 ? static_cast<float>(column + 10 * row) : none);
  const auto image = drawing.draw();
  EXPECT_FLOAT_EQ(at(image, 8, 1, 3), 0.25f + 12.5f); // between four texels
  EXPECT_FLOAT_EQ(at(image, 8, 4, 3), 1.0f + 12.5f);  // a quarter of the way beyond the last column, of that column alone
  EXPECT_EQ(at(image, 8, 5, 3), -1.0f);
  EXPECT_EQ(at(image, 8, 7, 7), -1.0f);
}

TEST(UvImage, does_not_depend_on_the_number_of_threads) {
  Drawing drawing = crowd(300);
  const auto expected = drawing.draw();
  size_t covered = 0;
  for (const float x : expected) covered += !std::isnan(x);
  EXPECT_GT(covered, expected.size() / 4);
  EXPECT_LT(covered, expected.size());
  for (const int32_t threads : {2, 5, 0}) {
    drawing.threads = threads;
    expect_same_bits(drawing.draw(), expected);
  }
}

TEST(UvImage, of_no_triangles_is_empty) {
  for (const float x : Drawing{.size = 3}.draw()) EXPECT_TRUE(std::isnan(x));
}

int32_t stop(void *user, const char *stage, double fraction) {
  EXPECT_STREQ(stage, "image");
  EXPECT_TRUE(fraction >= 0.0 && fraction <= 1.0);
  return (*static_cast<int *>(user))-- > 0;
}

TEST(UvImage, that_is_cancelled_leaves_the_output_as_it_was) {
  Drawing drawing = crowd(300);
  const auto patience = cancel_patience;
  cancel_patience = std::chrono::milliseconds(0);
  for (const int after : {0, 1, 20}) {
    int left = after;
    drawing.progress = stop;
    drawing.user = &left;
    std::vector<float> image(static_cast<size_t>(drawing.floats()), sentinel);
    const pdesc_uv_image_input arguments = drawing.input();
    expect_refused(pdesc_uv_image_draw(&arguments, image.data(), drawing.floats()), PDESC_ERROR_CANCELLED, {"cancelled"});
    for (const float x : image) ASSERT_EQ(x, sentinel);
  }
  int left = std::numeric_limits<int>::max();
  drawing.user = &left;
  expect_same_bits(drawing.draw(), crowd(300).draw());
  EXPECT_LT(left, std::numeric_limits<int>::max() - 20);
  cancel_patience = patience;
}

// Mistakes of a caller, each in a drawing that is sound otherwise.
TEST(UvImage, refuses_what_it_cannot_draw_in_a_sentence_that_names_it) {
  const auto refused = [](auto &&spoil, std::initializer_list<const char *> offenders) {
    const Drawing drawing = crowd(8);
    pdesc_uv_image_input arguments = drawing.input();
    spoil(arguments);
    std::vector<float> image(64, sentinel);
    expect_refused(pdesc_uv_image_draw(&arguments, image.data(), 64), PDESC_ERROR_INVALID_ARGUMENT, offenders);
    for (const float x : image) EXPECT_EQ(x, sentinel);
  };
  using Input = pdesc_uv_image_input;
  refused([](Input &arguments) { arguments.struct_size = 3; }, {"struct_size", "_init"});
  refused([](Input &arguments) { arguments.size = 0; }, {"size", "0"});
  refused([](Input &arguments) { arguments.size = 16385; }, {"size", "16384"});
  refused([](Input &arguments) { arguments.size = 9; }, {"64", "81"});
  refused([](Input &arguments) { arguments.triangle_count = -1; }, {"triangle_count"});
  refused([](Input &arguments) { arguments.value_count = -1; }, {"value_count"});
  refused([](Input &arguments) { arguments.value_count = 100; }, {"corner 1 of triangle 33", "value 100"});
  refused([](Input &arguments) { arguments.components = 2; }, {"components", "2"});
  refused([](Input &arguments) { arguments.threads = -1; }, {"threads"});
  refused([](Input &arguments) { arguments.uvs = nullptr; }, {"uvs", "NULL"});
  refused([](Input &arguments) { arguments.values = nullptr; }, {"values", "NULL"});
  refused([](Input &arguments) { arguments.triangle_values = nullptr; }, {"triangle_values", "NULL"});
  const float map = 1.0f;
  refused([&](Input &arguments) { arguments.map = &map; }, {"map_size"});
  refused(
      [&](Input &arguments) {
        arguments.map = &map;
        arguments.map_size = 1;
        arguments.map_uvs = nullptr;
      },
      {"map_uvs", "NULL"});
  float texel = sentinel;
  expect_refused(pdesc_uv_image_draw(nullptr, &texel, 1), PDESC_ERROR_INVALID_ARGUMENT, {"input"});
  const pdesc_uv_image_input arguments = crowd(1).input();
  expect_refused(pdesc_uv_image_draw(&arguments, nullptr, 1), PDESC_ERROR_INVALID_ARGUMENT, {"image"});
}

} // namespace
} // namespace paradesc::test
