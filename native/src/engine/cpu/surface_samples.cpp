// Large triangles are halved at their longest edges until the pieces are small.
#include "engine/cpu/surface_samples.h"

#include <algorithm>
#include <cmath>
#include <limits>
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

// Part of a triangle.
struct Piece {
  vec3 corner[3];
  vec2 weights[3];      // of the triangle's corners 1 and 2, at each
  bool at_rim() const { // some corner lies on an edge of the triangle
    return std::ranges::any_of(weights, [](vec2 w) { return w.x == 0.0f || w.y == 0.0f || w.x + w.y == 1.0f; });
  }
};

// Pieces are halved at their longest edge: then they are hardly longer than wide.
class Divider {
public:
  Divider(const SurfelSource &source, const Surfels &surfels, int32_t surfel, vec3 middle, float limit, SampleList &samples)
      : middle_(middle), limit_(limit), surfel_(surfel), samples_(samples), has_map_(source.map != nullptr) {
    const int32_t triangle = source.tree.triangle[surfels.first[surfel]];
    lean_ = lean_of(source, surfels, surfel, surfels.face[triangle]);
    for (int32_t k = 0; k < 3; ++k) {
      const int32_t corner = 3 * triangle + k;
      whole_.corner[k] = source.position(corner);
      whole_.weights[k] = {k == 1 ? 1.0f : 0.0f, k == 2 ? 1.0f : 0.0f};
      normal_[k] = source.normals.corner(static_cast<size_t>(corner));
      map_[k] = source.map ? (*source.map)[source.half_edges.corner_point[corner]] : vec4(0.0f);
    }
    largest_spread_ = surfels.largest_spread_between(normal_);
  }

  void run() { divide(whole_); }

private:
  static float square(vec3 v) { return dot(v, v); }

  void divide(const Piece &piece) {
    const auto &p = piece.corner;
    const float edges[3] = {square(p[1] - p[0]), square(p[2] - p[1]), square(p[0] - p[2])};
    const float spread = (edges[0] + edges[1] + edges[2]) * (1.0f / 36.0f);
    if (!(spread > largest_spread_)) return add(piece);
    const float beyond = limit_ + 3.5f * std::sqrt(spread); // no corner is farther from the middle
    if (square((p[0] + p[1] + p[2]) * (1.0f / 3.0f) - middle_) > beyond * beyond) return;
    const int longest = edges[0] >= edges[1] && edges[0] >= edges[2] ? 0 : edges[1] >= edges[2] ? 1 : 2;
    const int from = longest, to = (longest + 1) % 3;
    Piece half = piece;
    half.corner[to] = 0.5f * (p[from] + p[to]);
    half.weights[to] = 0.5f * (piece.weights[from] + piece.weights[to]);
    divide(half);
    half.corner[from] = half.corner[to];
    half.weights[from] = half.weights[to];
    half.corner[to] = p[to];
    half.weights[to] = piece.weights[to];
    divide(half);
  }

  template <class T> static T at(const T *of, vec2 weights) {
    return of[0] + (of[1] - of[0]) * weights.x + (of[2] - of[0]) * weights.y;
  }

  static SampleMap map_of_triangle(const vec4 (&values)[3]) {
    const vec4 to_next = values[1] - values[0], to_previous = values[2] - values[0];
    return flat((values[0] + values[1] + values[2]) * (1.0f / 3.0f), (to_next + to_previous) * 0.11785113f,
                (to_next - to_previous) * 0.20412415f); // as sample_of_triangle()
  }

  void add(const Piece &piece) {
    vec3 normals[3];
    for (int k = 0; k < 3; ++k) {
      const vec3 normal = at(normal_, piece.weights[k]);
      const float length_squared = square(normal);
      normals[k] = length_squared > 0.0f ? normal / std::sqrt(length_squared) : normal_[0];
    }
    samples_.sample.push_back(flat(sample_of_triangle(piece.corner, normals, piece.at_rim() ? lean_ : 0.0f), surfel_));
    if (!has_map_) return;
    const vec4 values[3] = {at(map_, piece.weights[0]), at(map_, piece.weights[1]), at(map_, piece.weights[2])};
    samples_.map.push_back(map_of_triangle(values));
  }

  Piece whole_;
  float lean_;
  vec3 middle_;
  float limit_, largest_spread_;
  int32_t surfel_;
  SampleList &samples_;
  vec3 normal_[3];
  bool has_map_;
  vec4 map_[3];
};

} // namespace

void divide_triangle(const SurfelSource &source, const Surfels &surfels, int32_t surfel, vec3 middle, float limit,
                     SampleList &samples) {
  Divider(source, surfels, surfel, middle, limit, samples).run();
}

// By the middles of its triangles' edges, where the product of two linear functions has its mean.
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
    const int32_t first = 3 * source.tree.triangle[i];
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

static constexpr float least_area = 1e-30f; // one over it is a float

static void add_surfel(const SurfelSource &source, const Surfels &surfels, int32_t index, SampleList &samples) {
  const Surfel &surfel = surfels.surfel[index];
  if (surfel.samples > max_stored_samples) return;
  if (surfel.samples > 1.0f)
    return divide_triangle(source, surfels, index, vec3(0.0f), std::numeric_limits<float>::max(), samples);
  const int32_t triangle = source.tree.triangle[surfels.first[index]];
  const Cluster *const cluster = surfel.cluster >= 0 ? &surfels.cluster[surfel.cluster] : nullptr;
  const float lean = lean_of(source, surfels, index, cluster ? glm::normalize(cluster->face) : surfels.face[triangle]);
  const Sample sample = cluster ? sample_of(*cluster, lean) : sample_of(source, triangle, lean);
  if (!(sample.area > least_area)) return;
  samples.sample.push_back(flat(sample, index));
  if (source.map) samples.map.push_back(map_of(source, surfels, index, sample));
}

static void add_blocks(int threads, SurfaceSamples &samples) {
  const std::vector<FlatSample> &all = samples.list.sample;
  const size_t blocks = (all.size() + block_lanes - 1) / block_lanes;
  samples.block.resize(blocks);
  samples.sphere.resize(blocks);
  parallel_blocks(static_cast<int>(blocks), threads, 256, [&](int begin, int end) {
    for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
      const size_t first = i * block_lanes;
      const auto of_block = std::span(all).subspan(first, std::min<size_t>(block_lanes, all.size() - first));
      samples.block[i] = block_of(of_block);
      samples.sphere[i] = sphere_of(of_block);
    }
  });
}

SurfaceSamples list_samples(const SurfelSource &source, const Surfels &surfels) {
  constexpr int surfels_of_part = 4096;
  const auto count = static_cast<int>(surfels.surfel.size());
  const int part_count = (count + surfels_of_part - 1) / surfels_of_part;
  std::vector<SampleList> parts(static_cast<size_t>(part_count));
  SurfaceSamples result;
  result.first.resize(static_cast<size_t>(count) + 1);
  parallel_blocks(count, source.threads, surfels_of_part, [&](int begin, int end) {
    SampleList &part = parts[begin / surfels_of_part];
    part.sample.reserve(static_cast<size_t>(end - begin));
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
  parallel_blocks(part_count, source.threads, 1, [&](int index, int) {
    const SampleList part = std::exchange(parts[index], {});
    std::ranges::copy(part.sample, result.list.sample.begin() + begin[index]);
    std::ranges::copy(part.map, result.list.map.begin() + (source.map ? begin[index] : 0));
    const int end = std::min((index + 1) * surfels_of_part, count);
    for (int k = index * surfels_of_part; k < end; ++k) result.first[k] += begin[index];
  });
  add_blocks(source.threads, result);
  return result;
}

} // namespace paradesc
