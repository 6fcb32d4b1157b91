// Dihedral angles → candidates, by what bends beside them; candidates → lines that do not end in smooth surface.
#include "mesh/creases.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <iterator>
#include <numeric>
#include <span>
#include <utility>

#include "mesh/steady_faces.h"
#include "support/parallel.h"

namespace paradesc {

namespace {

constexpr double degree = pi / 180;
constexpr double least_bend = 20 * degree;
constexpr double least_hard_bend = 50 * degree;
constexpr double both_sides = 3, one_side = 8, own_triangles = 2.5; // times as much as what bends beside an edge
constexpr double reach = 3;                                         // of the width of the narrower triangle
constexpr double flat = 0.3;                                        // of the edge's bend: what the search goes on over
constexpr size_t max_searched = 24;                                 // triangles on one side
constexpr int least_open_line = 16;                                 // edges
constexpr int block_size = 1024;

dvec3 corner_position(const Triangles &triangles, int corner) { return dvec3(triangles.position(corner)); }

// Looks at what bends beside edges.
class Surroundings {
public:
  Surroundings(const Triangles &triangles, const HalfEdges &half_edges, std::span<const vec3> normals)
      : triangles_(triangles), half_edges_(half_edges), normals_(normals) {}

  bool stands_out(int half_edge) const {
    const int twin = half_edges_.twin[half_edge];
    const double bend = bend_of(half_edge);
    if (!(bend >= least_bend)) return false;
    const Side left_side = side_of(half_edge), right_side = side_of(twin);
    const double distance = reach * std::min(left_side.width, right_side.width);
    if (!(distance > 0)) return false;
    // Beside a needle the same bend may come twice, there and back.
    if (left_side.is_needle || right_side.is_needle) return true;
    const double left = most_bent(half_edge, bend, distance, both_sides);
    if (bend >= one_side * left) return true;
    const double least = bend >= both_sides * left ? both_sides : one_side;
    if (bend >= least * most_bent(twin, bend, distance, least)) return true;
    const auto own = [&](int edge) { return most_bent(edge, bend, -1, own_triangles); };
    return bend >= least_hard_bend && bend >= own_triangles * std::max(own(half_edge), own(twin));
  }

private:
  double bend_of(int half_edge) const {
    return std::abs(bend_between(dvec3(normals_[half_edge / 3]), dvec3(normals_[half_edges_.twin[half_edge] / 3]),
                                 along(triangles_, half_edge)));
  }

  // It bends no more than that, which is told without the angle: below a quarter of a turn, that is over its chord by less than a
  // ninth. Beside a needle, whose normal is another face's, it may bend less by far.
  double most_of_bend(int half_edge) const {
    const vec3 left = normals_[half_edge / 3], right = normals_[half_edges_.twin[half_edge] / 3];
    constexpr double over_chord = 0.056; // of the chord's cube: a 24th for small angles
    if (!(glm::dot(left, right) > 0.01f)) return pi;
    const auto chord = static_cast<double>(length(left - right));
    return chord + over_chord * chord * chord * chord;
  }

  // The triangle beside a half-edge; a needle is as wide as what lies behind it.
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

  // An edge beside the line, not before or after it, and at most this far from it.
  static bool is_beside(const Line &line, dvec3 p, dvec3 q, double distance) {
    constexpr double overlap = 0.05;
    const double from = glm::dot(p, line.direction), to = glm::dot(q, line.direction);
    if (std::max(from, to) < overlap * line.length || std::min(from, to) > (1 - overlap) * line.length) return false;
    const dvec3 first = p - from * line.direction, last = q - to * line.direction;
    return std::min(glm::dot(first, first), glm::dot(last, last)) <= distance * distance;
  }

  // The most that an edge beside this one, which bends by own_bend, bends along it, on the side of this half-edge; distance below
  // 0: of its own triangle's edges. Of what is above own_bend, so many times, any will do, and what no factor brings there counts
  // as nothing.
  double most_bent(int half_edge, double own_bend, double distance, double times) const {
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
            const double bend = bend_of(edge);
            is_flat = bend < flat * own_bend;
            most = std::max(most, bend * cosine);
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

int root_of(std::vector<int32_t> &parent, int point) {
  while (parent[point] != point) point = parent[point] = parent[parent[point]];
  return point;
}

std::array<int32_t, 2> ends_of(const HalfEdges &half_edges, int32_t edge) {
  return {half_edges.corner_point[edge], half_edges.corner_point[next_corner(edge)]};
}

// Takes away lines that begin or end within the surface and are short; the marked ones stay.
void remove_short_lines(const HalfEdges &half_edges, const Creases &marked, std::vector<int32_t> &edges) {
  struct Line {
    int edges = 0, ends = 0;
  };
  const auto points = static_cast<size_t>(half_edges.point_count);
  const std::vector<int32_t> line_of = lines_of(half_edges, edges);
  std::vector<int32_t> degree_of(points, 0);
  for (size_t i = 0; i < edges.size(); ++i) {
    checkpoint_at(i);
    for (const int32_t point : ends_of(half_edges, edges[i])) ++degree_of[point];
  }
  std::vector<Line> lines(points);
  for (size_t i = 0; i < edges.size(); ++i) {
    checkpoint_at(i);
    Line &line = lines[line_of[i]];
    ++line.edges;
    for (const int32_t point : ends_of(half_edges, edges[i]))
      line.ends += degree_of[point] == 1 && !half_edges.point_boundary[point];
  }
  size_t kept = 0;
  for (size_t i = 0; i < edges.size(); ++i) {
    checkpoint_at(i);
    const Line &line = lines[line_of[i]];
    if (marked.contains(edges[i]) || line.ends == 0 || line.edges >= least_open_line) edges[kept++] = edges[i];
  }
  edges.resize(kept);
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

std::vector<int32_t> lines_of(const HalfEdges &half_edges, const std::vector<int32_t> &edges) {
  std::vector<int32_t> parent(static_cast<size_t>(half_edges.point_count)), lines;
  std::iota(parent.begin(), parent.end(), 0);
  for (size_t i = 0; i < edges.size(); ++i) {
    checkpoint_at(i);
    const auto [begin, end] = ends_of(half_edges, edges[i]);
    parent[root_of(parent, begin)] = root_of(parent, end);
  }
  lines.reserve(edges.size());
  for (size_t i = 0; i < edges.size(); ++i) {
    checkpoint_at(i);
    lines.push_back(root_of(parent, half_edges.corner_point[edges[i]]));
  }
  return lines;
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

// Those of some triangles that bend, by about the least bend, in order.
static std::vector<int32_t> bent_edges(const HalfEdges &half_edges, std::span<const vec3> normals, int begin, int end) {
  constexpr float least_cosine = 0.93969262f + 1e-3f; // of the least bend
  std::vector<int32_t> bent(static_cast<size_t>(3 * (end - begin)));
  size_t count = 0;
  for (int t = begin; t < end; ++t) {
    const vec3 &own = normals[t];
    for (int32_t edge = 3 * t; edge < 3 * t + 3; ++edge) {
      // Without branches: half of the edges are another's twin, by no rule.
      const int32_t twin = half_edges.twin[edge];
      bent[count] = edge;
      count += static_cast<size_t>((twin > edge) &
                                   (glm::dot(own, normals[static_cast<uint32_t>(std::max(twin, 0)) / 3]) < least_cosine));
    }
  }
  bent.resize(count);
  return bent;
}

Creases find_creases(const Triangles &triangles, const HalfEdges &half_edges, std::span<const vec3> normals, int threads) {
  const Creases marked = marked_creases(triangles, half_edges);
  const Surroundings surroundings(triangles, half_edges, normals);
  std::vector<std::vector<int32_t>> found(static_cast<size_t>(triangles.triangle_count / block_size + 1)); // block by block
  parallel_blocks(triangles.triangle_count, threads, block_size, [&](int begin, int end) {
    std::vector<int32_t> bent = bent_edges(half_edges, normals, begin, end);
    std::erase_if(bent, [&](int32_t edge) { return !surroundings.stands_out(edge); });
    found[begin / block_size] = std::move(bent);
  });
  std::vector<int32_t> edges;
  for (const std::vector<int32_t> &some : found) edges.insert(edges.end(), some.begin(), some.end());
  if (edges.empty()) return marked;
  std::vector<int32_t> all;
  std::ranges::set_union(edges, marked.edges, std::back_inserter(all));
  remove_short_lines(half_edges, marked, all);
  return creases_along(half_edges, std::move(all));
}

} // namespace paradesc
