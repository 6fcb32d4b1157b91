// Lengths → halvings of edges → how many pieces each triangle has → the pieces, triangle by triangle.
#include "mesh/division.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "mesh/coarsening.h"
#include "support/cancel.h"
#include "support/parallel.h"

namespace paradesc {

static constexpr int most_halvings = 10; // of one edge
static constexpr int deepest = 64;       // cuts within one triangle; sides that halve as planned are short long before
static constexpr int block = 256;        // of triangles

static int halvings_of(float length) {
  int halvings = 0;
  for (; length > 1.0f && halvings < most_halvings; length *= 0.5f) ++halvings;
  return halvings;
}

namespace {

constexpr std::array<vec2, 3> places_of_corners = {vec2(0.0f, 0.0f), vec2(1.0f, 0.0f), vec2(0.0f, 1.0f)};

// Lengths within one triangle, capped by what the halvings of its sides allow: a side whose parts stayed long could never be cut
// off. They are 0 if the square of a side overflows a float, because nothing is then known of the triangle.
class Lengths {
public:
  Lengths() = default;
  Lengths(const TriangleMeasure &measure, float coarsening) : measure_(measure) {
    // In a triangle larger than this, floats cannot tell the length of a way that is short compared to it.
    constexpr float most = 65536.0f;
    float in_space = 0.0f, in_image = 0.0f;
    for (int k = 0; k < 3; ++k) {
      const vec2 side = side_of(k);
      const float space = length(measure.space1 * side.x + measure.space2 * side.y);
      const float image = length(measure.image1 * side.x + measure.image2 * side.y);
      counts_space_ = counts_space_ && space < most;
      counts_image_ = counts_image_ && image < most; // false for NaN, too
      in_space = std::max(in_space, space);
      in_image = std::max(in_image, image);
    }
    counts_space_ = counts_space_ || !counts_image_;
    float longest = 0.0f;
    for (int k = 0; k < 3; ++k) longest = std::max(longest, measured(side_of(k)));
    if (!std::isfinite(longest)) return;
    longest_ = longest;
    // If one side is short in space and another in the image, a cut is up to twice as long as any side.
    const float longest_cut = !counts_image_ ? in_space : !counts_space_ ? in_image : std::min(in_space, in_image);
    scale_ = 1.0f / std::max(coarsening, longest_cut / static_cast<float>(1 << most_halvings));
  }
  float longest() const { return longest_; } // side, however coarse
  float of(vec2 way) const { return scale_ > 0.0f ? scale_ * measured(way) : 0.0f; }
  float of_side(int k) const { return of(side_of(k)); }

private:
  static vec2 side_of(int k) { return places_of_corners[(k + 1) % 3] - places_of_corners[k]; }
  float measured(vec2 way) const {
    const float space = length(measure_.space1 * way.x + measure_.space2 * way.y);
    if (!std::isfinite(space)) return std::numeric_limits<float>::infinity();
    if (!counts_image_) return space;
    const float image = length(measure_.image1 * way.x + measure_.image2 * way.y);
    return counts_space_ ? std::min(space, image) : image;
  }

  TriangleMeasure measure_;
  bool counts_image_ = true, counts_space_ = true;
  float longest_ = 0.0f, scale_ = 0.0f;
};

struct Corner {
  vec2 weights;
  int32_t fan, point;
};

// An edge that both adjacent triangles divide alike: a side of the triangle, or a cut through it.
struct Line {
  int32_t parts;
  int32_t point, point_step; // part k ends at point + k * point_step
  int32_t fan;               // and fan + k
  int32_t slot;              // of its parts' half-edges
  bool is_cut;               // both half-edges of each part belong to this triangle
};

// A range of parts of a line, from one part's end to another's.
struct Side {
  int32_t line, from, to;
  float length;
  bool is_short() const { return from - to == 1 || to - from == 1; }
};

using Corners = std::array<Corner, 3>;
using Sides = std::array<Side, 3>; // from each corner to the next

// The arrays that the pieces of a triangle are written to.
struct Target {
  Division &division;
  std::vector<int32_t> &corner_fan;
  std::vector<int32_t> &side_slot; // the half-edge of each part of each side
};

// A cut of a triangle: the side whose middle it starts from, and how often the cut itself is halved.
struct Cut {
  int side, halvings;
  uint8_t stored() const { return static_cast<uint8_t>(side + 4 * halvings); }
  static Cut from(uint8_t stored) { return {stored % 4, stored / 4}; }
};

// The pieces counted so far by all threads.
struct Counted {
  const int64_t most;
  std::atomic<int64_t> pieces{0};
  bool too_many() const { return pieces > most; }
};

// Cuts one triangle after another. With a measure it plans the cuts, until there are too many pieces; without one it follows the
// plan and writes the pieces.
class Cutter {
public:
  Cutter(const HalfEdges &half_edges, const DivisionPlan &plan, const MeasureTriangle &measure, Counted &counted)
      : half_edges_(half_edges), plan_(plan), measure_(&measure), counted_(&counted) {}
  Cutter(const HalfEdges &half_edges, const DivisionPlan &plan, Target &target)
      : half_edges_(half_edges), plan_(plan), target_(&target) {}

  void cut_triangle(int32_t triangle) {
    if (measure_) lengths_ = {(*measure_)(triangle), plan_.coarsening};
    pieces_ = inner_points_ = nodes_ = 0;
    stopped_ = false;
    lines_.clear();
    cuts_.clear();
    cut_slots_.clear();
    triangle_ = triangle;
    Corners corners;
    Sides sides;
    for (int32_t k = 0; k < 3; ++k) {
      const int32_t h = 3 * triangle + k, parts = 1 << plan_.halvings[h];
      corners[k] = {places_of_corners[k], h, half_edges_.corner_point[h]};
      sides[k] = {k, 0, parts, lengths_.of_side(k)};
      lines_.push_back(target_ ? line_of_side(h, parts) : Line{parts, 0, 0, 0, 0, false});
    }
    cut(corners, sides, 0);
    if (counted_) counted_->pieces += pieces_ % pieces_at_once;
  }

  int32_t pieces() const { return pieces_; }
  int32_t inner_points() const { return inner_points_; }
  const std::vector<uint8_t> &cuts() const { return cuts_; }

private:
  static constexpr int32_t pieces_at_once = 1024;

  Line line_of_side(int32_t h, int32_t parts) const {
    const int32_t twin = half_edges_.twin[h], first = twin >= 0 && twin < h ? twin : h;
    const int32_t point = half_edges_.point_count + plan_.edge_begin[first];
    const auto fan = static_cast<int32_t>(target_->division.first_side_fan()) + plan_.side_begin[h] - 1;
    return {parts, first == h ? point - 1 : point + parts - 1, first == h ? 1 : -1, fan, plan_.side_begin[h] + h, false};
  }

  // The next cut; its side is -1 if the triangle is a piece.
  Cut next_cut(const Corners &corner, const Sides &side, int depth) {
    int i = -1;
    for (int k = 0; k < 3; ++k)
      if (!side[k].is_short() && (i < 0 || side[k].length > side[i].length)) i = k;
    if (i < 0) return {-1, 0};
    if (target_) return Cut::from(plan_.cut[plan_.piece_begin[triangle_] + nodes_ - pieces_]);
    const vec2 middle = 0.5f * (corner[i].weights + corner[(i + 1) % 3].weights);
    // Lengths are minima of two measures, and rounded, so they need not shrink with the pieces. Unhalved cuts ensure termination.
    const Cut cut{i, depth < deepest ? halvings_of(lengths_.of(corner[(i + 2) % 3].weights - middle)) : 0};
    cuts_.push_back(cut.stored());
    return cut;
  }

  int32_t add_line(int halvings) {
    const int32_t parts = 1 << halvings;
    Line line{parts, 0, 1, 0, static_cast<int32_t>(cut_slots_.size()), true};
    if (target_) {
      const int32_t inner = plan_.inner_begin[triangle_] + inner_points_ - 1;
      line.point = half_edges_.point_count + plan_.edge_begin.back() + inner;
      line.fan = static_cast<int32_t>(target_->division.first_inner_fan()) + inner;
      cut_slots_.resize(cut_slots_.size() + 2 * static_cast<size_t>(parts), -1);
    }
    inner_points_ += parts - 1;
    lines_.push_back(line);
    return static_cast<int32_t>(lines_.size()) - 1;
  }

  void cut(const Corners &corner, const Sides &side, int depth) {
    if (stopped_) return;
    const auto [i, halvings] = next_cut(corner, side, depth);
    if (i < 0) return add_piece(corner, side);
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const Side halved = side[i];
    const int32_t half = (halved.from + halved.to) / 2;
    const Corner middle = corner_on(lines_[halved.line], half, 0.5f * (corner[i].weights + corner[j].weights));
    const int32_t line = add_line(halvings), parts = lines_[line].parts;
    const float across = lengths_.of(corner[k].weights - middle.weights), along = 0.5f * halved.length;
    const int32_t node = nodes_++;
    cut({corner[i], middle, corner[k]}, {Side{halved.line, halved.from, half, along}, Side{line, 0, parts, across}, side[k]},
        depth + 1);
    if (target_) tree()[node] = 4 * nodes_ + i;
    cut({middle, corner[j], corner[k]}, {Side{halved.line, half, halved.to, along}, side[j], Side{line, parts, 0, across}},
        depth + 1);
  }

  Corner corner_on(const Line &line, int32_t part, vec2 weights) const {
    const Corner corner{weights, line.fan + part, line.point + part * line.point_step};
    if (target_) target_->division.fan_weights[corner.fan] = weights;
    return corner;
  }

  int32_t *tree() const { return &target_->division.tree[2 * static_cast<size_t>(plan_.piece_begin[triangle_])]; }

  void add_piece(const Corners &corner, const Sides &side) {
    if (++pieces_ % pieces_at_once == 0) {
      checkpoint();
      if (counted_) counted_->pieces += pieces_at_once;
      stopped_ = counted_ && counted_->too_many();
    }
    if (!target_) return;
    const int32_t piece = plan_.piece_begin[triangle_] + pieces_ - 1;
    tree()[nodes_++] = -pieces_;
    for (int32_t k = 0; k < 3; ++k) {
      const int32_t h = 3 * piece + k;
      target_->division.half_edges.corner_point[h] = corner[k].point;
      target_->corner_fan[h] = corner[k].fan;
      link(side[k], h);
    }
  }

  void link(const Side &side, int32_t h) {
    const Line &line = lines_[side.line];
    const int32_t part = std::min(side.from, side.to);
    if (!line.is_cut) {
      target_->side_slot[line.slot + part] = h;
      return;
    }
    const size_t slot = static_cast<size_t>(line.slot) + 2 * static_cast<size_t>(part), own = side.from < side.to ? 0 : 1;
    cut_slots_[slot + own] = h;
    const int32_t other = cut_slots_[slot + 1 - own];
    if (other < 0) return;
    target_->division.half_edges.twin[h] = other;
    target_->division.half_edges.twin[other] = h;
  }

  const HalfEdges &half_edges_;
  const DivisionPlan &plan_;
  const MeasureTriangle *measure_ = nullptr;
  Counted *counted_ = nullptr;
  Target *target_ = nullptr;
  bool stopped_ = false; // stopped in mid-triangle; some of its pieces are missing
  Lengths lengths_;      // all 0 without a measure: the plan then decides
  int32_t triangle_ = -1, pieces_ = 0, inner_points_ = 0, nodes_ = 0;
  std::vector<Line> lines_;        // the sides, then the cuts
  std::vector<uint8_t> cuts_;      // chosen so far, in order
  std::vector<int32_t> cut_slots_; // of each part of a cut the half-edges along it and against it
};

} // namespace

// ---- Counting

static void count_halvings(const HalfEdges &half_edges, const MeasureTriangle &measure, int threads, DivisionPlan &plan) {
  std::vector<float> length(half_edges.twin.size());
  const auto triangles = static_cast<int>(length.size() / 3);
  parallel_blocks(triangles, threads, block, [&](int begin, int end) {
    for (int32_t triangle = begin; triangle < end; ++triangle) {
      if (half_edges.corner_point[3 * triangle] < 0) continue;
      const Lengths lengths(measure(triangle), plan.coarsening);
      for (int k = 0; k < 3; ++k) length[3 * triangle + k] = lengths.of_side(k);
    }
  });
  plan.halvings.assign(length.size(), 0);
  parallel_blocks(triangles, threads, 16 * block, [&](int begin, int end) {
    for (int32_t h = 3 * begin; h < 3 * end; ++h) {
      const int32_t twin = half_edges.twin[h];
      plan.halvings[h] = static_cast<uint8_t>(halvings_of(twin < 0 ? length[h] : std::max(length[h], length[twin])));
    }
  });
}

// Returns nothing as soon as there are more than `most` pieces.
static std::optional<int64_t> count_pieces(const HalfEdges &half_edges, const MeasureTriangle &measure, int64_t most, int threads,
                                           DivisionPlan &plan) {
  const size_t triangles = plan.halvings.size() / 3;
  plan.piece_begin.assign(triangles + 1, 0);
  plan.inner_begin.assign(triangles + 1, 0);
  Counted counted{most};
  std::vector<std::vector<uint8_t>> cuts(triangles / block + 1); // of each block
  parallel_blocks(static_cast<int>(triangles), threads, block, [&](int begin, int end) {
    Cutter cutter(half_edges, plan, measure, counted);
    std::vector<uint8_t> &of_block = cuts[begin / block];
    for (int32_t triangle = begin; triangle < end && !counted.too_many(); ++triangle) {
      if (half_edges.corner_point[3 * triangle] < 0) continue;
      cutter.cut_triangle(triangle);
      plan.piece_begin[triangle + 1] = cutter.pieces();
      plan.inner_begin[triangle + 1] = cutter.inner_points();
      of_block.insert(of_block.end(), cutter.cuts().begin(), cutter.cuts().end());
      of_block.push_back(0);
    }
  });
  if (counted.too_many()) return std::nullopt;
  for (const std::vector<uint8_t> &part : cuts) plan.cut.insert(plan.cut.end(), part.begin(), part.end());
  return counted.pieces;
}

static float longest_side(const HalfEdges &half_edges, const MeasureTriangle &measure) {
  float longest = 0.0f;
  for (int32_t triangle = 0; triangle < static_cast<int32_t>(half_edges.twin.size() / 3); ++triangle) {
    checkpoint_at(triangle);
    if (half_edges.corner_point[3 * triangle] >= 0) longest = std::max(longest, Lengths(measure(triangle), 1.0f).longest());
  }
  return longest;
}

static void place_points(const HalfEdges &half_edges, DivisionPlan &plan) {
  const auto add_up = [](std::vector<int32_t> &counts) { std::partial_sum(counts.begin(), counts.end(), counts.begin()); };
  plan.side_begin.assign(plan.halvings.size() + 1, 0);
  plan.edge_begin.assign(plan.halvings.size() + 1, 0);
  for (size_t h = 0; h < plan.halvings.size(); ++h) {
    checkpoint_at(h);
    const int32_t twin = half_edges.twin[h], between = (1 << plan.halvings[h]) - 1;
    plan.side_begin[h + 1] = between;
    plan.edge_begin[h + 1] = twin >= 0 && twin < static_cast<int32_t>(h) ? 0 : between;
  }
  for (auto *begins : {&plan.piece_begin, &plan.inner_begin, &plan.side_begin, &plan.edge_begin}) add_up(*begins);
}

DivisionPlan plan_division(const HalfEdges &half_edges, const MeasureTriangle &measure, int32_t most_pieces, int threads) {
  const int64_t most = std::max<int64_t>(most_pieces, static_cast<int64_t>(half_edges.twin.size() / 3));
  DivisionPlan found;
  const auto count = [&](int steps) {
    DivisionPlan plan;
    plan.coarsening = coarsening_after(steps);
    count_halvings(half_edges, measure, threads, plan);
    const std::optional<int64_t> pieces = count_pieces(half_edges, measure, most, threads, plan);
    if (pieces) found = std::move(plan);
    return pieces;
  };
  if (!count(0)) fewest_steps(most, steps_until_short(longest_side(half_edges, measure)), count);
  place_points(half_edges, found);
  return found;
}

// ---- The pieces

static void link_sides(const HalfEdges &half_edges, const std::vector<int32_t> &side_slot, Division &division) {
  const DivisionPlan &plan = division.plan;
  std::vector<int32_t> &linked = division.half_edges.twin;
  for (int32_t h = 0; h < static_cast<int32_t>(plan.halvings.size()); ++h) {
    const int32_t twin = half_edges.twin[h], parts = 1 << plan.halvings[h];
    checkpoint_at(h);
    if (twin <= h) continue;
    for (int32_t part = 0; part < parts; ++part) {
      const int32_t a = side_slot[plan.side_begin[h] + h + part], b = side_slot[plan.side_begin[twin] + twin + parts - 1 - part];
      linked[a] = b;
      linked[b] = a;
    }
  }
}

// Each point has exactly one fan of pieces, just as each point of the mesh has one fan of triangles.
static void describe_points(HalfEdges &pieces) {
  const auto points = static_cast<size_t>(pieces.point_count);
  pieces.point_vertex.resize(points);
  std::iota(pieces.point_vertex.begin(), pieces.point_vertex.end(), 0);
  pieces.vertex_point = pieces.point_vertex;
  pieces.point_half_edge.assign(points, -1);
  pieces.point_boundary.assign(points, 0);
  const auto count = static_cast<int32_t>(pieces.twin.size());
  for (int32_t h = 0; h < count; ++h) {
    checkpoint_at(h);
    if (int32_t &first = pieces.point_half_edge[pieces.corner_point[h]]; first < 0) first = h;
  }
  for (int32_t h = 0; h < count; ++h) {
    checkpoint_at(h);
    if (pieces.twin[h] >= 0) continue;
    pieces.point_half_edge[pieces.corner_point[h]] = h;
    pieces.point_boundary[pieces.corner_point[h]] = pieces.point_boundary[pieces.corner_point[next_corner(h)]] = 1;
    ++pieces.boundary_edges;
  }
}

Division divide(const HalfEdges &half_edges, const DivisionPlan &plan, int threads) {
  Division division;
  division.plan = plan;
  const size_t triangles = plan.halvings.size() / 3, corners = 3 * static_cast<size_t>(plan.pieces());
  HalfEdges &pieces = division.half_edges;
  pieces.point_count = half_edges.point_count + plan.new_points();
  pieces.corner_point.assign(corners, -1);
  checkpoint(); // allocating this much memory takes noticeable time
  pieces.twin.assign(corners, -1);
  checkpoint();
  pieces.triangle_piece.assign(corners / 3, -1);
  pieces.components = half_edges.components;
  division.fan_weights.resize(division.first_inner_fan() + static_cast<size_t>(plan.inner_begin.back()));
  for (size_t h = 0; h < plan.halvings.size(); ++h) division.fan_weights[h] = places_of_corners[h % 3];
  checkpoint();
  division.tree.assign(2 * corners / 3, 0);
  checkpoint();
  std::vector<int32_t> corner_fan(corners, -1), side_slot(plan.halvings.size() + static_cast<size_t>(plan.side_points()), -1);
  parallel_blocks(static_cast<int>(triangles), threads, block, [&](int begin, int end) {
    Target target{division, corner_fan, side_slot};
    Cutter cutter(half_edges, plan, target);
    for (int32_t triangle = begin; triangle < end; ++triangle) {
      if (half_edges.corner_point[3 * triangle] < 0) continue;
      cutter.cut_triangle(triangle);
      std::fill(pieces.triangle_piece.begin() + plan.piece_begin[triangle],
                pieces.triangle_piece.begin() + plan.piece_begin[triangle + 1], half_edges.triangle_piece[triangle]);
    }
  });
  link_sides(half_edges, side_slot, division);
  checkpoint();
  describe_points(pieces);
  division.corner_fan = std::make_shared<const std::vector<int32_t>>(std::move(corner_fan));
  return division;
}

// Corners p, q, s start at the halved side; the half of q lies beyond the side's middle.
TrianglePlace Division::at(TrianglePlace place) const {
  const int32_t first = plan.piece_begin[place.triangle];
  const int32_t *const nodes = &tree[2 * static_cast<size_t>(first)];
  vec3 weights(1.0f - place.weights.x - place.weights.y, place.weights);
  int32_t node = 0;
  while (nodes[node] >= 0) {
    const int i = nodes[node] % 4;
    const float p = weights[i], q = weights[(i + 1) % 3], s = weights[(i + 2) % 3];
    weights = p >= q ? vec3(p - q, 2.0f * q, s) : vec3(2.0f * p, q - p, s);
    node = p >= q ? node + 1 : nodes[node] / 4;
  }
  return {first - nodes[node] - 1, vec2(weights.y, weights.z)};
}

} // namespace paradesc
