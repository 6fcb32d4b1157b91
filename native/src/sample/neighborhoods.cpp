// Floods over cells, one for all centers that start in a cell.
#include "sample/neighborhoods.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "support/parallel.h"
#include "support/pool.h"

namespace paradesc {

// Triangles are divided until pieces are small against the radius; the middle of each piece is a sample.
TexellessSamples sample_texelless_triangles(const Cells &cells, const Triangles &triangles,
                                            const std::function<vec3(size_t corner)> &normal_of, const BakeSpace &bake_space,
                                            float radius, const DisplacedSurface *displaced) {
  TexellessSamples samples;
  samples.begin.push_back(0);
  for (size_t cell = 0; cell + 1 < cells.texelless_begin.size(); ++cell) {
    for (int32_t k = cells.texelless_begin[cell]; k < cells.texelless_begin[cell + 1]; ++k) {
      const auto corner = 3 * static_cast<size_t>(cells.texelless[k]);
      vec3 p[3], normal[3];
      for (size_t i = 0; i < 3; ++i) {
        p[i] = bake_space.to_buffer(triangles.positions[triangles.corner_vertex[corner + i]]);
        normal[i] = normal_of(corner + i);
      }
      const float longest = std::max({length(p[1] - p[0]), length(p[2] - p[1]), length(p[0] - p[2])});
      // Limited before it becomes an integer: radii may be as small as floats are.
      const int side = static_cast<int>(std::fmax(1.0f, std::fmin(std::ceil(4.0f * longest / radius), 16.0f)));
      const float area = 0.5f * length(cross(p[1] - p[0], p[2] - p[0])) / static_cast<float>(side * side);
      auto add = [&](float a, float b) { // barycentric coordinates of corners 1 and 2
        if (displaced) {
          const SurfacePoint point = displaced->at(static_cast<int>(corner / 3), a, b);
          samples.samples.push_back({point.position, area * point.area_ratio, point.normal, 0});
          return;
        }
        const vec3 n = normal[0] * (1.0f - a - b) + normal[1] * a + normal[2] * b;
        const float span = length(n);
        samples.samples.push_back({p[0] + (p[1] - p[0]) * a + (p[2] - p[0]) * b, area, span > 0.0f ? n / span : normal[0],
                                   static_cast<int32_t>(corner / 3)});
        samples.weights.emplace_back(a, b);
      };
      for (int i = 0; i < side; ++i)
        for (int j = 0; i + j < side; ++j) {
          const auto step = 1.0f / static_cast<float>(side);
          add((static_cast<float>(i) + 1.0f / 3.0f) * step, (static_cast<float>(j) + 1.0f / 3.0f) * step);
          if (i + j + 1 < side) add((static_cast<float>(i) + 2.0f / 3.0f) * step, (static_cast<float>(j) + 2.0f / 3.0f) * step);
        }
    }
    samples.begin.push_back(static_cast<int32_t>(samples.samples.size()));
  }
  return samples;
}

std::vector<CellData> with_texelless_samples(std::span<const CellData> measured, const TexellessSamples &texelless) {
  std::vector<CellData> cells(measured.begin(), measured.end());
  for (size_t cell = 0; cell + 1 < texelless.begin.size(); ++cell)
    for (int32_t k = texelless.begin[cell]; k < texelless.begin[cell + 1]; ++k) {
      const TexellessSample &sample = texelless.samples[static_cast<size_t>(k)];
      CellData &data = cells[cell];
      if (data.sphere.w < 0.0f) {
        data.sphere = vec4(sample.position, 0.0f);
        data.cone = vec4(sample.normal, 1.0f);
      }
      data.sphere.w = std::max(data.sphere.w, length(sample.position - vec3(data.sphere)));
      data.cone.w = std::min(data.cone.w, dot(vec3(data.cone), sample.normal));
    }
  return cells;
}

Starts list_starts(std::span<const int32_t> begin, std::span<const int32_t> start_cells, int cell_count) {
  const size_t centers = begin.size() - 1;
  const auto cell_of = [&](size_t i) { return begin[i] < begin[i + 1] ? start_cells[begin[i]] : cell_count; };
  Starts starts;
  starts.begin.assign(static_cast<size_t>(cell_count) + 2, 0);
  for (size_t i = 0; i < centers; ++i) ++starts.begin[cell_of(i) + 1];
  std::partial_sum(starts.begin.begin(), starts.begin.end(), starts.begin.begin());
  std::vector<int32_t> next(starts.begin.begin(), starts.begin.end() - 1);
  starts.order.resize(centers);
  for (size_t i = 0; i < centers; ++i) starts.order[next[cell_of(i)]++] = static_cast<int32_t>(i);
  starts.begin.pop_back();
  starts.range.reserve(centers);
  for (size_t i = 0; i < centers; ++i) starts.range.emplace_back(begin[i], begin[i + 1]);
  starts.cell.reserve(start_cells.size());
  for (const int32_t cell : start_cells) starts.cell.emplace_back(cell, 0);
  return starts;
}

std::vector<int32_t> put_in_order(Starts &starts) {
  std::vector<int32_t> order = std::move(starts.order);
  std::vector<ivec2> range;
  range.reserve(order.size());
  for (const int32_t i : order) range.push_back(starts.range[i]);
  starts.range = std::move(range);
  starts.order.resize(order.size());
  std::iota(starts.order.begin(), starts.order.end(), 0);
  return order;
}

namespace {

// A ball around some centers.
struct Spread {
  vec3 low{std::numeric_limits<float>::max()}, high{-std::numeric_limits<float>::max()};
  void add(vec3 from, vec3 to) {
    low = glm::min(low, from);
    high = glm::max(high, to);
  }
  vec3 middle() const { return 0.5f * (low + high); }
  float radius() const { return 0.5f * length(high - low); }
};

// What floods read of the cells, close together.
struct FloodCells {
  std::vector<vec4> sphere;
  std::vector<vec3> facing; // normal times area

  explicit FloodCells(std::span<const CellData> measured) {
    sphere.reserve(measured.size());
    facing.reserve(measured.size());
    for (const CellData &cell : measured) {
      sphere.push_back(cell.sphere);
      facing.push_back(cell.sphere.w >= 0.0f ? vec3(cell.cone) * cell.area.x : vec3(0.0f));
    }
  }
};

// Some cells, a bit each, which come in order; and a bit for each word that has some.
class SomeCells {
public:
  explicit SomeCells(int cells) : words_(static_cast<size_t>(cells) / 64 + 1, 0), used_(words_.size() / 64 + 1, 0) {}

  bool has(int32_t cell) const { return words_[word_of(cell)] >> (cell & 63) & 1; }
  void add(int32_t cell) {
    words_[word_of(cell)] |= uint64_t{1} << (cell & 63);
    used_[word_of(cell) >> 6] |= uint64_t{1} << (word_of(cell) & 63);
  }
  // Replaces the list by all that are there.
  void list(std::vector<int32_t> &cells) const {
    cells.clear();
    for_each_word([&](size_t word) {
      for (uint64_t bits = words_[word]; bits; bits &= bits - 1)
        cells.push_back(static_cast<int32_t>(64 * word) + std::countr_zero(bits));
    });
  }
  void clear() {
    for_each_word([&](size_t word) { words_[word] = 0; });
    std::ranges::fill(used_, 0);
  }

private:
  static size_t word_of(int32_t cell) { return static_cast<size_t>(cell) >> 6; }
  void for_each_word(const auto &visit) const {
    for (size_t i = 0; i < used_.size(); ++i)
      for (uint64_t bits = used_[i]; bits; bits &= bits - 1) visit(64 * i + static_cast<size_t>(std::countr_zero(bits)));
  }

  std::vector<uint64_t> words_, used_;
};

// The floods that one thread makes.
class Flood {
public:
  Flood(const Cells &cells, const FloodCells &measured, float radius)
      : cells_(cells), measured_(measured), radius_(radius), reached_(cells.count), seen_(cells.count) {}

  // All cells that are connected to `cell` within the ball of any center nearer than spread.radius to its middle; and others,
  // too. Sorted: one order of summation, wherever the search began.
  const std::vector<int32_t> &run(int32_t cell, const Spread &spread) {
    constexpr float around = 1.25f; // a link may lie a texel beyond the points of a cell
    const vec3 middle = spread.middle();
    const float reach = radius_ + spread.radius();
    reached_.clear();
    seen_.clear();
    found_.assign(1, cell);
    reached_.add(cell);
    seen_.add(cell);
    for (size_t i = 0; i < found_.size(); ++i) {
      const auto from = static_cast<size_t>(found_[i]);
      for (int32_t k = cells_.adjacency_begin[from]; k < cells_.adjacency_begin[from + 1]; ++k) {
        const int32_t other = cells_.adjacency[k].x;
        if (seen_.has(other)) continue; // four times of five
        seen_.add(other);
        const vec4 sphere = measured_.sphere[other];
        const vec3 gap = vec3(sphere) - middle;
        const float limit = reach + around * sphere.w;
        if (sphere.w >= 0.0f && dot(gap, gap) >= limit * limit) continue; // one without a sphere may lead on
        reached_.add(other);
        found_.push_back(other);
      }
    }
    reached_.list(found_);
    return found_;
  }

  bool was_found(int32_t cell) const { return reached_.has(cell); } // by the last one

  // Of what was found last.
  vec4 mean_normal() const {
    vec3 sum(0.0f);
    for (const int32_t cell : found_) sum += measured_.facing[cell];
    const float size = length(sum);
    return vec4(size > 0.0f ? sum / size : vec3(0.0f), 0.0f);
  }

private:
  const Cells &cells_;
  const FloodCells &measured_;
  float radius_;
  SomeCells reached_, seen_; // those seen may lie too far away
  std::vector<int32_t> found_;
};

} // namespace

// (cells) CELL_ bits.
static std::vector<int32_t> bits_of_cells(const Cells &cells, const CellStrides &strides, std::span<const CellData> measured) {
  const int leaf_texels = cells.block_size / 2 * (cells.block_size / 2);
  std::vector<int32_t> bits(measured.size(), 0);
  for (size_t i = 0; i < bits.size(); ++i) {
    if (strides.coarse[CELL_LEAVES * i] > leaf_texels) bits[i] |= CELL_JOINED;
    if (cells.boundary_begin[i] < cells.boundary_begin[i + 1]) bits[i] |= CELL_AT_BOUNDARY;
    for (size_t k = 0; k < CELL_LEAVES; ++k)
      if (measured[i].leaf[k].sphere.w >= 0.0f && strides.fine[CELL_LEAVES * i + k] != strides.coarse[CELL_LEAVES * i + k])
        bits[i] |= CELL_FINE_LEAF << k;
  }
  return bits;
}

namespace {

// Cells in which centers start, by squares that are small against the radius: those of one square share a flood.
struct Squares {
  std::vector<int32_t> cell;  // by squares
  std::vector<int32_t> begin; // (squares + 1) into cell
};

} // namespace

static Squares squares_of(const Cells &cells, std::span<const CellData> measured, const Starts &starts, float radius) {
  double spheres = 0.0;
  for (const CellData &cell : measured) spheres += static_cast<double>(std::max(cell.sphere.w, 0.0f));
  const double radii = static_cast<double>(radius) * static_cast<double>(measured.size()) / std::max(spheres, 1e-30);
  const int width = (radii > 4.4 ? 4 : radii > 2.6 ? 2 : 1) * cells.block_size; // at most about the radius
  std::vector<std::tuple<int, int, int32_t>> list;                              // row and column of the square, cell
  for (int32_t cell = 0; cell < cells.count; ++cell)
    if (starts.begin[cell] < starts.begin[cell + 1])
      list.emplace_back(cells.box[cell].y / width, cells.box[cell].x / width, cell);
  std::ranges::sort(list);
  Squares squares;
  for (size_t i = 0; i < list.size(); ++i) {
    const auto [row, column, cell] = list[i];
    if (i == 0 || std::pair(row, column) != std::pair(std::get<0>(list[i - 1]), std::get<1>(list[i - 1])))
      squares.begin.push_back(static_cast<int32_t>(i));
    squares.cell.push_back(cell);
  }
  squares.begin.push_back(static_cast<int32_t>(squares.cell.size()));
  return squares;
}

namespace {

// What is near some squares, before it is joined to one list.
struct Part {
  std::vector<ivec4> near;     // as NearCells::cell
  std::vector<int32_t> joined; // cells that others share a flood with, and what each of them has in `near`
  std::vector<ivec2> range;
};

// Lists what is near the cells of a square: those that the flood from the first one finds, then from the first of the others…
class SquareSearch {
public:
  SquareSearch(const Cells &cells, const FloodCells &measured, std::span<const int32_t> bits, const Starts &starts,
               const CenterPositions &positions, float radius)
      : bits_(bits), starts_(starts), positions_(positions), radius_(radius), flood_(cells, measured, radius) {}

  void run(std::span<const int32_t> square, NearCells &near, Part &part) {
    constexpr float most = 0.6f; // of the radius: the map may stretch a square to any length
    std::vector<Start> left;
    for (const int32_t cell : square) left.push_back({cell, spread_of(cell)});
    while (!left.empty()) {
      Spread spread;
      for (const Start &start : left) spread.add(start.spread.low, start.spread.high);
      const bool together = spread.radius() <= most * radius_;
      list(left, together ? spread : Spread(left[0].spread), together, near, part);
    }
  }

private:
  // A cell in which centers start.
  struct Start {
    int32_t cell;
    Spread spread; // of these centers
  };

  Spread spread_of(int32_t cell) const {
    Spread spread;
    for (int32_t i = starts_.begin[cell]; i < starts_.begin[cell + 1]; ++i) {
      const vec3 position = positions_.all[positions_.index[starts_.order[i]]];
      spread.add(position, position);
    }
    return {positions_.space.to_buffer(spread.low), positions_.space.to_buffer(spread.high)}; // which keeps their order
  }

  // Takes the first cell out of `left`, and those that its flood finds if they share it.
  void list(std::vector<Start> &left, const Spread &spread, bool together, NearCells &near, Part &part) {
    const int32_t first = left[0].cell;
    const auto begin = static_cast<int32_t>(part.near.size());
    for (const int32_t found : flood_.run(first, spread)) part.near.emplace_back(found, first, 0, bits_[found]);
    near.normal[first] = flood_.mean_normal();
    std::vector<Start> others;
    for (const Start &start : left) {
      if (start.cell != first && !(together && flood_.was_found(start.cell))) {
        others.push_back(start);
        continue;
      }
      part.joined.push_back(start.cell);
      part.range.emplace_back(begin, static_cast<int32_t>(part.near.size()));
    }
    left.swap(others);
  }

  std::span<const int32_t> bits_;
  const Starts &starts_;
  const CenterPositions &positions_;
  float radius_;
  Flood flood_;
};

} // namespace

// Appends the parts to one list.
static void join(const Cells &cells, std::vector<Part> &parts, NearCells &near) {
  for (Part &part : parts) {
    const auto offset = static_cast<int32_t>(near.cell.size());
    for (size_t i = 0; i < part.joined.size(); ++i) {
      near.range[part.joined[i]] = part.range[i] + offset;
      near.most = std::max(near.most, static_cast<size_t>(part.range[i].y - part.range[i].x));
    }
    for (ivec4 &one : part.near) {
      one.z = static_cast<int32_t>(near.neighbors);
      near.neighbors += static_cast<size_t>(cells.adjacency_begin[one.x + 1] - cells.adjacency_begin[one.x]);
    }
    near.cell.insert(near.cell.end(), part.near.begin(), part.near.end());
    part = {};
  }
}

NearCells find_near_cells(const Cells &cells, const CellStrides &strides, std::span<const CellData> measured,
                          const Starts &starts, const CenterPositions &positions, float radius, int threads) {
  constexpr int block = 32;
  const std::vector<int32_t> bits = bits_of_cells(cells, strides, measured);
  const Squares squares = squares_of(cells, measured, starts, radius);
  const FloodCells flood_cells(measured);
  NearCells near;
  near.any_fine = std::ranges::any_of(bits, [](int32_t of_cell) { return of_cell >= CELL_FINE_LEAF; });
  near.range.assign(measured.size(), ivec2(0));
  near.normal.assign(measured.size(), vec4(0.0f));
  const auto count = static_cast<int>(squares.begin.size()) - 1;
  std::vector<Part> parts(static_cast<size_t>((count + block - 1) / block));
  Pool<SquareSearch> searches;
  parallel_blocks(count, threads, block, [&](int first, int last) {
    Part part; // of its own: neighboring vectors share cache lines
    searches.with_one([&] { return SquareSearch(cells, flood_cells, bits, starts, positions, radius); },
                      [&](SquareSearch &search) {
                        for (int i = first; i < last; ++i) {
                          const auto begin = static_cast<size_t>(squares.begin[i]),
                                     end = static_cast<size_t>(squares.begin[i + 1]);
                          search.run(std::span(squares.cell).subspan(begin, end - begin), near, part);
                        }
                      });
    parts[first / block] = std::move(part);
  });
  join(cells, parts, near);
  return near;
}

} // namespace paradesc
