// Bands of rows, each on its own: first which triangle every texel shows, then its value.
//
// All numbers are doubles, and each sum is taken in the order in which it stands here: the build keeps the compiler from fusing
// products into sums (CMakeLists.txt), so an image has the same bits on every machine.
#include "gather/uv_image.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "gather/blend.h"
#include "support/cancel.h"
#include "support/error.h"
#include "support/parallel.h"

namespace paradesc {
namespace {

constexpr double max_tiles = 16.0; // along either axis of the UV plane, that one triangle is drawn on
constexpr int band_rows = 64;
constexpr int many_columns = 256; // texels of a row that take long enough to ask whether to go on

struct Point {
  double x, y;
};
using Corners = std::array<Point, 3>;
using Weights = std::array<double, 3>;
constexpr size_t few = 3, most = most_components; // components that a value has room for: less is faster

// A triangle in the UV plane, and the whole tiles that it meets.
struct Tiled {
  Corners uvs;
  Point low; // the corner of its first tile
  int columns, rows;
  int count() const { return columns * rows; }
};

double finite(float x) {
  if (std::isnan(x)) return 0.0;
  constexpr double largest = std::numeric_limits<double>::max();
  return std::clamp(static_cast<double>(x), -largest, largest);
}

int tiles_between(double low, double high) { return static_cast<int>(std::clamp(std::ceil(high) - low, 1.0, max_tiles)); }

Tiled tiled(const pdesc_uv_image_input &input, int triangle) {
  const float *uv = input.uvs + size_t{6} * triangle;
  Tiled found{};
  for (size_t i = 0; i < 3; ++i) found.uvs[i] = {finite(uv[2 * i]), finite(uv[2 * i + 1])};
  const auto &[a, b, c] = found.uvs;
  found.low = {std::floor(std::min({a.x, b.x, c.x})), std::floor(std::min({a.y, b.y, c.y}))};
  found.columns = tiles_between(found.low.x, std::max({a.x, b.x, c.x}));
  found.rows = tiles_between(found.low.y, std::max({a.y, b.y, c.y}));
  return found;
}

// The corners in texels of the image, as one of its tiles shows the triangle.
Corners on_tile(const Tiled &triangle, int tile, double size) {
  const double left = tile % triangle.columns + triangle.low.x, bottom = tile / triangle.columns + triangle.low.y;
  Corners corners;
  for (size_t i = 0; i < 3; ++i) corners[i] = {(triangle.uvs[i].x - left) * size, (triangle.uvs[i].y - bottom) * size};
  return corners;
}

// The texels, first to last, whose centers lie between two coordinates; none where last is less.
struct Range {
  int first, last;
};

bool has(Range range, int texel) { return range.first <= texel && texel <= range.last; }

Range centers_between(double low, double high, int size) {
  return {static_cast<int>(std::clamp(std::ceil(low - 0.5), 0.0, static_cast<double>(size))),
          static_cast<int>(std::clamp(std::floor(high - 0.5), -1.0, static_cast<double>(size - 1)))};
}

Range columns_of(const Corners &corners, int size) {
  const auto &[a, b, c] = corners;
  return centers_between(std::min({a.x, b.x, c.x}), std::max({a.x, b.x, c.x}), size);
}

Range rows_of(const Corners &corners, int size) {
  const auto &[a, b, c] = corners;
  return centers_between(std::min({a.y, b.y, c.y}), std::max({a.y, b.y, c.y}), size);
}

double cross(Point a, Point b) { return a.x * b.y - a.y * b.x; }

// Barycentric weights of a texel's center in a triangle of either winding, where it lies in it; its border belongs to it.
std::optional<Weights> weights_at(const Corners &corners, int column, int row) {
  const Point center{column + 0.5, row + 0.5};
  Corners from;
  for (size_t i = 0; i < 3; ++i) from[i] = {corners[i].x - center.x, corners[i].y - center.y};
  const Weights parts{cross(from[1], from[2]), cross(from[2], from[0]), cross(from[0], from[1])};
  const double whole = parts[0] + parts[1] + parts[2];
  const Weights weights{parts[0] / whole, parts[1] / whole, parts[2] / whole};
  const bool inside = weights[0] >= 0.0 && weights[1] >= 0.0 && weights[2] >= 0.0 && std::isfinite(whole);
  return inside ? std::optional(weights) : std::nullopt;
}

bool has_directions(const pdesc_uv_image_input &input) { return input.components == 3 && !input.numbers; }

template <size_t Width> Value<Width> from_corners(const pdesc_uv_image_input &input, int triangle, const Weights &weights) {
  std::array<const float *, 3> values;
  for (size_t i = 0; i < 3; ++i)
    values[i] = input.values + size_t{1} * input.triangle_values[size_t{3} * triangle + i] * input.components;
  return blended<Width>(values, weights, input.components, has_directions(input));
}

// The map's value at the same position of its own layout, bilinear; NaN where the map is undefined around it.
template <size_t Width> Value<Width> from_map(const pdesc_uv_image_input &input, int triangle, const Weights &weights) {
  const float *uv = input.map_uvs + size_t{6} * triangle;
  const double size = input.map_size;
  const double x = (uv[0] * weights[0] + uv[2] * weights[1] + uv[4] * weights[2]) * size - 0.5;
  const double y = (uv[1] * weights[0] + uv[3] * weights[1] + uv[5] * weights[2]) * size - 0.5;
  const bool near = x > -2.0 && y > -2.0 && x < size + 1.0 && y < size + 1.0; // or NaN
  // At a texel's own center, which rounding may miss, only that texel counts.
  const double left = near ? std::floor(x + 1e-4) : -2.0, bottom = near ? std::floor(y + 1e-4) : -2.0;
  const double right_share = std::clamp(x - left, 0.0, 1.0), upper_share = std::clamp(y - bottom, 0.0, 1.0);
  std::array<const float *, 4> values;
  std::array<double, 4> shares{};
  for (int i = 0; i < 4; ++i) {
    const int column = static_cast<int>(left) + i % 2, row = static_cast<int>(bottom) + i / 2;
    const bool inside = column >= 0 && row >= 0 && column < input.map_size && row < input.map_size;
    values[i] = input.map + (inside ? (row * input.map_size + column) * input.components : 0);
    const double share = std::abs(1 - i % 2 - right_share) * std::abs(1 - i / 2 - upper_share);
    if (inside && share > 1e-3) shares[i] = share;
  }
  return blended<Width>(values, shares, input.components, has_directions(input));
}

// Some rows of the image: which triangle each of their texels shows, and the values there.
class Band {
public:
  Band(const pdesc_uv_image_input &input, Range rows)
      : input_(input), rows_(rows), shown_(input.size * (rows.last - rows.first + 1), none) {}

  // Must be called for the last triangle first: the first caller keeps its texels.
  void claim(int triangle) {
    const Tiled uv = tiled(input_, triangle);
    for (int tile = 0; tile < uv.count(); ++tile) {
      checkpoint();
      claim(triangle, on_tile(uv, tile, input_.size));
    }
  }

  // image: the first texel of the first of the rows.
  template <size_t Width> void draw(float *image) {
    int triangle = none;
    Tiled uv{};
    Corners corners{};
    for (int row = rows_.first; row <= rows_.last; ++row) {
      const int32_t *shown = texels(row);
      for (int column = 0; column < input_.size; ++column, image += input_.components) {
        if (shown[column] == none) {
          std::fill_n(image, input_.components, std::numeric_limits<float>::quiet_NaN());
          continue;
        }
        if (shown[column] != triangle) {
          triangle = shown[column];
          uv = tiled(input_, triangle);
          corners = on_tile(uv, 0, input_.size);
        }
        const auto weights = uv.count() == 1 ? weights_at(corners, column, row) : weights_on_last_tile(uv, column, row);
        const Value<Width> value = value_at<Width>(triangle, *weights);
        for (int c = 0; c < input_.components; ++c) image[c] = static_cast<float>(value[c]);
      }
    }
  }

private:
  static constexpr int32_t none = -1;

  int32_t *texels(int row) { return shown_.data() + (row - rows_.first) * input_.size; }

  void claim(int triangle, const Corners &corners) {
    const Range rows = rows_of(corners, input_.size), columns = columns_of(corners, input_.size);
    for (int row = std::max(rows.first, rows_.first); row <= std::min(rows.last, rows_.last); ++row) {
      if (columns.last - columns.first > many_columns) checkpoint();
      int32_t *shown = texels(row);
      for (int column = columns.first; column <= columns.last; ++column)
        if (shown[column] == none && weights_at(corners, column, row)) shown[column] = triangle;
    }
  }

  // A triangle that is larger than the image may lie over a texel on several tiles; the texel is one that it claimed.
  std::optional<Weights> weights_on_last_tile(const Tiled &uv, int column, int row) const {
    std::optional<Weights> weights;
    for (int tile = uv.count() - 1; tile >= 0 && !weights; --tile) {
      const Corners corners = on_tile(uv, tile, input_.size);
      if (has(columns_of(corners, input_.size), column) && has(rows_of(corners, input_.size), row))
        weights = weights_at(corners, column, row);
    }
    return weights;
  }

  template <size_t Width> Value<Width> value_at(int triangle, const Weights &weights) const {
    Value<Width> value = from_corners<Width>(input_, triangle, weights);
    if (!input_.map) return value;
    const Value<Width> looked_up = from_map<Width>(input_, triangle, weights);
    for (int c = 0; c < input_.components; ++c)
      if (std::isfinite(looked_up[c])) value[c] = looked_up[c];
    return value;
  }

  const pdesc_uv_image_input &input_;
  const Range rows_;
  std::vector<int32_t> shown_; // (rows, size)
};

// (triangle_count) the rows that each triangle may show up in.
std::vector<Range> rows_of_triangles(const pdesc_uv_image_input &input) {
  std::vector<Range> rows(input.triangle_count);
  parallel_blocks(input.triangle_count, input.threads, 4096, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const Tiled uv = tiled(input, i);
      rows[i] = uv.count() == 1 ? rows_of(on_tile(uv, 0, input.size), input.size) : Range{0, input.size - 1};
    }
  });
  return rows;
}

void draw_band(const pdesc_uv_image_input &input, const std::vector<Range> &rows, Range of_band, float *image) {
  Band band(input, of_band);
  for (int i = input.triangle_count - 1; i >= 0; --i)
    if (rows[i].first <= of_band.last && rows[i].last >= of_band.first) band.claim(i);
  if (input.components <= static_cast<int>(few))
    band.draw<few>(image);
  else
    band.draw<most>(image);
}

} // namespace

void draw_uv_image(const pdesc_uv_image_input &input, std::span<float> image) {
  std::atomic<int> rows_done{0};
  const auto ask = [&] {
    if (!input.progress(input.user, "image", static_cast<double>(rows_done) / input.size))
      throw Error(PDESC_ERROR_CANCELLED, "Cancelled in stage image.");
  };
  std::optional<CancelScope> scope;
  if (input.progress) {
    ask();
    scope.emplace(ask);
  }
  const std::vector<Range> rows = rows_of_triangles(input);
  parallel_blocks(input.size, input.threads, band_rows, [&](int begin, int end) {
    draw_band(input, rows, {begin, end - 1}, image.data() + begin * input.size * input.components);
    rows_done += end - begin;
  });
}

} // namespace paradesc
