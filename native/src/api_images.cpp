// The part of the C edge that draws images over a UV map; it needs no handle.
#include <cstdint>
#include <memory>
#include <string>

#include "api_edge.h"
#include "gather/gutter.h"
#include "gather/uv_image.h"
#include "support/parallel.h"

namespace {

using namespace paradesc::edge;

constexpr int32_t largest_side = 16384;

int64_t floats_of(int32_t width, int32_t height, int32_t components) { return int64_t{width} * height * components; }

void check_count(int64_t room, int64_t needed) {
  if (room != needed)
    refuse("The array has room for " + std::to_string(room) + " floats, but " + std::to_string(needed) + " are needed.");
}

void check_triangle_values(const pdesc_uv_image_input &input) {
  for (int64_t i = 0; i < int64_t{3} * input.triangle_count; ++i)
    if (input.triangle_values[i] < 0 || input.triangle_values[i] >= input.value_count)
      refuse("Corner " + std::to_string(i % 3) + " of triangle " + std::to_string(i / 3) + " refers to value " +
             std::to_string(input.triangle_values[i]) + ", but there are " + std::to_string(input.value_count) + ".");
}

void check_input(const pdesc_uv_image_input &input) {
  check_range("size", input.size, 1, largest_side);
  check_range("triangle_count", input.triangle_count, 0, INT32_MAX);
  check_range("value_count", input.value_count, 0, INT32_MAX);
  check_range("threads", input.threads, 0, 4096);
  if (input.numbers)
    check_range("components", input.components, 1, paradesc::most_components);
  else if (input.components != 1 && input.components != 3)
    refuse("The option components is " + std::to_string(input.components) + "; it must be 1, or 3 for directions.");
  if (input.map) {
    check_range("map_size", input.map_size, 1, largest_side);
    need(input.map_uvs, "map_uvs");
  }
  if (input.triangle_count == 0) return;
  need(input.uvs, "uvs");
  need(input.triangle_values, "triangle_values");
  need(input.values, "values");
  check_triangle_values(input);
}

} // namespace

void pdesc_uv_image_input_init(pdesc_uv_image_input *input) { zero_init(input); }

int32_t pdesc_uv_image_draw(const pdesc_uv_image_input *input, float *image, int64_t count) {
  return guarded([&] {
    need(input, "input");
    need(image, "image");
    const auto ours = read_struct(input, pdesc_uv_image_input_init, "pdesc_uv_image_input");
    check_input(ours);
    check_count(count, floats_of(ours.size, ours.size, ours.components));
    const auto drawn = std::make_unique_for_overwrite<float[]>(static_cast<size_t>(count)); // keeps image untouched on failure
    paradesc::draw_uv_image(ours, {drawn.get(), static_cast<size_t>(count)});
    std::copy_n(drawn.get(), count, image);
  });
}

int32_t pdesc_uv_image_fill_gutter(float *image, int64_t count, int32_t width, int32_t height, int32_t components, int32_t steps,
                                   int32_t threads) {
  return guarded([&] {
    need(image, "image");
    check_range("width", width, 1, largest_side);
    check_range("height", height, 1, largest_side);
    check_range("components", components, 1, 4);
    check_range("steps", steps, 0, 64);
    check_range("threads", threads, 0, 4096);
    check_count(count, floats_of(width, height, components));
    paradesc::fill_gutter({image, static_cast<size_t>(count)}, {width, height, components}, steps, threads);
  });
}
