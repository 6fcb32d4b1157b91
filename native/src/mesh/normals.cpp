// Positions → unit normals: fans and rings once per topology, then one small least-squares fit per fan and frame.
//
// Max's weights: N. Max, "Weights for computing vertex normals from facet normals", 1999. Jets: F. Cazals, M. Pouget,
// "Estimating differential quantities using polynomial fitting of osculating jets", 2003.
#include "mesh/normals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "support/error.h"
#include "support/parallel.h"

namespace paradesc {
namespace {

constexpr int block_size = 1024;
constexpr int enough_neighbors = 14; // a jet of order 3 has nine coefficients; two whole rings have 18 on average
constexpr int spare_neighbors = 2;   // more than coefficients
constexpr int most_rings = 3;
constexpr int most_corners = 32; // taken of one fan: keeps fans of thousands of faces from costing their square
constexpr int most_neighbors = 96;

// Smooth places only: beyond these, in cosines, the fit gives way to Max's normal.
constexpr double spread_full = 0.8660254037844387; // 30 degrees: up to here the fit alone
constexpr double spread_none = 0.7071067811865476; // 45 degrees: from here Max's alone
constexpr double turn_full = 0.9902680687415704;   // 8 degrees
constexpr double turn_none = 0.9781476007338057;   // 12 degrees

// The corners of each fan in turning order.
struct FanCorners {
  std::vector<int32_t> begin;
  std::vector<int32_t> corner;
};

// Fans end at creases: edges that are sharp between two smooth faces.
FanCorners find_fans(const Triangles &triangles, const HalfEdges &half_edges, NormalRings &rings) {
  std::vector<int32_t> link = half_edges.twin;
  std::vector<uint8_t> left_out(static_cast<size_t>(triangles.triangle_count));
  for (size_t h = 0; h < link.size(); ++h) {
    if (half_edges.corner_point[h] < 0) left_out[h / 3] = 1;
    if (link[h] < 0 || !triangles.half_edge_sharp[h]) continue;
    const auto twin = static_cast<size_t>(link[h]);
    if (triangles.half_edge_sharp[twin]) link[h] = link[twin] = -1;
  }
  Fans traced = trace_fans(link, left_out);
  FanCorners fans;
  fans.begin.reserve(traced.first.size() + 1);
  fans.begin.push_back(0);
  fans.corner.reserve(link.size());
  rings.fan_point.reserve(traced.first.size());
  for (const int32_t first : traced.first) {
    for (int32_t corner = first; corner >= 0;) {
      fans.corner.push_back(corner);
      corner = link[static_cast<size_t>(previous_corner(corner))];
      if (corner == first) break;
    }
    fans.begin.push_back(static_cast<int32_t>(fans.corner.size()));
    rings.fan_point.push_back(half_edges.corner_point[static_cast<size_t>(first)]);
  }
  rings.fan_count = traced.count;
  rings.corner_fan = std::move(traced.corner_fan);
  return fans;
}

// Walks the rings of one fan after the other; stamps of what was met live as long as the walker.
class RingWalker {
public:
  RingWalker(const HalfEdges &half_edges, const NormalRings &rings, const FanCorners &fans)
      : half_edges_(half_edges), rings_(rings), fans_(fans), fan_stamp_(static_cast<size_t>(rings.fan_count), -1),
        point_stamp_(static_cast<size_t>(half_edges.point_count), -1), face_stamp_(rings.corner_fan.size() / 3, -1) {}

  // Appends to points and faces; returns how many of the faces are the fan's own.
  int32_t walk(int fan, std::vector<int32_t> &points, std::vector<int32_t> &faces) {
    const size_t points_begin = points.size();
    const size_t faces_begin = faces.size();
    fan_ = fan;
    fan_stamp_[static_cast<size_t>(fan)] = fan;
    point_stamp_[static_cast<size_t>(rings_.fan_point[static_cast<size_t>(fan)])] = fan;
    for (const int corner : corners(fan)) take_face(corner / 3, faces);
    const auto own_faces = static_cast<int32_t>(faces.size() - faces_begin);
    front_.assign(1, fan);
    for (int ring = 0; ring < most_rings && !front_.empty(); ++ring) {
      const size_t found = points.size() - points_begin;
      if ((ring >= 2 && found >= enough_neighbors) || found >= most_neighbors) break;
      next_front_.clear();
      for (const int member : front_) take_fan(member, points, faces);
      std::swap(front_, next_front_);
    }
    if (points.size() - points_begin > most_neighbors) points.resize(points_begin + most_neighbors);
    return own_faces;
  }

private:
  std::span<const int32_t> corners(int fan) const {
    const auto begin = static_cast<size_t>(fans_.begin[static_cast<size_t>(fan)]);
    const auto end = static_cast<size_t>(fans_.begin[static_cast<size_t>(fan) + 1]);
    return {fans_.corner.data() + begin, end - begin};
  }

  void take_fan(int member, std::vector<int32_t> &points, std::vector<int32_t> &faces) {
    const auto all = corners(member);
    const size_t step = (all.size() + most_corners - 1) / most_corners;
    for (size_t i = 0; i < all.size(); i += step) {
      take_face(all[i] / 3, faces);
      take_corner(next_corner(all[i]), points);
      take_corner(previous_corner(all[i]), points);
    }
  }

  void take_face(int face, std::vector<int32_t> &faces) {
    if (std::exchange(face_stamp_[static_cast<size_t>(face)], fan_) != fan_) faces.push_back(face);
  }

  void take_corner(int corner, std::vector<int32_t> &points) {
    const int other = rings_.corner_fan[static_cast<size_t>(corner)];
    if (std::exchange(fan_stamp_[static_cast<size_t>(other)], fan_) == fan_) return;
    next_front_.push_back(other);
    const int point = half_edges_.corner_point[static_cast<size_t>(corner)];
    if (std::exchange(point_stamp_[static_cast<size_t>(point)], fan_) != fan_) points.push_back(point);
  }

  const HalfEdges &half_edges_;
  const NormalRings &rings_;
  const FanCorners &fans_;
  int fan_ = -1;
  std::vector<int32_t> fan_stamp_, point_stamp_, face_stamp_, front_, next_front_;
};

// The rings of a run of fans.
struct RingRun {
  std::vector<int32_t> ring_size, face_size, own_faces, points, faces;
};

RingRun walk_run(RingWalker &walker, int begin, int end) {
  RingRun run;
  for (int fan = begin; fan < end; ++fan) {
    const size_t points = run.points.size(), faces = run.faces.size();
    run.own_faces.push_back(walker.walk(fan, run.points, run.faces));
    run.ring_size.push_back(static_cast<int32_t>(run.points.size() - points));
    run.face_size.push_back(static_cast<int32_t>(run.faces.size() - faces));
  }
  run.points.shrink_to_fit();
  run.faces.shrink_to_fit();
  return run;
}

void append(const std::vector<int32_t> &from, std::vector<int32_t> &to) { to.insert(to.end(), from.begin(), from.end()); }

void append_sizes(const std::vector<int32_t> &sizes, std::vector<int32_t> &begins) {
  for (const int32_t size : sizes) begins.push_back(begins.back() + size);
}

// Each run is given up as soon as it is copied: rings take more memory than the mesh.
void join_runs(std::vector<RingRun> &runs, NormalRings &rings) {
  size_t points = 0, faces = 0;
  for (const RingRun &run : runs) {
    points += run.points.size();
    faces += run.faces.size();
  }
  rings.ring_point.reserve(points);
  rings.face.reserve(faces);
  for (auto *begins : {&rings.ring_begin, &rings.face_begin}) {
    begins->reserve(static_cast<size_t>(rings.fan_count) + 1);
    begins->push_back(0);
  }
  rings.own_faces.reserve(static_cast<size_t>(rings.fan_count));
  for (RingRun &run : runs) {
    append_sizes(run.ring_size, rings.ring_begin);
    append_sizes(run.face_size, rings.face_begin);
    append(run.own_faces, rings.own_faces);
    append(run.points, rings.ring_point);
    append(run.faces, rings.face);
    run = {};
  }
}

// ---- Jets -----------------------------------------------------------------------------------------------------------------

// The neighbors of one fan as heights w over Max's tangent plane.
struct Heights {
  int count = 0;
  std::array<double, most_neighbors> u, v, w;
};

constexpr size_t cubic_terms = 4, columns = 9; // of the full problem; without its first four columns it is the quadratic one
using Gram = std::array<std::array<double, columns + 1>, columns + 1>;

// Sums of u^(degree - k) v^k over the neighbors, and of the same times w: all that the normal equations are made of.
struct JetMoments {
  static constexpr size_t most = 6;
  std::array<std::array<double, most + 1>, most + 1> sum{}; // (degree, k)
  std::array<std::array<double, 4>, 4> sum_w{};
  double sum_ww = 0;

  void add(double u, double v, double w) {
    std::array<double, most + 1> power{1}; // of one degree
    for (size_t degree = 1; degree <= most; ++degree) {
      power[degree] = power[degree - 1] * v;
      for (size_t k = 0; k < degree; ++k) power[k] *= u;
      for (size_t k = 0; k <= degree; ++k) sum[degree][k] += power[k];
      if (degree > 3) continue;
      for (size_t k = 0; k <= degree; ++k) sum_w[degree][k] += power[k] * w;
    }
    sum_ww += w * w;
  }
};

// Normal equations of w = a jet without constant term, gradient last, then the heights themselves. Columns are scaled to unit
// length; scale keeps the factors. False where a column vanishes.
bool make_gram(const Heights &heights, Gram &gram, std::array<double, columns + 1> &scale) {
  struct Monomial {
    size_t degree, k;
  };
  constexpr std::array<Monomial, columns> monomials{{{3, 0}, {3, 1}, {3, 2}, {3, 3}, {2, 0}, {2, 1}, {2, 2}, {1, 0}, {1, 1}}};
  JetMoments moments;
  for (size_t i = 0; i < static_cast<size_t>(heights.count); ++i) moments.add(heights.u[i], heights.v[i], heights.w[i]);
  for (size_t a = 0; a < columns; ++a) {
    const Monomial own = monomials[a];
    for (size_t b = 0; b < columns; ++b) gram[a][b] = moments.sum[own.degree + monomials[b].degree][own.k + monomials[b].k];
    gram[a][columns] = gram[columns][a] = moments.sum_w[own.degree][own.k];
  }
  gram[columns][columns] = moments.sum_ww;
  for (size_t a = 0; a <= columns; ++a) {
    if (a < columns && !(gram[a][a] > 0)) return false;
    scale[a] = a < columns ? 1 / std::sqrt(gram[a][a]) : 1;
  }
  for (size_t a = 0; a <= columns; ++a)
    for (size_t b = 0; b <= columns; ++b) gram[a][b] *= scale[a] * scale[b];
  return true;
}

struct Gradient {
  double u = 0, v = 0;
  double residual = 0; // sum of squares
};

// Elimination from the given column on. Higher orders go first, so that what is left of the last two pivots (of 1) tells how
// well the neighbors determine the gradient alone. False where they do not.
template <size_t first> bool solve_gradient(Gram gram, const std::array<double, columns + 1> &scale, Gradient &gradient) {
  constexpr double least_pivot = 1e-5;
  for (size_t k = first; k < columns; ++k) {
    if (!(gram[k][k] > least_pivot)) return false;
    const double inverse = 1 / gram[k][k];
    for (size_t a = k + 1; a <= columns; ++a) {
      const double factor = gram[a][k] * inverse;
      for (size_t b = k + 1; b <= columns; ++b) gram[a][b] -= factor * gram[k][b];
    }
  }
  constexpr size_t u = columns - 2, v = columns - 1;
  const double slope = gram[v][columns] / gram[v][v];
  gradient.v = slope * scale[v];
  gradient.u = (gram[u][columns] - gram[u][v] * slope) / gram[u][u] * scale[u];
  gradient.residual = std::max(gram[columns][columns], 0.0);
  return true;
}

// The gradient at the origin of the height function through it. Cubic terms take part as far as they explain more than noise
// would: the quadratic jet has three times less of that. F is the ratio of Fisher's test of the larger model, about 1 where the
// terms explain nothing; shrinking by 1 - c/F is James and Stein's.
bool fit_gradient(const Heights &heights, Gradient &gradient) {
  constexpr double least_gain = 3; // c: 19 times of 20, noise alone gives less than 3.6 with two rings of 18 neighbors
  constexpr int quadratic_columns = static_cast<int>(columns - cubic_terms), all_columns = static_cast<int>(columns);
  Gram gram;
  std::array<double, columns + 1> scale;
  if (heights.count < quadratic_columns + spare_neighbors || !make_gram(heights, gram, scale)) return false;
  Gradient cubic;
  if (!solve_gradient<cubic_terms>(gram, scale, gradient)) return false;
  if (heights.count < all_columns + spare_neighbors || !solve_gradient<0>(gram, scale, cubic)) return true;
  const double gain = (gradient.residual - cubic.residual) / static_cast<double>(cubic_terms);
  const double noise = cubic.residual / (heights.count - all_columns);
  const double share = gain > least_gain * noise ? 1 - least_gain * noise / gain : 0;
  gradient.u += share * (cubic.u - gradient.u);
  gradient.v += share * (cubic.v - gradient.v);
  return true;
}

// ---- Fans -----------------------------------------------------------------------------------------------------------------

dvec3 position(const Triangles &triangles, int vertex) { return dvec3(triangles.positions[static_cast<size_t>(vertex)]); }

// Edges of a corner's triangle that start from it.
std::pair<dvec3, dvec3> corner_edges(const Triangles &triangles, int corner) {
  const auto vertex = [&](int c) { return position(triangles, triangles.corner_vertex[static_cast<size_t>(c)]); };
  const dvec3 p = vertex(corner);
  return {vertex(next_corner(corner)) - p, vertex(previous_corner(corner)) - p};
}

dvec3 unit_or(dvec3 v, dvec3 otherwise) {
  const double length = glm::length(v);
  return length > 0 && std::isfinite(length) ? v / length : otherwise;
}

std::vector<vec3> face_normals(const Triangles &triangles, int threads) {
  std::vector<vec3> normals(static_cast<size_t>(triangles.triangle_count));
  parallel_blocks(triangles.triangle_count, threads, 4 * block_size, [&](int begin, int end) {
    for (int t = begin; t < end; ++t) {
      const auto [a, b] = corner_edges(triangles, 3 * t);
      normals[static_cast<size_t>(t)] = vec3(unit_or(glm::cross(a, b), dvec3(0)));
    }
  });
  return normals;
}

std::span<const int32_t> slice(const std::vector<int32_t> &begins, const std::vector<int32_t> &all, int index) {
  const auto begin = static_cast<size_t>(begins[static_cast<size_t>(index)]);
  return {all.data() + begin, static_cast<size_t>(begins[static_cast<size_t>(index) + 1]) - begin};
}

struct Sources {
  const Triangles &triangles;
  const HalfEdges &half_edges;
  const NormalRings &rings;
  const std::vector<vec3> &faces;
};

std::span<const int32_t> own_faces(const NormalRings &rings, int fan) {
  return slice(rings.face_begin, rings.face, fan).first(static_cast<size_t>(rings.own_faces[static_cast<size_t>(fan)]));
}

// The corner of a face that belongs to the fan.
int fan_corner(const NormalRings &rings, int face, int fan) {
  int corner = 3 * face;
  while (rings.corner_fan[static_cast<size_t>(corner)] != fan) ++corner;
  return corner;
}

dvec3 max_normal(const Sources &from, int fan) {
  dvec3 sum(0), face_normal(0, 0, 1);
  for (const int face : own_faces(from.rings, fan)) {
    const auto [a, b] = corner_edges(from.triangles, fan_corner(from.rings, face, fan));
    const double squares = glm::dot(a, a) * glm::dot(b, b);
    if (squares > 0) sum += glm::cross(a, b) / squares;
    const vec3 own = from.faces[static_cast<size_t>(face)];
    if (own != vec3(0)) face_normal = dvec3(own);
  }
  return unit_or(sum, face_normal);
}

Heights heights_over(const Sources &from, int fan, dvec3 p, dvec3 e1, dvec3 e2, dvec3 n) {
  Heights heights;
  for (const int point : slice(from.rings.ring_begin, from.rings.ring_point, fan)) {
    const dvec3 d = position(from.triangles, from.half_edges.point_vertex[static_cast<size_t>(point)]) - p;
    const auto i = static_cast<size_t>(heights.count++);
    heights.u[i] = glm::dot(d, e1);
    heights.v[i] = glm::dot(d, e2);
    heights.w[i] = glm::dot(d, n);
  }
  return heights;
}

// 1 where value >= full, 0 where value <= none, smooth between.
double smooth_step(double none, double full, double value) {
  const double t = std::clamp((value - none) / (full - none), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

dvec3 fitted_normal(const Sources &from, int fan) {
  const dvec3 n = max_normal(from, fan);
  double spread = 1;
  for (const int face : slice(from.rings.face_begin, from.rings.face, fan))
    spread = std::min(spread, glm::dot(dvec3(from.faces[static_cast<size_t>(face)]), n));
  if (spread <= spread_none) return n;
  const dvec3 e1 = glm::normalize(glm::cross(n, std::abs(n.x) < 0.6 ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
  const dvec3 e2 = glm::cross(n, e1);
  const int point = from.rings.fan_point[static_cast<size_t>(fan)];
  const dvec3 p = position(from.triangles, from.half_edges.point_vertex[static_cast<size_t>(point)]);
  const Heights heights = heights_over(from, fan, p, e1, e2, n);
  Gradient gradient;
  if (!fit_gradient(heights, gradient)) return n;
  const dvec3 fitted = glm::normalize(n - gradient.u * e1 - gradient.v * e2);
  const double weight = smooth_step(spread_none, spread_full, spread) * smooth_step(turn_none, turn_full, glm::dot(n, fitted));
  return glm::normalize(n + weight * (fitted - n));
}

std::vector<vec3> fan_normals(const Sources &from, bool fitted, int threads) {
  std::vector<vec3> normals(static_cast<size_t>(from.rings.fan_count));
  parallel_blocks(from.rings.fan_count, threads, block_size, [&](int begin, int end) {
    for (int fan = begin; fan < end; ++fan)
      normals[static_cast<size_t>(fan)] = vec3(fitted ? fitted_normal(from, fan) : max_normal(from, fan));
  });
  return normals;
}

// ---- Corners and points ---------------------------------------------------------------------------------------------------

std::vector<vec3> given_corner_normals(const Triangles &triangles, const HalfEdges &half_edges, const std::vector<vec3> &faces,
                                       int threads) {
  std::vector<vec3> corners(triangles.corner_normal.size());
  parallel_blocks(3 * triangles.triangle_count, threads, 4 * block_size, [&](int begin, int end) {
    for (int corner = begin; corner < end; ++corner) {
      const auto i = static_cast<size_t>(corner);
      if (half_edges.corner_point[i] >= 0) corners[i] = vec3(unit_or(dvec3(triangles.corner_normal[i]), dvec3(faces[i / 3])));
    }
  });
  return corners;
}

// The mean of the normals of the point's corners by angle; corners of one fan that agree need no mean.
vec3 point_normal(const Triangles &triangles, const HalfEdges &half_edges, const std::vector<vec3> &corners, int point) {
  const int first = half_edges.point_half_edge[static_cast<size_t>(point)];
  const vec3 first_normal = corners[static_cast<size_t>(first)];
  dvec3 sum(0);
  bool common = true;
  for (int corner = first; corner >= 0;) {
    const vec3 normal = corners[static_cast<size_t>(corner)];
    common = common && normal == first_normal;
    if (!common) break;
    corner = half_edges.twin[static_cast<size_t>(previous_corner(corner))];
    if (corner == first) break;
  }
  if (common) return first_normal;
  for (int corner = first; corner >= 0;) {
    sum += surface_angle(triangles, corner) * dvec3(corners[static_cast<size_t>(corner)]);
    corner = half_edges.twin[static_cast<size_t>(previous_corner(corner))];
    if (corner == first) break;
  }
  return vec3(unit_or(sum, dvec3(first_normal)));
}

} // namespace

NormalRings build_normal_rings(const Triangles &triangles, const HalfEdges &half_edges, int threads) {
  constexpr int run_length = 8192; // of fans
  NormalRings rings;
  const FanCorners fans = find_fans(triangles, half_edges, rings);
  checkpoint();
  std::vector<RingRun> runs(static_cast<size_t>((rings.fan_count + run_length - 1) / run_length));
  const auto run_count = static_cast<int>(runs.size());
  // As many shares as threads: each has stamps of its own.
  const int shares = std::min(thread_count(threads), std::max(run_count, 1));
  parallel_blocks(shares, threads, 1, [&](int share, int) {
    const auto first_of = [&](int i) { return static_cast<int>(int64_t{run_count} * i / shares); };
    RingWalker walker(half_edges, rings, fans);
    for (int run = first_of(share); run < first_of(share + 1); ++run) {
      checkpoint();
      runs[static_cast<size_t>(run)] = walk_run(walker, run * run_length, std::min((run + 1) * run_length, rings.fan_count));
    }
  });
  join_runs(runs, rings);
  return rings;
}

Normals compute_normals(const Triangles &triangles, const HalfEdges &half_edges, const NormalRings &rings, int32_t kind,
                        int threads) {
  const std::vector<vec3> faces = face_normals(triangles, threads);
  Normals normals;
  if (kind == PDESC_NORMALS_MESH) {
    if (triangles.corner_normal.empty())
      throw Error(PDESC_ERROR_INVALID_OPERATION, "The mesh's own normals were asked for, but it was created without "
                                                 "corner_normals: give them, or ask for fitted or Max's normals.");
    normals.corner = given_corner_normals(triangles, half_edges, faces, threads);
  } else {
    const std::vector<vec3> fans = fan_normals({triangles, half_edges, rings, faces}, kind == PDESC_NORMALS_FITTED, threads);
    normals.corner.resize(rings.corner_fan.size());
    parallel_blocks(3 * triangles.triangle_count, threads, 16 * block_size, [&](int begin, int end) {
      for (size_t corner = static_cast<size_t>(begin); corner < static_cast<size_t>(end); ++corner)
        if (rings.corner_fan[corner] >= 0) normals.corner[corner] = fans[static_cast<size_t>(rings.corner_fan[corner])];
    });
  }
  normals.point.resize(static_cast<size_t>(half_edges.point_count));
  parallel_blocks(half_edges.point_count, threads, 4 * block_size, [&](int begin, int end) {
    for (int point = begin; point < end; ++point)
      normals.point[static_cast<size_t>(point)] = point_normal(triangles, half_edges, normals.corner, point);
  });
  return normals;
}

} // namespace paradesc
