// Draws bands of rows, each on its own: first finds which triangle every texel shows, then its value. Texels that already show
// one are skipped, so the time depends on the visible part of the map, not on how often it repeats.
//
// All numbers are doubles, and sums are taken in the order written here: the build keeps the compiler from fusing products into
// sums (CMakeLists.txt), so an image has the same bits on every machine.
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
#include "support/parallel.h"
#include "support/progress.h"

namespace paradesc {
namespace {

constexpr int max_tiles = 16; // tiles of the UV plane along either axis that one triangle may cover
constexpr int band_rows = 64;
constexpr int many_columns = 256; // texels of a row between two checks for cancelling

struct Point {
  double x, y;
};
using Corners = std::array<Point, 3>;
using Weights = std::array<double, 3>;
constexpr size_t few = 3, most = most_components; // capacities of a value in components: the smaller one is faster

// A triangle in the UV plane, and the whole tiles that it covers.
struct Tiled {
  Corners uvs;
  Point low; // the corner of its first tile
  int columns, rows;
};

double finite(float x) {
  if (std::isnan(x)) return 0.0;
  constexpr double largest = std::numeric_limits<double>::max();
  return std::clamp(static_cast<double>(x), -largest, largest);
}

int tiles_between(double low, double high) { return static_cast<int>(std::clamp(std::ceil(high) - low, 1.0, double{max_tiles})); }

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

// The corners in texels of the image, relative to one of the triangle's tiles.
Corners on_tile(const Tiled &triangle, int tile, double size) {
  const double left = tile % triangle.columns + triangle.low.x, bottom = tile / triangle.columns + triangle.low.y;
  Corners corners;
  for (size_t i = 0; i < 3; ++i) corners[i] = {(triangle.uvs[i].x - left) * size, (triangle.uvs[i].y - bottom) * size};
  return corners;
}

// The texels, first to last, whose centers lie between two coordinates; last < first if there are none.
struct Range {
  int first, last;
};

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

struct Interval {
  double low, high;
};

// A triangle, enlarged by the largest rounding error of weights_at().
class Outline {
public:
  explicit Outline(const Corners &corners) : corners_(corners) {
    double longest = 0.0, shortest = std::numeric_limits<double>::infinity();
    for (size_t i = 0; i < 3; ++i) {
      const Point from = corners[i], to = corners[(i + 1) % 3];
      const double length = std::hypot(to.x - from.x, to.y - from.y);
      longest = std::max(longest, length);
      shortest = std::min(shortest, length);
    }
    // A cross product is off by some 2^-51 of the longest side squared; divided by the shortest side, that is a distance.
    margin_ = 0.01 + 0x1p-48 * longest * longest / shortest;
  }

  // False for a triangle with two corners in one place, or one that is not finite: it has no texels.
  bool can_show() const { return std::isfinite(margin_); }

  // The coordinates between which a row's texels may lie in the triangle; low > high if there are none.
  Interval columns_at(int row) const {
    const double low = row + 0.5 - margin_, high = row + 0.5 + margin_;
    Interval found{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
    for (size_t i = 0; i < 3; ++i) {
      Point a = corners_[i], b = corners_[(i + 1) % 3];
      if (a.y > b.y) std::swap(a, b);
      if (b.y < low || a.y > high) continue;
      const double slope = (b.x - a.x) / (b.y - a.y); // the edge crosses a line, so its ends are not level
      for (const double x : {a.y < low ? a.x + (low - a.y) * slope : a.x, b.y > high ? a.x + (high - a.y) * slope : b.x}) {
        found.low = std::min(found.low, x - margin_);
        found.high = std::max(found.high, x + margin_);
      }
    }
    return found;
  }

private:
  Corners corners_;
  double margin_;
};

// Barycentric weights of a texel's center in a triangle of either winding, if the center lies in it or on its border.
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

// The map's value at the same place of the triangle, bilinear; NaN where the map is undefined around it.
template <size_t Width> Value<Width> from_map(const pdesc_uv_image_input &input, int triangle, const Weights &weights) {
  const float *uv = input.map_uvs + size_t{6} * triangle;
  const double size = input.map_size;
  const double x = (uv[0] * weights[0] + uv[2] * weights[1] + uv[4] * weights[2]) * size - 0.5;
  const double y = (uv[1] * weights[0] + uv[3] * weights[1] + uv[5] * weights[2]) * size - 0.5;
  const bool near = x > -2.0 && y > -2.0 && x < size + 1.0 && y < size + 1.0; // false for NaN
  // At a texel's own center only that texel counts; the tolerance allows for rounding.
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

// Some rows of the image: the triangle that each of their texels shows, on which of its tiles, and the values there.
class Band {
public:
  Band(const pdesc_uv_image_input &input, Range rows)
      : input_(input), rows_(rows), bare_(size_t{1} * input.size * (rows.last - rows.first + 1)), shown_(bare_, none),
        tile_(bare_), next_((input.size + size_t{1}) * (rows.last - rows.first + 1)) {
    for (size_t i = 0; i < next_.size(); ++i) next_[i] = static_cast<int32_t>(i % (input.size + size_t{1}));
  }

  bool is_full() const { return bare_ == 0; }

  // Must be called for the last triangle first, because the first caller keeps its texels; likewise for the tiles of each
  // triangle.
  void claim(int triangle) {
    const Tiled uv = tiled(input_, triangle);
    for (int tiles = uv.rows - 1; tiles >= 0; --tiles) {
      checkpoint();
      const Corners corners = on_tile(uv, tiles * uv.columns, input_.size);
      const Outline outline(corners);
      if (!outline.can_show()) return;
      const Range rows = rows_of(corners, input_.size);
      for (int row = std::max(rows.first, rows_.first); row <= std::min(rows.last, rows_.last); ++row)
        if (bare_from(row, 0) < input_.size) claim(triangle, uv, tiles, row, outline.columns_at(row));
    }
  }

  // image: the first texel of the band's first row.
  template <size_t Width> void draw(float *image) {
    int triangle = none, tile = none;
    Tiled uv{};
    Corners corners{};
    for (int row = rows_.first; row <= rows_.last; ++row) {
      const int32_t *shown = shown_.data() + texel(row, 0);
      const uint8_t *tiles = tile_.data() + texel(row, 0);
      for (int column = 0; column < input_.size; ++column, image += input_.components) {
        if (shown[column] == none) {
          std::fill_n(image, input_.components, std::numeric_limits<float>::quiet_NaN());
          continue;
        }
        if (shown[column] != triangle) uv = tiled(input_, shown[column]);
        if (shown[column] != triangle || tiles[column] != tile) {
          triangle = shown[column];
          tile = tiles[column];
          corners = on_tile(uv, tile, input_.size);
        }
        const Value<Width> value = value_at<Width>(triangle, *weights_at(corners, column, row));
        for (int c = 0; c < input_.components; ++c) image[c] = static_cast<float>(value[c]);
      }
    }
  }

private:
  static constexpr int32_t none = -1;

  size_t texel(int row, int column) const { return size_t{1} * (row - rows_.first) * input_.size + column; }

  // The first column from this one on that shows nothing yet; size if there is none.
  int bare_from(int row, int column) {
    int32_t *const next = next_.data() + size_t{1} * (row - rows_.first) * (input_.size + 1);
    while (next[column] != column) column = next[column] = next[next[column]];
    return column;
  }

  // Claims a row of texels on a row of tiles. between: coordinates in texels of the first of these tiles.
  void claim(int triangle, const Tiled &uv, int tiles, int row, Interval between) {
    const double size = input_.size;
    const double first = std::max(std::floor(between.low / size), 0.0), last = std::min(between.high / size, uv.columns - 1.0);
    for (int column_of_tiles = static_cast<int>(std::max(last, -1.0)); column_of_tiles >= first; --column_of_tiles) {
      const int tile = tiles * uv.columns + column_of_tiles;
      const Corners corners = on_tile(uv, tile, size);
      const Range near =
          centers_between(between.low - column_of_tiles * size, between.high - column_of_tiles * size, input_.size);
      const Range columns = columns_of(corners, input_.size);
      if (near.last - near.first > many_columns) checkpoint();
      const int end = std::min(near.last, columns.last);
      for (int column = bare_from(row, std::max(near.first, columns.first)); column <= end; column = bare_from(row, column + 1))
        if (weights_at(corners, column, row)) show(triangle, tile, row, column);
    }
  }

  void show(int triangle, int tile, int row, int column) {
    shown_[texel(row, column)] = triangle;
    tile_[texel(row, column)] = static_cast<uint8_t>(tile);
    next_[size_t{1} * (row - rows_.first) * (input_.size + 1) + column] = column + 1;
    --bare_;
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
  size_t bare_;                // texels that show nothing yet
  std::vector<int32_t> shown_; // (rows, size)
  std::vector<uint8_t> tile_;  // (rows, size)
  std::vector<int32_t> next_;  // (rows, size + 1) a column's own number, or one nearer to the next bare column
};
static_assert(max_tiles * max_tiles - 1 <= std::numeric_limits<uint8_t>::max());

// (triangle_count) the rows in which each triangle may appear.
std::vector<Range> rows_of_triangles(const pdesc_uv_image_input &input) {
  std::vector<Range> rows(input.triangle_count);
  parallel_blocks(input.triangle_count, input.threads, 4096, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const Tiled uv = tiled(input, i);
      rows[i] = uv.rows == 1 ? rows_of(on_tile(uv, 0, input.size), input.size) : Range{0, input.size - 1};
    }
  });
  return rows;
}

void draw_band(const pdesc_uv_image_input &input, const std::vector<Range> &rows, Range of_band, float *image) {
  Band band(input, of_band);
  for (int i = input.triangle_count - 1; i >= 0 && !band.is_full(); --i)
    if (rows[i].first <= of_band.last && rows[i].last >= of_band.first) band.claim(i);
  if (input.components <= static_cast<int>(few))
    band.draw<few>(image);
  else
    band.draw<most>(image);
}

} // namespace

void draw_uv_image(const pdesc_uv_image_input &input, std::span<float> image) {
  std::atomic<int> rows_done{0};
  const auto ask = [&, progress = progress_of(input.progress, input.user)] {
    check_cancel(progress, "image", static_cast<double>(rows_done) / input.size);
  };
  ask();
  const CancelScope scope(ask);
  const std::vector<Range> rows = rows_of_triangles(input);
  parallel_blocks(input.size, input.threads, band_rows, [&](int begin, int end) {
    draw_band(input, rows, {begin, end - 1}, image.data() + begin * input.size * input.components);
    rows_done += end - begin;
  });
}

} // namespace paradesc
