// Positions → unit normals: fans and rings once per topology, then one small least-squares fit per fan and frame.
//
// Max's weights: N. Max, "Weights for computing vertex normals from facet normals", 1999.
#include "mesh/normals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "mesh/jets.h"
#include "support/error.h"
#include "support/parallel.h"
#include "support/targets.h"

namespace paradesc {

PARADESC_TARGETS(FitGradients, fit_gradients, jet_targets)

namespace {

constexpr int block_size = 1024;
// Limits for the fit, as cosines. Beyond them the fit gives way to the mean of the fan's faces, because a fit suits only smooth
// surfaces. The spread is that of the faces' normals, weighted by area.
constexpr double spread_full = 0.9;              // 26 degrees: up to here the fit alone
constexpr double spread_none = 0.8;              // 37 degrees: from here the faces' mean alone
constexpr double turn_full = 0.9902680687415704; // 8 degrees
constexpr double turn_none = 0.9781476007338057; // 12 degrees
// If neighbors lie off the fit, by noise, steps or detail finer than the mesh, the normal is the mean of all faces around: vector
// areas are linear in positions, so noise cancels, while a fit differentiates it. The first two limits are relative to distances
// of neighbors, the others to their heights, because on a surface that bends by more than that the fit still shows the bending.
constexpr double noise_none = 0.015;
constexpr double noise_full = 0.05;
constexpr double share_none = 0.15;
constexpr double share_full = 0.4;
// Faces that cancel have no mean: the rings of a small closed part hold all of its faces, whose vector areas sum up to rounding.
// The limits are those of the mean's length. On real meshes it is above them.
constexpr double length_none = 0.05;
constexpr double length_full = 0.1;

// ---- Fans -----------------------------------------------------------------------------------------------------------------

dvec3 position(const Triangles &triangles, int vertex) { return dvec3(triangles.positions[vertex]); }

// The two edges of a corner's triangle that start at the corner.
std::pair<dvec3, dvec3> corner_edges(const Triangles &triangles, int corner) {
  const auto vertex = [&](int c) { return position(triangles, triangles.corner_vertex[c]); };
  const dvec3 p = vertex(corner);
  return {vertex(next_corner(corner)) - p, vertex(previous_corner(corner)) - p};
}

// A unit normal, and the root of twice the area: floats hold it at all sizes of a mesh.
struct FaceNormal {
  vec3 normal;
  float size;
};

FaceNormal face_normal(const Triangles &triangles, int face) {
  const auto [a, b] = corner_edges(triangles, 3 * face);
  const dvec3 product = glm::cross(a, b);
  return {vec3(unit_or(product, dvec3(0))), static_cast<float>(std::sqrt(glm::length(product)))};
}

std::vector<FaceNormal> face_normals(const Triangles &triangles, int threads) {
  std::vector<FaceNormal> normals(static_cast<size_t>(triangles.triangle_count));
  parallel_blocks(triangles.triangle_count, threads, 4 * block_size, [&](int begin, int end) {
    for (int t = begin; t < end; ++t) normals[t] = face_normal(triangles, t);
  });
  return normals;
}

std::span<const int32_t> slice(const std::vector<int64_t> &begins, const std::vector<int32_t> &all, int index) {
  const auto begin = static_cast<size_t>(begins[index]);
  return {all.data() + begin, static_cast<size_t>(begins[index + 1]) - begin};
}

struct Sources {
  const Triangles &triangles;
  const NormalRings &rings;
  std::span<const FaceNormal> faces; // of all faces, if normals are fitted
};

// Calls use(a, b, |a|² |b|²) for each face of a fan; a and b are its edges from the fan's own vertex.
void for_each_face(const Sources &from, int fan, const auto &use) {
  const auto vertices = slice(from.rings.fan_begin, from.rings.fan_vertex, fan);
  const dvec3 p = position(from.triangles, vertices[0]);
  dvec3 a = position(from.triangles, vertices[1]) - p;
  double square = glm::dot(a, a);
  for (const int32_t vertex : vertices.subspan(2)) {
    const dvec3 b = position(from.triangles, vertex) - p;
    const double next_square = glm::dot(b, b);
    use(a, b, square * next_square);
    a = b;
    square = next_square;
  }
}

// The mean of |a|² |b|² over a fan's faces.
double mean_squares(const Sources &from, int fan) {
  double sum = 0;
  int count = 0;
  for_each_face(from, fan, [&](dvec3, dvec3, double squares) {
    sum += squares;
    ++count;
  });
  return sum / count;
}

// N. Max's normal: the sum of the faces' vector areas, each over |a|² |b|² of its edges at the vertex. If that product is below
// least_squares, a face counts by area: a sliver whose edge is one rounding long would dominate with a meaningless direction.
dvec3 max_normal(const Sources &from, int fan, double least_squares = 0) {
  dvec3 sum(0);
  for_each_face(from, fan, [&](dvec3 a, dvec3 b, double squares) {
    if (const double most = std::max(squares, least_squares); most > 0) sum += glm::cross(a, b) / most;
  });
  if (const dvec3 normal = unit_or(sum, dvec3(0)); normal != dvec3(0)) return normal;
  dvec3 last(0, 0, 1); // used if the faces cancel out: the normal of the last face that has one
  for_each_face(from, fan, [&](dvec3 a, dvec3 b, double) { last = unit_or(glm::cross(a, b), last); });
  return last;
}

// A smooth step: 1 if value >= full, 0 if value <= none.
double smooth_step(double none, double full, double value) { return paradesc::smooth_step((value - none) / (full - none)); }

// Unit normals of some fans, and the variance of positions around the fits.
struct FanNormals {
  std::vector<vec3> normal;
  std::vector<float> noise; // empty if nothing is fitted
  FanNormals(int count, bool fitted) : normal(static_cast<size_t>(count)), noise(fitted ? normal.size() : 0) {}
};

// Fits fans in lanes, a full set of lanes at a time.
class Fitter {
public:
  Fitter(const Sources &from, FanNormals &fans) : from_(from), fans_(fans) {}
  ~Fitter() { fit(); }
  Fitter(const Fitter &) = delete;
  Fitter &operator=(const Fitter &) = delete;

  // ring, faces: as in NormalRings.
  void add(int fan, std::span<const int32_t> ring, std::span<const int32_t> faces) {
    const dvec3 n = max_normal(from_, fan, mean_squares(from_, fan));
    double spread = 1, length = 1;
    const dvec3 mean = mean_of(faces, n, spread, length);
    const dvec3 e1 = tangent_of(n);
    members_[used_] = {fan, spread, length, 0, 0, n, e1, glm::cross(n, e1), mean};
    take_heights(members_[used_], ring);
    if (++used_ == fan_lanes) fit();
  }

private:
  struct Member {
    int fan;
    double spread, length; // of the mean
    double square, height; // mean squares: of the distances of neighbors, and of their heights
    dvec3 n, e1, e2;
    dvec3 mean; // of the faces of the rings, by their areas
  };

  // The direction of the area-weighted mean of the faces' normals. length: of that mean. spread: that times its cosine with n.
  dvec3 mean_of(std::span<const int32_t> faces, dvec3 n, double &spread, double &length) const {
    dvec3 sum(0);
    double areas = 0;
    for (const int index : faces) {
      const FaceNormal face = from_.faces[index];
      const double area = static_cast<double>(face.size) * static_cast<double>(face.size);
      sum += area * dvec3(face.normal);
      areas += area;
    }
    spread = areas > 0 ? glm::dot(sum, n) / areas : 1;
    length = areas > 0 ? glm::length(sum) / areas : 1;
    return unit_or(sum, n);
  }

  void take_heights(Member &member, std::span<const int32_t> ring) {
    const auto center = static_cast<size_t>(from_.rings.fan_begin[member.fan]);
    const dvec3 p = position(from_.triangles, from_.rings.fan_vertex[center]);
    for (; heights_.max_count < ring.size(); ++heights_.max_count)
      heights_.u[heights_.max_count] = heights_.v[heights_.max_count] = heights_.w[heights_.max_count] = FanLanes{};
    for (size_t i = 0; i < ring.size(); ++i) {
      const dvec3 d = position(from_.triangles, ring[i]) - p;
      heights_.u[i][used_] = glm::dot(d, member.e1);
      heights_.v[i][used_] = glm::dot(d, member.e2);
      const double height = glm::dot(d, member.n);
      heights_.w[i][used_] = height;
      member.square += glm::dot(d, d);
      member.height += height * height;
    }
    member.square /= static_cast<double>(ring.size());
    member.height /= static_cast<double>(ring.size());
    heights_.count[used_] = static_cast<int>(ring.size());
  }

  void fit() {
    if (used_ == 0) return;
    Gradients gradients;
    fit_gradients_(heights_, gradients);
    for (int lane = 0; lane < used_; ++lane) {
      const Member &member = members_[lane];
      fans_.normal[member.fan] =
          vec3(gradients.exists[lane] ? turned(member, {gradients.u[lane], gradients.v[lane]}, gradients.noise[lane]) : member.n);
      fans_.noise[member.fan] = gradients.exists[lane] ? static_cast<float>(gradients.noise[lane]) : 0.0f;
    }
    used_ = 0;
    heights_.max_count = 0;
    std::ranges::fill(heights_.count, 0);
  }

  static dvec3 turned(const Member &member, dvec2 gradient, double noise) {
    const dvec3 n = member.n;
    const dvec3 fitted = glm::normalize(n - gradient.x * member.e1 - gradient.y * member.e2);
    const double weight =
        smooth_step(spread_none, spread_full, member.spread) * smooth_step(turn_none, turn_full, glm::dot(n, fitted));
    const dvec3 smooth = glm::normalize(n + weight * (fitted - n));
    const double rough = smooth_step(noise_none, noise_full, std::sqrt(noise / member.square)) *
                         smooth_step(share_none, share_full, member.height > 0 ? std::sqrt(noise / member.height) : 0.0) *
                         smooth_step(length_none, length_full, member.length);
    return rough > 0 ? unit_or(smooth + rough * (member.mean - smooth), smooth) : smooth;
  }

  const Sources &from_;
  FanNormals &fans_;
  Heights heights_;
  std::array<Member, fan_lanes> members_;
  int used_ = 0;
  FitGradients fit_gradients_ = jet_targets()[0];
};

FanNormals max_normals(const Sources &from, int threads) {
  const int count = from.rings.fan_count;
  FanNormals fans(count, false);
  parallel_blocks(count, threads, block_size, [&](int begin, int end) {
    for (int fan = begin; fan < end; ++fan) fans.normal[fan] = vec3(max_normal(from, fan));
  });
  return fans;
}

FanNormals fitted_normals(const Sources &from, int threads) {
  const NormalRings &rings = from.rings;
  FanNormals fans(rings.fan_count, true);
  parallel_blocks(rings.fan_count, threads, block_size, [&](int begin, int end) {
    Fitter fitter(from, fans);
    for (int fan = begin; fan < end; ++fan)
      fitter.add(fan, slice(rings.ring_begin, rings.ring_vertex, fan), slice(rings.face_begin, rings.face, fan));
  });
  return fans;
}

// Frees each run of rings as soon as its normals are known.
FanNormals fitted_normals_once(const Sources &from, const HalfEdges &half_edges, const FanCorners &corners, int threads) {
  FanNormals fans(from.rings.fan_count, true);
  walk_rings(half_edges, from.rings, corners, threads, [&](const RingRun &run) {
    Fitter fitter(from, fans);
    std::span<const int32_t> vertices = run.vertices, faces = run.faces;
    for (size_t i = 0; i < run.ring_size.size(); ++i) {
      const auto ring_size = static_cast<size_t>(run.ring_size[i]), face_size = static_cast<size_t>(run.face_size[i]);
      const int fan = run.first_fan + static_cast<int>(i);
      fitter.add(fan, vertices.first(ring_size), faces.first(face_size));
      vertices = vertices.subspan(ring_size);
      faces = faces.subspan(face_size);
    }
  });
  return fans;
}

// ---- Corners and points ---------------------------------------------------------------------------------------------------

std::vector<vec3> input_corner_normals(const Triangles &triangles, const HalfEdges &half_edges,
                                       const std::vector<FaceNormal> &faces, int threads) {
  std::vector<vec3> corners(triangles.corner_normal.size());
  parallel_blocks(3 * triangles.triangle_count, threads, 4 * block_size, [&](int begin, int end) {
    for (int corner = begin; corner < end; ++corner) {
      const auto i = static_cast<size_t>(corner);
      if (half_edges.corner_point[i] >= 0)
        corners[i] = vec3(unit_or(dvec3(triangles.corner_normal[i]), dvec3(faces[i / 3].normal)));
    }
  });
  return corners;
}

// The mean, by angle, of the normals of the point's corners; the common normal if they all agree.
vec3 point_normal(const Triangles &triangles, const HalfEdges &half_edges, const Normals &normals, int point) {
  const vec3 first = normals.corner(static_cast<size_t>(half_edges.point_half_edge[point]));
  bool common = true;
  for_each_corner_around(half_edges, point,
                         [&](int32_t corner) { common = common && normals.corner(static_cast<size_t>(corner)) == first; });
  if (common) return first;
  dvec3 sum(0);
  for_each_corner_around(half_edges, point, [&](int32_t corner) {
    sum += surface_angle(triangles, corner) * dvec3(normals.corner(static_cast<size_t>(corner)));
  });
  return vec3(unit_or(sum, dvec3(first)));
}

} // namespace

float Normals::noise_of(int32_t triangle) const {
  if (noise.empty()) return std::numeric_limits<float>::quiet_NaN();
  float sum = 0.0f;
  for (size_t corner = 3 * static_cast<size_t>(triangle), k = 0; k < 3; ++k, ++corner)
    if (const int32_t fan = (*corner_fan)[corner]; fan >= 0) sum += noise[fan];
  return sum / 3.0f;
}

// group: as in Normals. rings: of the fans that group belongs to; null if it belongs to corners.
static Normals with_points(const Triangles &triangles, const HalfEdges &half_edges, std::vector<vec3> group,
                           const NormalRings *rings, int threads) {
  Normals normals;
  normals.group = std::move(group);
  if (rings) normals.corner_fan = rings->corner_fan;
  normals.point.resize(static_cast<size_t>(half_edges.point_count));
  parallel_blocks(half_edges.point_count, threads, 4 * block_size, [&](int begin, int end) {
    for (int point = begin; point < end; ++point) {
      const int32_t fan = rings ? rings->point_fan[point] : -1;
      normals.point[point] = fan >= 0 ? normals.group[fan] : point_normal(triangles, half_edges, normals, point);
    }
  });
  return normals;
}

static Normals given_normals(const Triangles &triangles, const HalfEdges &half_edges, int threads) {
  if (triangles.corner_normal.empty())
    throw Error(PDESC_ERROR_INVALID_OPERATION, "The mesh's own normals were asked for, but it was created without "
                                               "corner_normals: give them, or ask for fitted or Max's normals.");
  std::vector<vec3> corners = input_corner_normals(triangles, half_edges, face_normals(triangles, threads), threads);
  return with_points(triangles, half_edges, std::move(corners), nullptr, threads);
}

// fit(sources) returns the normals of all fans.
template <class Fit>
static Normals fan_normals(const Triangles &triangles, const HalfEdges &half_edges, const NormalRings &rings, int32_t kind,
                           int threads, const Fit &fit) {
  const bool fitted = kind == PDESC_NORMALS_FITTED;
  const std::vector<FaceNormal> faces = fitted ? face_normals(triangles, threads) : std::vector<FaceNormal>();
  const Sources from{triangles, rings, faces};
  FanNormals fans = fitted ? fit(from) : max_normals(from, threads);
  Normals normals = with_points(triangles, half_edges, std::move(fans.normal), &rings, threads);
  normals.noise = std::move(fans.noise);
  return normals;
}

Normals compute_normals(const Triangles &triangles, const HalfEdges &half_edges, const NormalRings &rings, int32_t kind,
                        int threads) {
  if (kind == PDESC_NORMALS_MESH) return given_normals(triangles, half_edges, threads);
  return fan_normals(triangles, half_edges, rings, kind, threads,
                     [&](const Sources &from) { return fitted_normals(from, threads); });
}

Normals compute_normals_once(const Triangles &triangles, const HalfEdges &half_edges, const Creases &creases, int32_t kind,
                             int threads) {
  if (kind == PDESC_NORMALS_MESH) return given_normals(triangles, half_edges, threads);
  NormalRings rings;
  const FanCorners fans = find_fans(triangles, half_edges, creases, rings);
  checkpoint();
  return fan_normals(triangles, half_edges, rings, kind, threads,
                     [&](const Sources &from) { return fitted_normals_once(from, half_edges, fans, threads); });
}

} // namespace paradesc
