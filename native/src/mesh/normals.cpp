// Positions → unit normals: fans and rings once per topology, then one small least-squares fit per fan and frame.
//
// Max's weights: N. Max, "Weights for computing vertex normals from facet normals", 1999.
#include "mesh/normals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "mesh/jets.h"
#include "support/error.h"
#include "support/parallel.h"

namespace paradesc {
namespace {

constexpr int block_size = 1024;
constexpr int enough_neighbors = 14; // a jet of order 3 has nine coefficients; two whole rings have 18 on average
constexpr int max_rings = 3;
constexpr int max_corners = 32; // taken of one fan: keeps fans of thousands of faces from costing their square

// For smooth surfaces only: beyond these, in cosines, the fit gives way to Max's normal.
constexpr double spread_full = 0.8660254037844387; // 30 degrees: up to here the fit alone
constexpr double spread_none = 0.7071067811865476; // 45 degrees: from here Max's alone
constexpr double turn_full = 0.9902680687415704;   // 8 degrees
constexpr double turn_none = 0.9781476007338057;   // 12 degrees

// The corners of each fan in turning order.
struct FanCorners {
  std::vector<int32_t> begin;
  std::vector<int32_t> corner;
};

// Fans end at creases.
FanCorners find_fans(const Triangles &triangles, const HalfEdges &half_edges, const Creases &creases, NormalRings &rings) {
  const auto vertex = [&](int32_t corner) { return triangles.corner_vertex[corner]; };
  std::vector<int32_t> link = half_edges.twin;
  std::vector<uint8_t> left_out(static_cast<size_t>(triangles.triangle_count));
  for (size_t h = 0; h < link.size(); ++h) {
    if (half_edges.corner_point[h] < 0) left_out[h / 3] = 1;
    if (creases.half_edge[h]) link[h] = -1;
  }
  Fans traced = trace_fans(link, left_out);
  FanCorners fans;
  fans.begin.reserve(traced.first.size() + 1);
  fans.begin.push_back(0);
  fans.corner.reserve(link.size());
  rings.fan_point.reserve(traced.first.size());
  rings.fan_begin = {0};
  rings.fan_begin.reserve(traced.first.size() + 1);
  rings.fan_vertex.reserve(link.size() + 2 * traced.first.size());
  for (const int32_t first : traced.first) {
    rings.fan_vertex.push_back(vertex(first));
    rings.fan_vertex.push_back(vertex(next_corner(first)));
    for (int32_t corner = first; corner >= 0;) {
      fans.corner.push_back(corner);
      rings.fan_vertex.push_back(vertex(previous_corner(corner)));
      corner = link[previous_corner(corner)];
      if (corner == first) break;
    }
    fans.begin.push_back(static_cast<int32_t>(fans.corner.size()));
    rings.fan_begin.push_back(static_cast<int32_t>(rings.fan_vertex.size()));
    rings.fan_point.push_back(half_edges.corner_point[first]);
  }
  rings.fan_count = traced.count;
  rings.corner_fan = std::make_shared<const std::vector<int32_t>>(std::move(traced.corner_fan));
  constexpr int32_t none = -2, several = -1;
  rings.point_fan.assign(static_cast<size_t>(half_edges.point_count), none);
  for (int32_t fan = 0; fan < rings.fan_count; ++fan) {
    int32_t &only = rings.point_fan[rings.fan_point[fan]];
    only = only == none ? fan : several;
  }
  return fans;
}

// Walks the rings of one fan after the other; stamps of what was met live as long as the walker.
class RingWalker {
public:
  RingWalker(const HalfEdges &half_edges, const NormalRings &rings, const FanCorners &fans)
      : half_edges_(half_edges), rings_(rings), fans_(fans), fan_stamp_(static_cast<size_t>(rings.fan_count), -1),
        point_stamp_(static_cast<size_t>(half_edges.point_count), -1), face_stamp_(rings.corner_fan->size() / 3, -1) {}

  // Appends to vertices and faces.
  void walk(int fan, std::vector<int32_t> &vertices, std::vector<int32_t> &faces) {
    const size_t begin = vertices.size();
    fan_ = fan;
    fan_stamp_[fan] = fan;
    point_stamp_[rings_.fan_point[fan]] = fan;
    for (const int corner : corners(fan)) take_face(corner / 3, faces);
    front_.assign(1, fan);
    for (int ring = 0; ring < max_rings && !front_.empty(); ++ring) {
      const size_t found = vertices.size() - begin;
      if ((ring >= 2 && found >= enough_neighbors) || found >= max_neighbors) break;
      next_front_.clear();
      for (const int member : front_) take_fan(member, vertices, faces);
      std::swap(front_, next_front_);
    }
    if (vertices.size() - begin > max_neighbors) vertices.resize(begin + max_neighbors);
  }

private:
  std::span<const int32_t> corners(int fan) const {
    const auto begin = static_cast<size_t>(fans_.begin[fan]);
    const auto end = static_cast<size_t>(fans_.begin[fan + 1]);
    return {fans_.corner.data() + begin, end - begin};
  }

  void take_fan(int member, std::vector<int32_t> &vertices, std::vector<int32_t> &faces) {
    const auto all = corners(member);
    const size_t step = (all.size() + max_corners - 1) / max_corners;
    for (size_t i = 0; i < all.size(); i += step) {
      take_face(all[i] / 3, faces);
      take_corner(next_corner(all[i]), vertices);
      take_corner(previous_corner(all[i]), vertices);
    }
  }

  void take_face(int face, std::vector<int32_t> &faces) {
    if (std::exchange(face_stamp_[face], fan_) != fan_) faces.push_back(face);
  }

  void take_corner(int corner, std::vector<int32_t> &vertices) {
    const int other = (*rings_.corner_fan)[corner];
    if (std::exchange(fan_stamp_[other], fan_) == fan_) return;
    next_front_.push_back(other);
    const auto point = static_cast<size_t>(half_edges_.corner_point[corner]);
    if (std::exchange(point_stamp_[point], fan_) != fan_) vertices.push_back(half_edges_.point_vertex[point]);
  }

  const HalfEdges &half_edges_;
  const NormalRings &rings_;
  const FanCorners &fans_;
  int fan_ = -1;
  std::vector<int32_t> fan_stamp_, point_stamp_, face_stamp_, front_, next_front_;
};

// The rings of a run of fans.
struct RingRun {
  std::vector<int32_t> ring_size, face_size, vertices, faces;
};

RingRun walk_run(RingWalker &walker, int begin, int end) {
  RingRun run;
  for (int fan = begin; fan < end; ++fan) {
    const size_t vertices = run.vertices.size(), faces = run.faces.size();
    walker.walk(fan, run.vertices, run.faces);
    run.ring_size.push_back(static_cast<int32_t>(run.vertices.size() - vertices));
    run.face_size.push_back(static_cast<int32_t>(run.faces.size() - faces));
  }
  run.vertices.shrink_to_fit();
  run.faces.shrink_to_fit();
  return run;
}

void append(const std::vector<int32_t> &from, std::vector<int32_t> &to) { to.insert(to.end(), from.begin(), from.end()); }

void append_sizes(const std::vector<int32_t> &sizes, std::vector<int32_t> &begins) {
  for (const int32_t size : sizes) begins.push_back(begins.back() + size);
}

// Each run is given up as soon as it is copied: rings take more memory than the mesh.
void join_runs(std::vector<RingRun> &runs, NormalRings &rings) {
  size_t vertices = 0, faces = 0;
  for (const RingRun &run : runs) {
    vertices += run.vertices.size();
    faces += run.faces.size();
  }
  rings.ring_vertex.reserve(vertices);
  rings.face.reserve(faces);
  for (auto *begins : {&rings.ring_begin, &rings.face_begin}) {
    begins->reserve(static_cast<size_t>(rings.fan_count) + 1);
    begins->push_back(0);
  }
  for (RingRun &run : runs) {
    append_sizes(run.ring_size, rings.ring_begin);
    append_sizes(run.face_size, rings.face_begin);
    append(run.vertices, rings.ring_vertex);
    append(run.faces, rings.face);
    run = {};
  }
}

// ---- Fans -----------------------------------------------------------------------------------------------------------------

dvec3 position(const Triangles &triangles, int vertex) { return dvec3(triangles.positions[vertex]); }

// Edges of a corner's triangle that start from it.
std::pair<dvec3, dvec3> corner_edges(const Triangles &triangles, int corner) {
  const auto vertex = [&](int c) { return position(triangles, triangles.corner_vertex[c]); };
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
      normals[t] = vec3(unit_or(glm::cross(a, b), dvec3(0)));
    }
  });
  return normals;
}

std::span<const int32_t> slice(const std::vector<int32_t> &begins, const std::vector<int32_t> &all, int index) {
  const auto begin = static_cast<size_t>(begins[index]);
  return {all.data() + begin, static_cast<size_t>(begins[index + 1]) - begin};
}

struct Sources {
  const Triangles &triangles;
  const NormalRings &rings;
  const std::vector<vec3> &faces;
};

// N. Max's, from edges to the vertices around.
dvec3 max_normal(const Sources &from, int fan) {
  const auto vertices = slice(from.rings.fan_begin, from.rings.fan_vertex, fan);
  const dvec3 p = position(from.triangles, vertices[0]);
  dvec3 sum(0), a = position(from.triangles, vertices[1]) - p;
  double square = glm::dot(a, a);
  for (const int32_t vertex : vertices.subspan(2)) {
    const dvec3 b = position(from.triangles, vertex) - p;
    const double next_square = glm::dot(b, b), squares = square * next_square;
    if (squares > 0) sum += glm::cross(a, b) / squares;
    a = b;
    square = next_square;
  }
  if (const dvec3 normal = unit_or(sum, dvec3(0)); normal != dvec3(0)) return normal;
  for (size_t i = vertices.size() - 1; i > 1; --i) { // faces that cancel out: the last one's, which has one
    const dvec3 face = glm::cross(position(from.triangles, vertices[i - 1]) - p, position(from.triangles, vertices[i]) - p);
    if (const dvec3 normal = unit_or(face, dvec3(0)); normal != dvec3(0)) return normal;
  }
  return dvec3(0, 0, 1);
}

// 1 where value >= full, 0 where value <= none, smooth between.
double smooth_step(double none, double full, double value) {
  const double t = std::clamp((value - none) / (full - none), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

// Fits fans in lanes, as many at a time as there are.
class Fitter {
public:
  Fitter(const Sources &from, std::vector<vec3> &normals) : from_(from), normals_(normals) {}
  ~Fitter() { fit(); }
  Fitter(const Fitter &) = delete;
  Fitter &operator=(const Fitter &) = delete;

  void add(int fan) {
    const dvec3 n = max_normal(from_, fan);
    double spread = 1;
    for (const int face : slice(from_.rings.face_begin, from_.rings.face, fan))
      spread = std::min(spread, glm::dot(dvec3(from_.faces[face]), n));
    if (spread <= spread_none) {
      normals_[fan] = vec3(n);
      return;
    }
    const dvec3 e1 = tangent_of(n);
    members_[used_] = {fan, spread, n, e1, glm::cross(n, e1)};
    take_heights(members_[used_]);
    if (++used_ == fan_lanes) fit();
  }

private:
  struct Member {
    int fan;
    double spread;
    dvec3 n, e1, e2;
  };

  void take_heights(const Member &member) {
    const auto center = static_cast<size_t>(from_.rings.fan_begin[member.fan]);
    const dvec3 p = position(from_.triangles, from_.rings.fan_vertex[center]);
    const auto ring = slice(from_.rings.ring_begin, from_.rings.ring_vertex, member.fan);
    for (; heights_.max_count < ring.size(); ++heights_.max_count)
      heights_.u[heights_.max_count] = heights_.v[heights_.max_count] = heights_.w[heights_.max_count] = FanLanes{};
    for (size_t i = 0; i < ring.size(); ++i) {
      const dvec3 d = position(from_.triangles, ring[i]) - p;
      heights_.u[i][used_] = glm::dot(d, member.e1);
      heights_.v[i][used_] = glm::dot(d, member.e2);
      heights_.w[i][used_] = glm::dot(d, member.n);
    }
    heights_.count[used_] = static_cast<int>(ring.size());
  }

  void fit() {
    if (used_ == 0) return;
    Gradients gradients;
    fit_gradients_(heights_, gradients);
    for (int lane = 0; lane < used_; ++lane)
      normals_[members_[lane].fan] =
          vec3(gradients.exists[lane] ? turned(members_[lane], gradients.u[lane], gradients.v[lane]) : members_[lane].n);
    used_ = 0;
    heights_.max_count = 0;
    std::ranges::fill(heights_.count, 0);
  }

  static dvec3 turned(const Member &member, double u, double v) {
    const dvec3 n = member.n;
    const dvec3 fitted = glm::normalize(n - u * member.e1 - v * member.e2);
    const double weight =
        smooth_step(spread_none, spread_full, member.spread) * smooth_step(turn_none, turn_full, glm::dot(n, fitted));
    return glm::normalize(n + weight * (fitted - n));
  }

  const Sources &from_;
  std::vector<vec3> &normals_;
  Heights heights_;
  std::array<Member, fan_lanes> members_;
  int used_ = 0;
  FitGradients fit_gradients_ = fit_gradients();
};

std::vector<vec3> fan_normals(const Sources &from, bool fitted, int threads) {
  std::vector<vec3> normals(static_cast<size_t>(from.rings.fan_count));
  parallel_blocks(from.rings.fan_count, threads, block_size, [&](int begin, int end) {
    if (fitted) {
      Fitter fitter(from, normals);
      for (int fan = begin; fan < end; ++fan) fitter.add(fan);
    } else {
      for (int fan = begin; fan < end; ++fan) normals[fan] = vec3(max_normal(from, fan));
    }
  });
  return normals;
}

// ---- Corners and points ---------------------------------------------------------------------------------------------------

std::vector<vec3> input_corner_normals(const Triangles &triangles, const HalfEdges &half_edges, const std::vector<vec3> &faces,
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

// The mean of the normals of the point's corners by angle; corners that agree need no mean.
vec3 point_normal(const Triangles &triangles, const HalfEdges &half_edges, const Normals &normals, int point) {
  const int first = half_edges.point_half_edge[point];
  const vec3 first_normal = normals.corner(static_cast<size_t>(first));
  dvec3 sum(0);
  bool common = true;
  for (int corner = first; corner >= 0;) {
    const vec3 normal = normals.corner(static_cast<size_t>(corner));
    common = common && normal == first_normal;
    if (!common) break;
    corner = half_edges.twin[previous_corner(corner)];
    if (corner == first) break;
  }
  if (common) return first_normal;
  for (int corner = first; corner >= 0;) {
    sum += surface_angle(triangles, corner) * dvec3(normals.corner(static_cast<size_t>(corner)));
    corner = half_edges.twin[previous_corner(corner)];
    if (corner == first) break;
  }
  return vec3(unit_or(sum, dvec3(first_normal)));
}

} // namespace

NormalRings build_normal_rings(const Triangles &triangles, const HalfEdges &half_edges, int threads) {
  return build_normal_rings(triangles, half_edges, marked_creases(triangles, half_edges), threads);
}

NormalRings build_normal_rings(const Triangles &triangles, const HalfEdges &half_edges, const Creases &creases, int threads) {
  constexpr int run_length = 8192; // of fans
  NormalRings rings;
  const FanCorners fans = find_fans(triangles, half_edges, creases, rings);
  checkpoint();
  std::vector<RingRun> runs(static_cast<size_t>((rings.fan_count + run_length - 1) / run_length));
  const auto run_count = static_cast<int>(runs.size());
  // There are as many shares as threads; each has stamps of its own.
  const int shares = std::min(thread_count(threads), std::max(run_count, 1));
  parallel_blocks(shares, threads, 1, [&](int share, int) {
    const auto first_of = [&](int i) { return static_cast<int>(int64_t{run_count} * i / shares); };
    RingWalker walker(half_edges, rings, fans);
    for (int run = first_of(share); run < first_of(share + 1); ++run) {
      checkpoint();
      runs[run] = walk_run(walker, run * run_length, std::min((run + 1) * run_length, rings.fan_count));
    }
  });
  join_runs(runs, rings);
  return rings;
}

Normals compute_normals(const Triangles &triangles, const HalfEdges &half_edges, const NormalRings &rings, int32_t kind,
                        int threads) {
  const std::vector<vec3> faces = kind == PDESC_NORMALS_MAX ? std::vector<vec3>() : face_normals(triangles, threads);
  Normals normals;
  if (kind == PDESC_NORMALS_MESH) {
    if (triangles.corner_normal.empty())
      throw Error(PDESC_ERROR_INVALID_OPERATION, "The mesh's own normals were asked for, but it was created without "
                                                 "corner_normals: give them, or ask for fitted or Max's normals.");
    normals.group = input_corner_normals(triangles, half_edges, faces, threads);
  } else {
    normals.group = fan_normals({triangles, rings, faces}, kind == PDESC_NORMALS_FITTED, threads);
    normals.corner_fan = rings.corner_fan;
  }
  normals.point.resize(static_cast<size_t>(half_edges.point_count));
  parallel_blocks(half_edges.point_count, threads, 4 * block_size, [&](int begin, int end) {
    for (int point = begin; point < end; ++point) {
      const int32_t fan = !normals.corner_fan ? -1 : rings.point_fan[point];
      normals.point[point] = fan >= 0 ? normals.group[fan] : point_normal(triangles, half_edges, normals, point);
    }
  });
  return normals;
}

} // namespace paradesc
