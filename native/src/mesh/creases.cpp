// Dihedral angles → candidates that bend more than their surroundings → lines that do not end in smooth surface.
#include "mesh/creases.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <iterator>
#include <span>
#include <utility>

#include "kernel/limits.h"
#include "mesh/crease_lines.h"
#include "mesh/steady_faces.h"
#include "support/parallel.h"
#include "support/union_find.h"

namespace paradesc {

namespace {

constexpr double degree = pi / 180;
constexpr double least_bend = 19.9 * degree; // 20 degrees, with a margin for rounded positions
constexpr double least_hard_bend = 50 * degree;
constexpr double least_corner_bend = 60 * degree, most_corner_bend = 150 * degree; // beyond this the surface is folded
constexpr double both_sides = 3, one_side = 8, own_triangles = 2.5;                // relative to the bends beside an edge
constexpr double reach = 3;                                                        // relative to the narrower triangle's width
constexpr double flat = 0.3;                  // relative to the edge's bend; the search continues across edges below it
constexpr size_t max_searched = 24;           // triangles on one side
constexpr double least_gap_bend = 0.5;        // relative to the bend of the line's end
constexpr double least_straight = 0.8;        // cosine of the turn along a line in a gap
constexpr double line_reach = 4;              // in mean edges of a line
constexpr double polyhedron = 8, corners = 2; // relative to all other edges
constexpr double least_net = 0.75;            // relative to a line's bends
constexpr double net_for_purity = 0.15, least_net_of_all = 0.2;
constexpr double beside = 1.0 / 3, least_purity_beside = 1; // of the reach; of a short line there
constexpr int least_line = 16;                              // edges of a line in any other surface
constexpr int block_size = 1024;

dvec3 corner_position(const Triangles &triangles, int corner) { return dvec3(triangles.position(corner)); }

double bend_of(const Triangles &triangles, const HalfEdges &half_edges, std::span<const vec3> normals, int half_edge) {
  return bend_between(dvec3(normals[half_edge / 3]), dvec3(normals[half_edges.twin[half_edge] / 3]), along(triangles, half_edge));
}

// Compares an edge with the bends beside it.
class Surroundings {
public:
  Surroundings(const Triangles &triangles, const HalfEdges &half_edges, std::span<const vec3> normals)
      : triangles_(triangles), half_edges_(half_edges), normals_(normals) {}

  bool stands_out(int half_edge) const {
    const int twin = half_edges_.twin[half_edge];
    const double bend = bend_of(half_edge), size = std::abs(bend);
    if (!(size >= least_bend)) return false;
    const Side left_side = side_of(half_edge), right_side = side_of(twin);
    const double distance = reach * std::min(left_side.width, right_side.width);
    if (!(distance > 0)) return false;
    // Beside a needle, the same bend may occur twice, once in each direction.
    if (left_side.is_needle || right_side.is_needle) return true;
    const double left = most_bent(half_edge, bend, distance, both_sides), right = most_bent(twin, bend, distance, both_sides);
    if (size >= both_sides * std::max(left, right)) return true;
    const auto is_bevel = [&](double most, int other) { // most: of the flat side; other: must not take the bend back
      return size >= one_side * most && size >= both_sides * most_bent(other, bend, distance, both_sides, Which::back);
    };
    if (is_bevel(left, twin) || is_bevel(right, half_edge)) return true;
    return size >= least_hard_bend && size >= own_triangles * most_of_own(half_edge, bend, Which::all);
  }

  // Returns whether an edge that does not stand out is hidden only by edges that may meet it at a solid's corner, at any angle.
  bool may_meet_others(int half_edge) const {
    const double bend = bend_of(half_edge);
    return is_corner(bend) && std::abs(bend) >= own_triangles * most_of_own(half_edge, bend, Which::no_corner);
  }

private:
  enum class Which { all, back, no_corner }; // back: only edges that bend the other way

  static bool is_corner(double bend) { return std::abs(bend) >= least_corner_bend && std::abs(bend) <= most_corner_bend; }

  double most_of_own(int half_edge, double bend, Which which) const {
    const auto own = [&](int edge) { return most_bent(edge, bend, -1, own_triangles, which); };
    return std::max(own(half_edge), own(half_edges_.twin[half_edge]));
  }

  double bend_of(int half_edge) const { return paradesc::bend_of(triangles_, half_edges_, normals_, half_edge); }

  // Returns an upper bound of the bend without computing the angle. Below a quarter turn, an angle exceeds its chord by less than
  // a ninth. Beside a needle, whose normal is that of another face, the edge may bend far less.
  double most_of_bend(int half_edge) const {
    const vec3 left = normals_[half_edge / 3], right = normals_[half_edges_.twin[half_edge] / 3];
    constexpr double over_chord = 0.056; // relative to the chord's cube; a 24th for small angles
    if (!(glm::dot(left, right) > 0.01f)) return pi;
    const auto chord = static_cast<double>(length(left - right));
    return chord + over_chord * chord * chord * chord;
  }

  // The triangle beside a half-edge. A needle is as wide as the triangle behind it.
  struct Side {
    double width;
    bool is_needle;
  };
  Side side_of(int half_edge) const {
    Face face(triangles_, half_edge / 3);
    const bool is_needle = face.is_needle(face.product());
    const dvec3 begin = corner_position(triangles_, half_edge), way = along(triangles_, half_edge);
    const double span = glm::length(way);
    if (!(span > 0)) return {0, is_needle};
    if (is_needle) face = Face(triangles_, steady_face(triangles_, half_edges_, half_edge / 3));
    double most = 0;
    for (const dvec3 &corner : {face.a, face.b, face.c}) most = std::max(most, glm::length(glm::cross(way, corner - begin)));
    return {most / span, is_needle};
  }

  struct Line {
    dvec3 begin, direction;
    double length;
  };

  // Returns whether an edge is beside the line, not before or after it, and at most this far away.
  static bool is_beside(const Line &line, dvec3 p, dvec3 q, double distance) {
    constexpr double overlap = 0.05;
    const double from = glm::dot(p, line.direction), to = glm::dot(q, line.direction);
    if (std::max(from, to) < overlap * line.length || std::min(from, to) > (1 - overlap) * line.length) return false;
    const dvec3 first = p - from * line.direction, last = q - to * line.direction;
    return std::min(glm::dot(first, first), glm::dot(last, last)) <= distance * distance;
  }

  // Returns the largest bend along this edge among the edges beside it, on the side of this half-edge. bend_here: the bend of the
  // edge itself. If distance is negative, only the edges of its own triangle count. The result is only exact where it matters:
  // any value that exceeds the own bend after multiplication by `times` will do, and values that are too small for every factor
  // are skipped.
  double most_bent(int half_edge, double bend_here, double distance, double times, Which which = Which::all) const {
    const double own_bend = std::abs(bend_here);
    const dvec3 begin = corner_position(triangles_, half_edge),
                along = corner_position(triangles_, next_corner(half_edge)) - begin;
    const double span = glm::length(along);
    const Line line{begin, along / span, span};
    const int other_side = half_edges_.twin[half_edge] / 3;
    std::array<int, max_searched> faces{half_edge / 3};
    size_t count = 1;
    double most = 0;
    for (size_t k = 0; k < count; ++k)
      for (int i = 0; i < 3; ++i) {
        const int edge = 3 * faces[k] + i, twin = half_edges_.twin[edge];
        if (edge == half_edge || twin < 0 || twin / 3 == other_side) continue;
        const dvec3 p = corner_position(triangles_, edge) - begin, q = corner_position(triangles_, next_corner(edge)) - begin;
        if (k > 0 && !is_beside(line, p, q, distance)) continue;
        const double high = most_of_bend(edge), counts = std::max(most, own_bend / one_side);
        bool is_flat = high < flat * own_bend;
        if (high > counts || !is_flat) {
          const double length = glm::length(q - p), cosine = length > 0 ? std::abs(glm::dot(q - p, line.direction)) / length : 0;
          if (high * cosine > counts || !is_flat) {
            const double signed_bend = bend_of(edge), bend = std::abs(signed_bend);
            is_flat = bend < flat * own_bend;
            const bool is_back = (signed_bend < 0) != (bend_here < 0);
            const bool is_left_out = which == Which::back ? !is_back : which == Which::no_corner && !is_back && is_corner(bend);
            if (!is_left_out) most = std::max(most, bend * cosine);
            if (times * most > own_bend) return most;
          }
        }
        if (distance > 0 && count < max_searched && is_flat &&
            std::find(faces.begin(), faces.begin() + count, twin / 3) == faces.begin() + count)
          faces[count++] = twin / 3;
      }
    return most;
  }

  const Triangles &triangles_;
  const HalfEdges &half_edges_;
  std::span<const vec3> normals_; // of steady faces
};

// Finds the edges that noise hides in a line. From a line's end, the next edge goes on straight and bends the same way, and it
// leads to a line again.
class Gaps {
public:
  Gaps(const Triangles &triangles, const HalfEdges &half_edges, std::span<const vec3> normals, const std::vector<int32_t> &edges)
      : triangles_(triangles), half_edges_(half_edges), normals_(normals),
        edges_at_(static_cast<size_t>(half_edges.point_count)) {
    for (const int32_t edge : edges)
      for (const int32_t h : {edge, half_edges_.twin[edge]}) ++edges_at_[half_edges_.corner_point[h]];
  }

  // edge: from a line's end into the line. Returns -1 if nothing closes the gap behind that end.
  int32_t closing(int32_t edge) const {
    if (edges_at(edge) != 1 || edges_at(next_corner(edge)) < 2) return -1;
    const int32_t next = straight_on(edge);
    return next >= 0 && edges_at(next_corner(next)) > 0 ? std::min(next, half_edges_.twin[next]) : -1;
  }

private:
  int32_t edges_at(int32_t corner) const { return edges_at_[half_edges_.corner_point[corner]]; }

  double bend_of(int32_t edge) const { return paradesc::bend_of(triangles_, half_edges_, normals_, edge); }

  // Finds the half-edge from the same point that continues the line best, or -1.
  int32_t straight_on(int32_t back) const {
    const dvec3 way = -glm::normalize(along(triangles_, back));
    int32_t best = -1;
    double most = 0;
    for (int32_t h = half_edges_.twin[previous_corner(back)]; h >= 0 && h != back; h = half_edges_.twin[previous_corner(h)]) {
      if (half_edges_.twin[h] < 0) return -1;
      const double bend = bend_of(h) / bend_of(back), straight = glm::dot(glm::normalize(along(triangles_, h)), way);
      if (bend < least_gap_bend || straight < least_straight || !(bend * straight > most)) continue;
      most = bend * straight;
      best = h;
    }
    return best;
  }

  const Triangles &triangles_;
  const HalfEdges &half_edges_;
  std::span<const vec3> normals_;
  std::vector<int32_t> edges_at_; // (points)
};

// Returns whether a line continues and its bends are not taken back beside it: see find_creases. More of them must remain if
// other edges bend more. Most lines in noise are short, and other edges bend more than they do right beside them.
bool goes_on(const EdgeLine &line, const TurningWithin &turning_within, double least_purity) {
  const bool is_short = line.edges < least_line && line.ends > 0;
  if (is_short && turning_within(beside).purity() < least_purity_beside) return false;
  const Turning turning = turning_within(1);
  const double purity = turning.purity(), least = std::max(least_net_of_all, least_net - net_for_purity * purity);
  return turning.net >= least * turning.edges && purity >= (is_short ? polyhedron : least_purity);
}

bool goes_on_anywhere(const EdgeLine &line, const TurningWithin &turning_within) { return goes_on(line, turning_within, 0); }

bool goes_on_at_corners(const EdgeLine &line, const TurningWithin &turning_within) {
  return goes_on(line, turning_within, corners);
}

} // namespace

Creases creases_along(const HalfEdges &half_edges, std::vector<int32_t> edges) {
  Creases creases;
  if (edges.empty()) return creases;
  creases.half_edge.assign(half_edges.twin.size(), 0);
  for (size_t i = 0; i < edges.size(); ++i) {
    checkpoint_at(i);
    creases.half_edge[edges[i]] = creases.half_edge[half_edges.twin[edges[i]]] = 1;
  }
  creases.edges = std::move(edges);
  return creases;
}

Creases marked_creases(const Triangles &triangles, const HalfEdges &half_edges) {
  const std::vector<uint8_t> &sharp = triangles.half_edge_sharp;
  std::vector<int32_t> edges;
  if (sharp.empty() || !std::memchr(sharp.data(), 1, sharp.size())) return {};
  for (size_t h = 0; h < sharp.size(); ++h) {
    checkpoint_at(h);
    const auto edge = static_cast<int32_t>(h);
    if (const int32_t twin = half_edges.twin[h]; twin > edge && sharp[h] && sharp[twin]) edges.push_back(edge);
  }
  return creases_along(half_edges, std::move(edges));
}

// Returns the edges of some triangles that bend by about the least bend, in order.
static std::vector<int32_t> bent_edges(const HalfEdges &half_edges, std::span<const vec3> normals, int begin, int end) {
  constexpr float least_cosine = 0.93969262f + 1e-3f; // of the least bend
  std::vector<int32_t> bent(static_cast<size_t>(3 * (end - begin)));
  size_t count = 0;
  for (int t = begin; t < end; ++t) {
    const vec3 &own = normals[t];
    for (int32_t edge = 3 * t; edge < 3 * t + 3; ++edge) {
      // This has no branches, since which half-edge of a pair comes first is unpredictable.
      const int32_t twin = half_edges.twin[edge];
      bent[count] = edge;
      count += static_cast<size_t>((twin > edge) &
                                   (glm::dot(own, normals[static_cast<uint32_t>(std::max(twin, 0)) / 3]) < least_cosine));
    }
  }
  bent.resize(count);
  return bent;
}

static std::vector<int32_t> union_of(const std::vector<int32_t> &a, const std::vector<int32_t> &b) {
  std::vector<int32_t> all;
  std::ranges::set_union(a, b, std::back_inserter(all));
  return all;
}

// Returns the edges of agreed lines together with the kept creases. lines: the lines of `edges`, which ascend.
static Creases creases_of_lines(const HalfEdges &half_edges, const std::vector<int32_t> &edges, const EdgeLines &lines,
                                const Creases &kept) {
  std::vector<int32_t> agreed;
  for (size_t i = 0; i < edges.size(); ++i) {
    checkpoint_at(i);
    if (lines.line[lines.line_of[i]].is_agreed()) agreed.push_back(edges[i]);
  }
  return creases_along(half_edges, union_of(agreed, kept.edges));
}

// Judges the lines of the edges, which ascend, and returns the agreed ones together with the kept creases.
static Creases with_lines(const Triangles &triangles, const HalfEdges &half_edges, std::span<const vec3> normals,
                          const std::vector<int32_t> &edges, const Creases &kept, JudgePlace judge, int threads) {
  const Creases chosen = creases_along(half_edges, union_of(edges, kept.edges));
  const EdgeLines lines = judge_lines(triangles, half_edges, edges, chosen.half_edge, normals, 0, line_reach, judge, threads);
  return creases_of_lines(half_edges, edges, lines, kept);
}

// Returns the hidden edges and all edges connected to one. All other lines are judged already.
static std::vector<int32_t> joined_by(const HalfEdges &half_edges, const std::vector<int32_t> &edges,
                                      const std::vector<int32_t> &hidden) {
  const auto points = static_cast<size_t>(half_edges.point_count);
  UnionFind sets(points);
  const auto root_of = [&](int32_t edge) { return sets.root_of(half_edges.corner_point[edge]); };
  for (const std::vector<int32_t> *const some : {&edges, &hidden})
    for (const int32_t edge : *some) sets.join(half_edges.corner_point[next_corner(edge)], half_edges.corner_point[edge]);
  std::vector<uint8_t> has_hidden(points, 0);
  for (const int32_t edge : hidden) has_hidden[root_of(edge)] = 1;
  std::vector<int32_t> joined = union_of(edges, hidden);
  std::erase_if(joined, [&](int32_t edge) { return has_hidden[root_of(edge)] == 0; });
  return joined;
}

Creases find_creases(const Triangles &triangles, const HalfEdges &half_edges, std::span<const vec3> normals, int threads) {
  const Creases marked = marked_creases(triangles, half_edges);
  const Surroundings surroundings(triangles, half_edges, normals);
  struct Found {
    std::vector<int32_t> edges, hidden; // hidden: may meet others at corners
  };
  std::vector<Found> found(static_cast<size_t>(triangles.triangle_count / block_size + 1)); // block by block
  parallel_blocks(triangles.triangle_count, threads, block_size, [&](int begin, int end) {
    Found &here = found[begin / block_size];
    for (const int32_t edge : bent_edges(half_edges, normals, begin, end))
      if (surroundings.stands_out(edge))
        here.edges.push_back(edge);
      else if (surroundings.may_meet_others(edge))
        here.hidden.push_back(edge);
  });
  std::vector<int32_t> edges, hidden;
  for (const Found &some : found) {
    edges.insert(edges.end(), some.edges.begin(), some.edges.end());
    hidden.insert(hidden.end(), some.hidden.begin(), some.hidden.end());
  }
  if (edges.empty() && hidden.empty()) return marked;
  const Gaps gaps(triangles, half_edges, normals, edges);
  for (size_t i = 0, count = edges.size(); i < count; ++i) {
    checkpoint_at(i);
    for (const int32_t end : {edges[i], half_edges.twin[edges[i]]})
      if (const int32_t gap = gaps.closing(end); gap >= 0) edges.push_back(gap);
  }
  std::ranges::sort(edges);
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  edges = union_of(edges, marked.edges);
  const Creases kept = with_lines(triangles, half_edges, normals, edges, marked, goes_on_anywhere, threads);
  if (hidden.empty()) return kept;
  return with_lines(triangles, half_edges, normals, joined_by(half_edges, edges, hidden), kept, goes_on_at_corners, threads);
}

// Returns whether the other edges turn the normals less than the creases do, or turn them by noise alone. Edges that are as sharp
// are no noise: the creases are single steps among others, as on a surface of voxels.
static bool stands_out(const EdgeLine &, const TurningWithin &turning_within) {
  constexpr double most_others = 0.7, as_sharp = 0.85;
  const Turning turning = turning_within(1);
  if (turning.edges >= turning.others) return true;
  return turning.others_sharpness < as_sharp * turning.sharpness &&
         turning.others_net2 <= most_others * most_others * turning.edges * turning.edges;
}

Creases creases_that_count(const Triangles &triangles, const HalfEdges &half_edges, const Creases &creases,
                           std::span<const vec3> normals, double radius, int threads) {
  if (creases.edges.empty()) return {};
  const Creases marked = marked_creases(triangles, half_edges);
  if (creases == marked) return creases;
  const EdgeLines lines = judge_lines(triangles, half_edges, creases.edges, creases.half_edge, normals, CREASE_REACH * radius, 0,
                                      stands_out, threads);
  return creases_of_lines(half_edges, creases.edges, lines, marked);
}

} // namespace paradesc
