// Images through the C interface: counts may be fewer than the arrays have room for, and nonsense, but never more.
#include "images.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "claims.h"
#include "paradesc/paradesc.h"
#include "passed.h"

namespace paradesc::fuzz {
namespace {

void fill(Bytes &bytes, std::vector<float> &image, int32_t width, int32_t height, int32_t components) {
  const auto count = static_cast<int64_t>(image.size());
  const int32_t steps = bytes.one_in(16) ? bytes.whole() : bytes.below(10);
  if (bytes.one_in(32)) width = bytes.whole();
  if (bytes.one_in(32)) components = bytes.whole();
  const std::vector<float> before = image;
  if (done(pdesc_uv_image_fill_gutter(image.data(), count, width, height, components, steps, 1))) {
    for (const float x : image) claim(std::isfinite(x), "a texel was left undefined");
  } else {
    claim(std::memcmp(image.data(), before.data(), sizeof(float) * image.size()) == 0, "an image was touched on failure");
  }
}

} // namespace

void draw_image(Bytes &bytes) {
  const int32_t triangles = bytes.below(6), values = 1 + bytes.below(6), components = bytes.one_in(3) ? 3 : 1;
  const int32_t size = 1 + bytes.below(40), map_size = bytes.below(4);
  std::vector<float> uvs(6 * triangles), layout(6 * triangles), of_corners(values * components),
      map(map_size * map_size * components), image(size * size * components, sentinel);
  std::vector<int32_t> corners(3 * triangles);
  for (std::vector<float> *numbers : {&uvs, &layout, &of_corners, &map})
    for (float &x : *numbers) x = bytes.number();
  for (int32_t &corner : corners) corner = bytes.one_in(64) ? bytes.whole() : bytes.below(values);
  pdesc_uv_image_input ours;
  pdesc_uv_image_input_init(&ours);
  ours.size = bytes.one_in(32) ? bytes.whole() : size;
  ours.triangle_count = bytes.one_in(32) ? std::min(triangles, bytes.whole()) : triangles;
  ours.value_count = bytes.one_in(32) ? std::min(values, bytes.whole()) : values;
  ours.components = bytes.one_in(32) ? std::min(components, bytes.whole()) : components;
  ours.threads = bytes.one_in(32) ? std::min(3, bytes.whole()) : 1;
  ours.uvs = bytes.one_in(32) ? nullptr : uvs.data();
  ours.triangle_values = bytes.one_in(32) ? nullptr : corners.data();
  ours.values = bytes.one_in(32) ? nullptr : of_corners.data();
  ours.map = bytes.one_in(2) ? nullptr : map.data();
  ours.map_size = bytes.one_in(32) ? std::min(map_size, bytes.whole()) : map_size;
  ours.map_uvs = bytes.one_in(32) ? nullptr : layout.data();
  int calls_left = bytes.one_in(8) ? bytes.below(4) : -1;
  if (bytes.one_in(4)) {
    ours.progress = [](void *user, const char *stage, double fraction) -> int32_t {
      claim(stage && *stage && fraction >= 0.0 && fraction <= 1.0, "the progress of an image is none");
      return !user || (*static_cast<int *>(user))-- != 0; // a struct that is passed in part may end before it
    };
    ours.user = &calls_left;
  }
  Passed<pdesc_uv_image_input> passed(bytes, ours);
  const int64_t count = bytes.one_in(32) ? bytes.whole() : static_cast<int64_t>(image.size());
  const bool drawn = done(pdesc_uv_image_draw(bytes.one_in(64) ? nullptr : passed.get(), image.data(),
                                              std::min(count, static_cast<int64_t>(image.size()))));
  for (const float x : image) claim((x == sentinel) == !drawn, "an image was touched on failure, or left");
  if (drawn) fill(bytes, image, size, size, components);
}

void fill_gutter(Bytes &bytes) {
  const int32_t width = 1 + bytes.below(12), height = 1 + bytes.below(12), components = 1 + bytes.below(4);
  std::vector<float> image(width * height * components, std::numeric_limits<float>::quiet_NaN());
  for (int defined = bytes.below(20); defined > 0; --defined) image[bytes.byte() % image.size()] = bytes.number();
  fill(bytes, image, width, height, components);
}

} // namespace paradesc::fuzz
