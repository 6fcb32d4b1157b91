// Divides large triangles at their longest edges until the pieces are small.
#include "engine/cpu/triangle_samples.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace paradesc {

float SampleLimit::at(float turn) const {
  constexpr float hardly = 0.1f, finer = 5.0f; // a turn of 0.1 is 18 degrees
  return largest_spread / (1.0f + finer * std::max(turn - hardly, 0.0f));
}

float squared_turn(vec3 a, vec3 b, vec3 c) {
  const auto square = [](vec3 v) { return dot(v, v); };
  constexpr float opposite = 4.0f;
  const float farthest = std::max({square(b - a), square(c - b), square(a - c)}),
              least = std::min({square(a), square(b), square(c)});
  return farthest < opposite * least ? farthest / least : opposite;
}

Sample sample_of(const SampledTriangle &triangle) {
  Sample sample = sample_of_triangle(triangle.position, triangle.normal);
  sample.noise = triangle.noise;
  sample.facet = sample.area;
  return sample;
}

// Returns the square of a third of the triangle's height, which is the spread of an equilateral triangle of that height. The
// normals of a sliver turn across it until its pieces are narrower than that.
static float spread_by_height(float twice_area, float longest_square) {
  return twice_area * twice_area / (9.0f * std::max(longest_square, 1e-30f));
}

// For a sliver, the number of samples is proportional to the length only.
SampleCount count_samples(const SampledTriangle &triangle, const SampleLimit &limit) {
  constexpr float area_of_equilateral = 5.2f; // over its spread
  const vec3 ab = triangle.position[1] - triangle.position[0], ac = triangle.position[2] - triangle.position[0], bc = ac - ab;
  const float squares[3] = {dot(ab, ab), dot(bc, bc), dot(ac, ac)}, twice_area = length(cross(ab, ac));
  const float spread = (squares[0] + squares[1] + squares[2]) * (1.0f / 36.0f);
  const float turning_spread = std::min(spread, spread_by_height(twice_area, std::max({squares[0], squares[1], squares[2]})));
  const float turn_of_part = squared_turn(triangle.normal[0], triangle.normal[1], triangle.normal[2]) /
                             std::max(turning_spread / limit.largest_spread, 1.0f);
  const float largest = limit.at(turn_of_part);
  const float samples = std::max({1.0f, std::sqrt(spread / largest), 0.5f * twice_area / (area_of_equilateral * largest)});
  constexpr float most = 1e9f;
  const auto halved = std::bit_ceil(static_cast<uint32_t>(std::ceil(std::min(samples, most))));
  return {static_cast<float>(halved), spread <= largest};
}

SampleMap flat(vec4 mean, vec4 first, vec4 second) {
  SampleMap map;
  std::copy_n(&mean.x, 4, map.mean);
  std::copy_n(&first.x, 4, map.along[0]);
  std::copy_n(&second.x, 4, map.along[1]);
  return map;
}

SampleMap map_of_triangle(const vec4 (&values)[3]) {
  const vec4 to_next = values[1] - values[0], to_previous = values[2] - values[0];
  return flat((values[0] + values[1] + values[2]) * (1.0f / 3.0f), (to_next + to_previous) * 0.11785113f,
              (to_next - to_previous) * 0.20412415f); // as in sample_of_triangle()
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
};

// Halves pieces at their longest edges, which keeps them compact. Halved needles would make far more pieces than fit side by
// side, so needles are cut crosswise first.
class Divider {
public:
  Divider(const SampledTriangle &triangle, const SampleLimit &limit, const Vicinity &vicinity, bool has_map, SampleList &samples)
      : triangle_(triangle), limit_(limit), vicinity_(vicinity), has_map_(has_map), facet_(sample_of(triangle).area),
        samples_(samples) {
    for (int k = 0; k < 3; ++k)
      whole_.corner[k] = {triangle.position[k], {k == 1 ? 1.0f : 0.0f, k == 2 ? 1.0f : 0.0f}, triangle.normal[k]};
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
    const float beyond = vicinity_.reach + reach;
    return square(position - vicinity_.middle) > beyond * beyond;
  }

  // Divides the part of a needle between two fractions of the way from its tip, corner 0, to its base.
  void cut_needle(const Piece &needle, float begin, float end) {
    const vec3 to_base = edge(needle, 0);
    const float width = end * length(edge(needle, 1)), half = 0.5f * (end - begin) * length(to_base);
    if (is_beyond(needle.corner[0].position + (0.5f * (begin + end)) * to_base, half + width)) return;
    if (2.0f * half > width && half * half > 4.5f * limit_.largest_spread) {
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
    if (!(spread > limit_.at(turn))) return add(piece);
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

  void add(const Piece &piece) {
    vec3 positions[3], normals[3];
    for (int k = 0; k < 3; ++k) {
      positions[k] = piece.corner[k].position;
      normals[k] = piece.corner[k].normal;
    }
    Sample sample = sample_of_triangle(positions, normals);
    sample.noise = triangle_.noise;
    sample.facet = facet_;
    samples_.sample.push_back(flat(sample, false));
    if (!has_map_) return;
    const auto value = [&](int k) {
      const vec2 weights = piece.corner[k].weights;
      const vec4(&of)[3] = triangle_.map;
      return of[0] + (of[1] - of[0]) * weights.x + (of[2] - of[0]) * weights.y;
    };
    samples_.map.push_back(map_of_triangle({value(0), value(1), value(2)}));
  }

  const SampledTriangle &triangle_;
  const SampleLimit &limit_;
  const Vicinity &vicinity_;
  bool has_map_;
  float facet_;
  SampleList &samples_;
  Piece whole_;
};

} // namespace

void divide_triangle(const SampledTriangle &triangle, const SampleLimit &limit, const Vicinity &vicinity, bool has_map,
                     SampleList &samples) {
  Divider(triangle, limit, vicinity, has_map, samples).run();
}

} // namespace paradesc
