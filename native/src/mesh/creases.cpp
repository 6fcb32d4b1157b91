// Dihedral angles → candidates, by what bends beside them; candidates → lines that do not end in smooth surface.
#include "mesh/creases.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numeric>

#include "support/angle.h"
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

// The corners of a face, read once.
struct Face {
  dvec3 a, b, c;

  Face(const Triangles &triangles, int face)
      : a(corner_position(triangles, 3 * face)), b(corner_position(triangles, 3 * face + 1)),
        c(corner_position(triangles, 3 * face + 2)) {}
  dvec3 product() const { return glm::cross(b - a, c - a); }
  // Lower than what rounds positions, by far: its normal says nothing.
  bool is_needle(dvec3 product) const {
    const auto square = [](dvec3 v) { return glm::dot(v, v); };
    const double longest2 = std::max({square(b - a), square(c - b), square(a - c)});
    const dvec3 most = glm::max(glm::max(glm::abs(a), glm::abs(b)), glm::abs(c));
    const double largest = std::max({most.x, most.y, most.z});
    return square(product) < ROUNDING * ROUNDING * largest * largest * longest2;
  }
};

bool is_needle(const Triangles &triangles, int index) {
  const Face face(triangles, index);
  return face.is_needle(face.product());
}

dvec3 along(const Triangles &triangles, int half_edge) {
  return corner_position(triangles, next_corner(half_edge)) - corner_position(triangles, half_edge);
}

// Other than this one.
int longest_edge(const Triangles &triangles, int face, int other) {
  int longest = -1;
  double most = -1;
  for (int corner = 3 * face; corner < 3 * face + 3; ++corner) {
    const dvec3 edge = corner_position(triangles, next_corner(corner)) - corner_position(triangles, corner);
    if (corner != other && glm::dot(edge, edge) > most) {
      most = glm::dot(edge, edge);
      longest = corner;
    }
  }
  return longest;
}

// Looks at what bends beside edges.
class Surroundings {
public:
  Surroundings(const Triangles &triangles, const HalfEdges &half_edges, const std::vector<vec3> &normals)
      : triangles_(triangles), half_edges_(half_edges), normals_(normals) {}

  bool stands_out(int half_edge) const {
    const int twin = half_edges_.twin[half_edge];
    const double bend = bend_of(half_edge), distance = reach * std::min(width(half_edge), width(twin));
    if (!(bend >= least_bend) || !(distance > 0)) return false;
    // Beside a needle the same bend may come twice, there and back.
    if (is_needle(triangles_, half_edge / 3) || is_needle(triangles_, twin / 3)) return true;
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

  // It bends no more than that, which is told without the angle.
  bool bends_at_most(int half_edge, double angle) const {
    const vec3 left = normals_[half_edge / 3], right = normals_[half_edges_.twin[half_edge] / 3];
    constexpr double over_chord = 1.12; // more than an angle below a quarter of a turn is over its chord
    return glm::dot(left, right) > 0.01f && over_chord * static_cast<double>(length(left - right)) <= angle;
  }

  // Of the triangle, across the edge.
  double width(int half_edge) const {
    const dvec3 a = corner_position(triangles_, half_edge), along = corner_position(triangles_, next_corner(half_edge)) - a;
    const double span = glm::length(along);
    if (!(span > 0)) return 0;
    const int face = steady_face(triangles_, half_edges_, half_edge / 3);
    double most = 0;
    for (int corner = 3 * face; corner < 3 * face + 3; ++corner)
      most = std::max(most, glm::length(glm::cross(along, corner_position(triangles_, corner) - a)) / span);
    return most;
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
    return std::min(glm::length(p - from * line.direction), glm::length(q - to * line.direction)) <= distance;
  }

  // The most that an edge beside this one, which bends by own_bend, bends along it, on the side of this half-edge; distance below
  // 0: of its own triangle's edges. Of what is above own_bend, so many times, any will do.
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
        bool goes_on = distance > 0 && count < max_searched;
        if (!bends_at_most(edge, std::min(most, flat * own_bend))) {
          const double length = glm::length(q - p), bend = bend_of(edge);
          if (length > 0) most = std::max(most, bend * std::abs(glm::dot(q - p, line.direction)) / length);
          if (times * most > own_bend) return most;
          goes_on = goes_on && bend < flat * own_bend;
        }
        if (goes_on && std::find(faces.begin(), faces.begin() + count, twin / 3) == faces.begin() + count)
          faces[count++] = twin / 3;
      }
    return most;
  }

  const Triangles &triangles_;
  const HalfEdges &half_edges_;
  const std::vector<vec3> &normals_; // of steady faces
};

template <class Visit> void for_each_edge(const HalfEdges &half_edges, const Creases &creases, const Visit &visit) {
  for (size_t h = 0; h < creases.half_edge.size(); ++h) {
    checkpoint_at(h);
    if (creases.half_edge[h] && half_edges.twin[h] > static_cast<int>(h))
      visit(h, half_edges.corner_point[h], half_edges.corner_point[static_cast<size_t>(next_corner(static_cast<int>(h)))]);
  }
}

int root_of(std::vector<int32_t> &parent, int point) {
  while (parent[point] != point) point = parent[point] = parent[parent[point]];
  return point;
}

// Takes away lines that begin or end within the surface and are short; the marked ones stay.
void remove_short_lines(const HalfEdges &half_edges, const Creases &marked, Creases &creases) {
  struct Line {
    int edges = 0, ends = 0;
  };
  const auto points = static_cast<size_t>(half_edges.point_count);
  const std::vector<int32_t> line_of = line_of_points(half_edges, creases);
  std::vector<int32_t> degree_of(points, 0);
  for_each_edge(half_edges, creases, [&](size_t, int a, int b) {
    ++degree_of[a];
    ++degree_of[b];
  });
  std::vector<Line> lines(points);
  for_each_edge(half_edges, creases, [&](size_t, int a, int b) {
    Line &line = lines[line_of[a]];
    ++line.edges;
    for (const int point : {a, b}) line.ends += degree_of[point] == 1 && !half_edges.point_boundary[point];
  });
  for_each_edge(half_edges, creases, [&](size_t h, int a, int) {
    const Line &line = lines[line_of[a]];
    if (marked.half_edge[h] || line.ends == 0 || line.edges >= least_open_line) return;
    creases.half_edge[h] = creases.half_edge[half_edges.twin[h]] = 0;
  });
}

} // namespace

int steady_face(const Triangles &triangles, const HalfEdges &half_edges, int face) {
  constexpr int most_steps = 8; // needles lie beside needles
  int steady = face, entered = -1;
  for (int step = 0; step < most_steps; ++step) {
    if (!is_needle(triangles, steady)) return steady;
    entered = half_edges.twin[longest_edge(triangles, steady, entered)];
    if (entered < 0) break;
    steady = entered / 3;
  }
  return face;
}

dvec3 steady_normal(const Triangles &triangles, const HalfEdges &half_edges, int face) {
  const Face given(triangles, face);
  dvec3 product = given.product();
  if (given.is_needle(product)) product = Face(triangles, steady_face(triangles, half_edges, face)).product();
  const double length = glm::length(product);
  return length > 0 ? product / length : dvec3(0);
}

// The normal of a face in floats, if its corners leave no doubt: it is not sharp at the first, nor small against where it is.
// Else 0.
static vec3 plain_normal(const Triangles &triangles, int face) {
  constexpr float least_sine = 0.1f, least_square = 1e-30f; // floats below have fewer digits
  constexpr auto rounding = static_cast<float>(4 * ROUNDING);
  const auto at = [&](int corner) -> const vec3 & { return triangles.positions[triangles.corner_vertex[3 * face + corner]]; };
  const vec3 &a = at(0), &b = at(1), &c = at(2); // copies would be made through memory
  const vec3 product = glm::cross(b - a, c - a);
  const float left = glm::dot(b - a, b - a), right = glm::dot(c - a, c - a), square = glm::dot(product, product);
  const float farthest = rounding * rounding * std::max({glm::dot(a, a), glm::dot(b, b), glm::dot(c, c)});
  const bool plain = square > std::max({least_sine * least_sine * left * right, farthest * (left + right), least_square});
  return plain ? product / std::sqrt(square) : vec3(0.0f);
}

vec3 rounded_steady_normal(const Triangles &triangles, const HalfEdges &half_edges, int face) {
  const vec3 plain = plain_normal(triangles, face);
  return plain != vec3(0.0f) ? plain : vec3(steady_normal(triangles, half_edges, face));
}

double bend_between(dvec3 left, dvec3 right, dvec3 along) {
  const double span = glm::length(along);
  return span > 0 ? angle_of(glm::dot(glm::cross(left, right), along) / span, glm::dot(left, right)) : 0.0;
}

double bend_at(const Triangles &triangles, const HalfEdges &half_edges, int half_edge) {
  const int twin = half_edges.twin[half_edge];
  if (twin < 0) return 0;
  return bend_between(steady_normal(triangles, half_edges, half_edge / 3), steady_normal(triangles, half_edges, twin / 3),
                      along(triangles, half_edge));
}

int32_t count_edges(const Creases &creases) {
  return static_cast<int32_t>(std::count(creases.half_edge.begin(), creases.half_edge.end(), 1) / 2);
}

std::vector<int32_t> line_of_points(const HalfEdges &half_edges, const Creases &creases) {
  std::vector<int32_t> line(static_cast<size_t>(half_edges.point_count));
  std::iota(line.begin(), line.end(), 0);
  for_each_edge(half_edges, creases, [&](size_t, int a, int b) { line[root_of(line, a)] = root_of(line, b); });
  for (int point = 0; point < half_edges.point_count; ++point) line[point] = root_of(line, point);
  return line;
}

Creases marked_creases(const Triangles &triangles, const HalfEdges &half_edges) {
  Creases creases;
  creases.half_edge.assign(half_edges.twin.size(), 0);
  if (std::ranges::find(triangles.half_edge_sharp, 1) == triangles.half_edge_sharp.end()) return creases;
  for (size_t h = 0; h < half_edges.twin.size(); ++h) {
    checkpoint_at(h);
    const int twin = half_edges.twin[h];
    if (twin >= 0 && triangles.half_edge_sharp[h] && triangles.half_edge_sharp[twin]) creases.half_edge[h] = 1;
  }
  creases.edges = count_edges(creases);
  return creases;
}

Creases find_creases(const Triangles &triangles, const HalfEdges &half_edges, int threads) {
  const Creases marked = marked_creases(triangles, half_edges);
  Creases creases = marked;
  std::vector<vec3> normals(static_cast<size_t>(triangles.triangle_count));
  parallel_blocks(triangles.triangle_count, threads, block_size, [&](int begin, int end) {
    for (int t = begin; t < end; ++t) normals[t] = rounded_steady_normal(triangles, half_edges, t);
  });
  constexpr float least_cosine = 0.93969262f + 1e-3f; // of the least bend
  const Surroundings surroundings(triangles, half_edges, normals);
  std::atomic<bool> found = false;
  parallel_blocks(triangles.triangle_count, threads, block_size, [&](int begin, int end) {
    for (int h = 3 * begin; h < 3 * end; ++h) {
      const int twin = half_edges.twin[h];
      if (twin <= h || glm::dot(normals[h / 3], normals[twin / 3]) >= least_cosine || !surroundings.stands_out(h)) continue;
      creases.half_edge[h] = creases.half_edge[twin] = 1;
      found = true;
    }
  });
  if (!found) return marked;
  remove_short_lines(half_edges, marked, creases);
  creases.edges = count_edges(creases);
  return creases;
}

} // namespace paradesc
