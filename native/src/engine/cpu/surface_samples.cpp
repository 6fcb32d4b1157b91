// Divides large triangles at their longest edges until the pieces are small.
#include "engine/cpu/surface_samples.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include "support/parallel.h"

namespace paradesc {

static SampleMap flat(vec4 mean, vec4 first, vec4 second) {
  SampleMap map;
  std::copy_n(&mean.x, 4, map.mean);
  std::copy_n(&first.x, 4, map.along[0]);
  std::copy_n(&second.x, 4, map.along[1]);
  return map;
}

namespace {

// A place on a triangle.
struct Place {
  vec3 position;
  vec2 weights; // for the triangle's corners 1 and 2
  vec3 normal;  // linear between the corners, hence shorter than 1 where normals turn
};

struct Piece {
  Place corner[3];
  bool at_rim() const { // whether a corner lies on an edge of the triangle
    return std::ranges::any_of(corner, [](const Place &place) {
      const vec2 w = place.weights;
      return w.x == 0.0f || w.y == 0.0f || w.x + w.y >= 0.999999f;
    });
  }
};

// Halves pieces at their longest edges, which keeps them compact. For needles that would create far more pieces than fit side by
// side, so needles are cut crosswise first.
class Divider {
public:
  Divider(const SurfelSource &source, const Surfels &surfels, int32_t surfel, vec3 middle, float limit, SampleList &samples)
      : surfels_(surfels), middle_(middle), limit_(limit), surfel_(surfel), samples_(samples), has_map_(source.map != nullptr) {
    const int32_t triangle = source.tree.item[surfels.first[surfel]];
    lean_ = lean_of(source, surfels, surfel, surfels.face[triangle]);
    const Sample undivided = sample_of(source, triangle, lean_);
    noise_ = undivided.noise;
    facet_ = undivided.facet;
    for (int32_t k = 0; k < 3; ++k) {
      const int32_t corner = 3 * triangle + k;
      whole_.corner[k] = {source.position(corner),
                          {k == 1 ? 1.0f : 0.0f, k == 2 ? 1.0f : 0.0f},
                          source.normals.corner(static_cast<size_t>(corner))};
      map_[k] = source.map ? (*source.map)[source.half_edges.corner_point[corner]] : vec4(0.0f);
    }
  }

  void run() {
    constexpr float of_needles = 0.03125f; // height over length
    const int longest = longest_edge(whole_);
    const Place &from = whole_.corner[longest], &to = whole_.corner[(longest + 1) % 3], &top = whole_.corner[(longest + 2) % 3];
    const vec3 along = to.position - from.position;
    const float share = dot(top.position - from.position, along) / square(along);
    const Place foot = between(from, to, glm::clamp(share, 0.0f, 1.0f));
    if (!(square(top.position - foot.position) < of_needles * of_needles * square(along))) return divide(whole_);
    cut_needle({from, foot, top}, 0.0f, 1.0f);
    cut_needle({to, top, foot}, 0.0f, 1.0f);
  }

private:
  static float square(vec3 v) { return dot(v, v); }

  static Place between(const Place &a, const Place &b, float share) {
    return {a.position + (b.position - a.position) * share, a.weights + (b.weights - a.weights) * share,
            a.normal + (b.normal - a.normal) * share};
  }

  static vec3 edge(const Piece &piece, int k) { return piece.corner[(k + 1) % 3].position - piece.corner[k].position; }

  static int longest_edge(const Piece &piece) {
    const float edges[3] = {square(edge(piece, 0)), square(edge(piece, 1)), square(edge(piece, 2))};
    return edges[0] >= edges[1] && edges[0] >= edges[2] ? 0 : edges[1] >= edges[2] ? 1 : 2;
  }

  bool is_beyond(vec3 position, float reach) const {
    const float beyond = limit_ + reach;
    return square(position - middle_) > beyond * beyond;
  }

  // Divides the part of a needle between two fractions of the way from its tip, corner 0, to its base.
  void cut_needle(const Piece &needle, float begin, float end) {
    const vec3 to_base = edge(needle, 0);
    const float width = end * length(edge(needle, 1)), half = 0.5f * (end - begin) * length(to_base);
    if (is_beyond(needle.corner[0].position + (0.5f * (begin + end)) * to_base, half + width)) return;
    if (2.0f * half > width && half * half > 4.5f * surfels_.largest_spread) {
      cut_needle(needle, begin, 0.5f * (begin + end));
      cut_needle(needle, 0.5f * (begin + end), end);
      return;
    }
    const auto &[tip, left, right] = needle.corner;
    const Place last = between(tip, left, end), across = between(tip, right, begin);
    if (begin > 0.0f) divide({{between(tip, left, begin), last, across}});
    divide({{across, last, between(tip, right, end)}});
  }

  void divide(const Piece &piece) {
    const vec3 a = piece.corner[0].position, b = piece.corner[1].position, c = piece.corner[2].position;
    const float spread = (square(b - a) + square(c - b) + square(a - c)) * (1.0f / 36.0f);
    const float turn = squared_turn(piece.corner[0].normal, piece.corner[1].normal, piece.corner[2].normal);
    if (!(spread > surfels_.largest_spread_at(turn))) return add(piece);
    if (is_beyond((a + b + c) * (1.0f / 3.0f), 3.5f * std::sqrt(spread))) return; // no corner is farther from the centroid
    const int from = longest_edge(piece), to = (from + 1) % 3;
    const Place middle = between(piece.corner[from], piece.corner[to], 0.5f);
    Piece half = piece;
    half.corner[to] = middle;
    divide(half);
    half.corner[to] = piece.corner[to];
    half.corner[from] = middle;
    divide(half);
  }

  template <class T> static T at(const T *of, vec2 weights) {
    return of[0] + (of[1] - of[0]) * weights.x + (of[2] - of[0]) * weights.y;
  }

  static SampleMap map_of_triangle(const vec4 (&values)[3]) {
    const vec4 to_next = values[1] - values[0], to_previous = values[2] - values[0];
    return flat((values[0] + values[1] + values[2]) * (1.0f / 3.0f), (to_next + to_previous) * 0.11785113f,
                (to_next - to_previous) * 0.20412415f); // as in sample_of_triangle()
  }

  void add(const Piece &piece) {
    vec3 positions[3], normals[3];
    for (int k = 0; k < 3; ++k) {
      positions[k] = piece.corner[k].position;
      normals[k] = piece.corner[k].normal;
    }
    Sample sample = sample_of_triangle(positions, normals, piece.at_rim() ? lean_ : 0.0f);
    sample.noise = noise_;
    sample.facet = facet_;
    samples_.sample.push_back(flat(sample, surfel_));
    if (!has_map_) return;
    const auto value = [&](int k) { return at(map_, piece.corner[k].weights); };
    samples_.map.push_back(map_of_triangle({value(0), value(1), value(2)}));
  }

  const Surfels &surfels_;
  Piece whole_;
  float lean_, noise_, facet_;
  vec3 middle_;
  float limit_;
  int32_t surfel_;
  SampleList &samples_;
  bool has_map_;
  vec4 map_[3];
};

} // namespace

void divide_triangle(const SurfelSource &source, const Surfels &surfels, int32_t surfel, vec3 middle, float limit,
                     SampleList &samples) {
  Divider(source, surfels, surfel, middle, limit, samples).run();
}

// Uses the edge midpoints of the surfel's triangles, over which the product of two linear functions has its mean.
static SampleMap map_of(const SurfelSource &source, const Surfels &surfels, int32_t surfel, const Sample &sample) {
  const float u = dot(sample.along[0], sample.along[0]), v = dot(sample.along[1], sample.along[1]),
              uv = dot(sample.along[0], sample.along[1]), determinant = u * v - uv * uv;
  const bool is_line = !(determinant > 1e-6f * u * v);
  const vec3 to_first =
      is_line ? sample.along[0] / std::max(u, 1e-30f) : (v * sample.along[0] - uv * sample.along[1]) / determinant;
  const vec3 to_second = is_line ? vec3(0.0f) : (u * sample.along[1] - uv * sample.along[0]) / determinant;
  vec4 mean(0.0f), first_sum(0.0f), second_sum(0.0f);
  vec2 places(0.0f);
  float area = 0.0f;
  for (int32_t i = surfels.first[surfel]; i < surfels.first[surfel + 1]; ++i) {
    const int32_t first = 3 * source.tree.item[i];
    const vec3 a = source.position(first);
    const float part = length(cross(source.position(first + 1) - a, source.position(first + 2) - a)) * (1.0f / 3.0f);
    area += 3.0f * part;
    for (int32_t corner = first; corner < first + 3; ++corner) {
      const int32_t next = next_corner(corner);
      const auto at = [&](int32_t c) { return (*source.map)[source.half_edges.corner_point[c]]; };
      const vec4 value = part * 0.5f * (at(corner) + at(next));
      const vec3 gap = 0.5f * (source.position(corner) + source.position(next)) - sample.position;
      const vec2 place(dot(gap, to_first), dot(gap, to_second));
      mean += value;
      first_sum += value * place.x;
      second_sum += value * place.y;
      places += part * place;
    }
  }
  if (!(area > 0.0f)) return {};
  mean /= area;
  return flat(mean, (first_sum - mean * places.x) / area, (second_sum - mean * places.y) / area);
}

static constexpr float least_area = 1e-30f; // its reciprocal is a finite float

static void add_surfel(const SurfelSource &source, const Surfels &surfels, int32_t index, SampleList &samples) {
  const Surfel &surfel = surfels.surfel[index];
  if (surfel.samples > max_stored_samples) return;
  if (surfel.samples > 1.0f)
    return divide_triangle(source, surfels, index, vec3(0.0f), std::numeric_limits<float>::max(), samples);
  const int32_t triangle = source.tree.item[surfels.first[index]];
  const Cluster *const cluster = surfel.cluster >= 0 ? &surfels.cluster[surfel.cluster] : nullptr;
  const float lean = lean_of(source, surfels, index, cluster ? glm::normalize(cluster->face) : surfels.face[triangle]);
  const Sample sample = cluster ? sample_of(*cluster, lean) : sample_of(source, triangle, lean);
  if (!(sample.area > least_area)) return;
  samples.sample.push_back(flat(sample, index));
  if (source.map) samples.map.push_back(map_of(source, surfels, index, sample));
}

namespace {

// Orders the samples of a cell into blocks, by recursive halving along the longest side of their bounding box.
class BlockOrder {
public:
  BlockOrder(const UnsetVector<FlatSample> &samples, int32_t begin, int32_t end) : samples_(samples) {
    order_.resize(static_cast<size_t>(end - begin));
    std::iota(order_.begin(), order_.end(), begin);
    halve(order_);
  }
  const std::vector<int32_t> &order() const { return order_; }

private:
  void halve(std::span<int32_t> part) {
    const size_t blocks = (part.size() + block_lanes - 1) / block_lanes;
    if (blocks < 2) {
      std::ranges::sort(part); // C++ libraries differ in the order that nth_element leaves
      return;
    }
    vec3 low(std::numeric_limits<float>::max()), high(-low);
    for (const int32_t i : part) {
      const float *const position = samples_[i].position;
      const vec3 at(position[0], position[1], position[2]);
      low = glm::min(low, at);
      high = glm::max(high, at);
    }
    const vec3 size = high - low;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const size_t middle = blocks / 2 * block_lanes;
    const auto is_before = [&](int32_t a, int32_t b) {
      const float of_a = samples_[a].position[axis], of_b = samples_[b].position[axis];
      return of_a < of_b || (of_a == of_b && a < b);
    };
    std::ranges::nth_element(part, part.begin() + static_cast<ptrdiff_t>(middle), is_before);
    halve(part.first(middle));
    halve(part.subspan(middle));
  }

  const UnsetVector<FlatSample> &samples_;
  std::vector<int32_t> order_;
};

} // namespace

template <class T> static void put_in_order(const std::vector<int32_t> &order, int32_t begin, UnsetVector<T> &items) {
  if (items.empty()) return;
  std::vector<T> ordered;
  ordered.reserve(order.size());
  for (const int32_t i : order) ordered.push_back(items[i]);
  std::ranges::copy(ordered, items.begin() + begin);
}

// samples_of_cell: (cells + 1) into the list.
static void add_blocks(const std::vector<int32_t> &samples_of_cell, int threads, SurfaceSamples &samples) {
  const int cells = static_cast<int>(samples_of_cell.size()) - 1;
  samples.cell_block.assign(1, 0);
  for (int i = 0; i < cells; ++i)
    samples.cell_block.push_back(samples.cell_block[i] +
                                 (samples_of_cell[i + 1] - samples_of_cell[i] + block_lanes - 1) / block_lanes);
  const auto blocks = static_cast<size_t>(samples.cell_block.back());
  samples.block.resize(blocks);
  samples.sphere.resize(blocks);
  samples.block_begin.resize(blocks);
  samples.block_begin.push_back(samples_of_cell.back());
  parallel_blocks(cells, threads, 64, [&](int begin, int end) {
    for (int cell = begin; cell < end; ++cell) {
      const int32_t first = samples_of_cell[cell], last = samples_of_cell[cell + 1];
      const BlockOrder blocks_of_cell(samples.list.sample, first, last);
      put_in_order(blocks_of_cell.order(), first, samples.list.sample);
      put_in_order(blocks_of_cell.order(), first, samples.list.map);
      for (int32_t i = first, block = samples.cell_block[cell]; i < last; i += block_lanes, ++block) {
        const std::span of_block(&samples.list.sample[i], static_cast<size_t>(std::min(block_lanes, last - i)));
        samples.block_begin[block] = i;
        samples.block[block] = block_of(of_block);
        samples.sphere[block] = sphere_of(of_block);
      }
    }
  });
}

SurfaceSamples list_samples(const SurfelSource &source, const Surfels &surfels) {
  constexpr int surfels_of_part = 1024;
  const auto count = static_cast<int>(surfels.surfel.size());
  const Blocks blocks{count, surfels_of_part};
  std::vector<SampleList> parts(static_cast<size_t>(blocks.number()));
  SurfaceSamples result;
  result.first.resize(static_cast<size_t>(count) + 1);
  parallel_blocks(count, source.threads, surfels_of_part, [&](int begin, int end) {
    SampleList &part = parts[begin / surfels_of_part];
    float count_of_part = 0.0f;
    for (int k = begin; k < end; ++k) count_of_part += std::min(surfels.surfel[k].samples, max_stored_samples);
    part.sample.reserve(static_cast<size_t>(1.25f * count_of_part));
    for (int k = begin; k < end; ++k) {
      result.first[k] = static_cast<int32_t>(part.sample.size());
      add_surfel(source, surfels, k, part);
    }
  });
  std::vector<int32_t> begin{0};
  for (const SampleList &part : parts) begin.push_back(begin.back() + static_cast<int32_t>(part.sample.size()));
  result.list.sample.resize(static_cast<size_t>(begin.back()));
  if (source.map) result.list.map.resize(static_cast<size_t>(begin.back()));
  result.first[count] = begin.back();
  parallel_blocks(blocks.number(), source.threads, 1, [&](int index, int) {
    const SampleList part = std::exchange(parts[index], {});
    std::ranges::copy(part.sample, result.list.sample.begin() + begin[index]);
    std::ranges::copy(part.map, result.list.map.begin() + (source.map ? begin[index] : 0));
    for (int k = blocks.begin(index); k < blocks.end(index); ++k) result.first[k] += begin[index];
  });
  std::vector<int32_t> samples_of_cell;
  for (const int32_t surfel : surfels.cell_begin) samples_of_cell.push_back(result.first[surfel]);
  add_blocks(samples_of_cell, source.threads, result);
  return result;
}

} // namespace paradesc
