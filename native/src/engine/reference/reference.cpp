// Points of the mesh → descriptors by exact quadrature: floods the surface within the ball, integrates over triangle ∩ ball, and
// applies the definitions literally.
#include "engine/reference/reference.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <optional>

#include "kernel/limits.h"
#include "mesh/quadrature.h"
#include "support/cancel.h"
#include "support/error.h"
#include "support/parallel.h"
#include "support/pool.h"

namespace paradesc {
namespace {

constexpr double undefined = std::numeric_limits<double>::quiet_NaN();
constexpr int block_size = 16;
constexpr double nearest = 1e-9; // of the radius: samples nearer than this have no direction

struct Surface {
  const Triangles &triangles;
  const HalfEdges &half_edges;
  const Normals &normals;
  const std::vector<vec4> *map; // (point_count) or null
};

// ---- Integrals over one triangle --------------------------------------------------------------------------------------------

// A triangle relative to p, its normals linear from corner to corner.
struct Patch {
  std::array<dvec3, 3> corners, normals;
  std::array<dvec4, 3> map{};
  double noise = 0; // variance of the positions along normals
  int center = -1;  // the corner at p, or -1
};

struct Center {
  dvec3 normal, tangent, bitangent;
  double radius;
  bool geodesic_ball;
  bool windows; // the windows are summed, too
  bool with_map;
  dvec4 map; // at p
  double map_radius, sigma;
};

// Moments of tangent coordinates x of d and y of n_i - n.
struct Fit {
  double xx = 0, xy = 0, yy = 0;
  double m11 = 0, m12 = 0, m22 = 0; // of x yT, m12 symmetrized
  void add(dvec2 x, dvec2 y, double weight) {
    xx += weight * x.x * x.x;
    xy += weight * x.x * x.y;
    yy += weight * x.y * x.y;
    m11 += weight * x.x * y.x;
    m12 += weight * (x.x * y.y + x.y * y.x);
    m22 += weight * x.y * y.y;
  }
};

// Sums over samples.
struct Moments {
  double area = 0, rho = 0, height = 0, bending = 0;
  double noise = 0, facets = 0; // of w: variance of the positions along normals; area of the triangle
  double strip = 0;             // area within the ball and beyond r along the surface
  Fit ball;
  Fit wide, narrow; // windows 1 - t and (1 - t)^2, t = (distance/r)^2
  WindowMoments window;
};

void add_sample(Moments &moments, const Center &center, dvec3 d, dvec3 n, double weight) {
  const double rho2 = glm::dot(d, d);
  const double rho = std::sqrt(rho2);
  const dvec3 turn = n / glm::length(n) - center.normal;
  const dvec2 x(glm::dot(d, center.tangent), glm::dot(d, center.bitangent));
  const dvec2 y(glm::dot(turn, center.tangent), glm::dot(turn, center.bitangent));
  moments.area += weight;
  moments.rho += weight * rho;
  moments.height += weight * glm::dot(center.normal, d);
  if (rho > nearest * center.radius) moments.bending += weight * glm::dot(turn, turn) / rho2;
  moments.ball.add(x, y, weight);
  if (!center.windows) return;
  const double bend = center.geodesic_ball ? glm::dot(turn, d) / std::max(rho2, 1e-300) : 0.0;
  const double distance = rho * (1 + bend * bend * rho2 / 24) / center.radius, window = std::max(1 - distance * distance, 0.0);
  moments.wide.add(x, y, weight * window);
  moments.narrow.add(x, y, weight * window * window);
}

// Turns a tangent vector v at normal m into the tangent plane of n.
dvec3 turn_to(dvec3 n, dvec3 m, dvec3 v) { return v - (n + m) * (glm::dot(n, v) / std::max(1 + glm::dot(n, m), LEAST_TURN)); }

void add_map_sample(Moments &moments, const Center &center, dvec3 d, dvec3 n, dvec4 map, double weight) {
  if (std::isnan(map.w)) return; // the map does not exist there
  const auto flat = [&](dvec3 v) { return dvec2(glm::dot(v, center.tangent), glm::dot(v, center.bitangent)); };
  add_window_sample(moments.window,
                    {flat(d) / center.radius, glm::length(d), map.w - center.map.w,
                     center.map_radius * flat(turn_to(center.normal, n, dvec3(map))), weight},
                    center.sigma);
}

// shrink: factor that moves the sample towards the center.
void add_barycentric(Moments &moments, const Center &center, const Patch &patch, double b, double c, double weight,
                     double shrink = 1) {
  const auto at = [&](const auto &v) { return v[0] + b * (v[1] - v[0]) + c * (v[2] - v[0]); };
  const dvec3 d = shrink * at(patch.corners);
  add_sample(moments, center, d, at(patch.normals), weight);
  if (center.with_map) add_map_sample(moments, center, d, glm::normalize(at(patch.normals)), at(patch.map), weight);
}

// Exact for polynomials of degree 5 (Radon), or of degree 2 if tiny.
void add_whole_triangle(Moments &moments, const Center &center, const Patch &patch, double area, bool tiny) {
  const auto add_three = [&](double b, double weight) {
    add_barycentric(moments, center, patch, b, b, weight * area);
    add_barycentric(moments, center, patch, 1 - 2 * b, b, weight * area);
    add_barycentric(moments, center, patch, b, 1 - 2 * b, weight * area);
  };
  if (tiny) return add_three(1.0 / 6, 1.0 / 3);
  constexpr double root = 3.872983346207417; // sqrt(15)
  add_barycentric(moments, center, patch, 1.0 / 3, 1.0 / 3, 0.225 * area);
  add_three((6 - root) / 21, (155 - root) / 1200);
  add_three((6 + root) / 21, (155 + root) / 1200);
}

// At the ball's rim: the strip between the rim and the curve where the distance along the surface, s = rho (1 + (kappa
// rho)^2/24), is r. Its area per angle around the foot of p on the triangle's plane is (r^2 - rho_s^2)/2, wherever that foot
// lies, but at most that of the disk in which the plane cuts the ball. disc2: the squared radius of that disk.
void add_strip(Moments &moments, const Center &center, const Patch &patch, double b, double c, double angle, double disc2) {
  const auto at = [&](const std::array<dvec3, 3> &v) { return v[0] + b * (v[1] - v[0]) + c * (v[2] - v[0]); };
  const dvec3 d = at(patch.corners), n = at(patch.normals);
  const double r = center.radius;
  const double bend = glm::dot(n / glm::length(n) - center.normal, d) / r;
  const double inner = r / (1 + bend * bend / 24);
  const double area = 0.5 * std::min(r * r - inner * inner, disc2) * angle;
  moments.strip += area;
  if (center.geodesic_ball) add_barycentric(moments, center, patch, b, c, -area, 0.5 * (1 + inner / r));
}

void add_cut_triangle(Moments &moments, const Center &center, const Patch &patch, dvec3 cross_product, const GaussRule &rule) {
  const auto &[a, b, c] = patch.corners;
  const double twice_area = glm::length(cross_product);
  const dvec3 up = cross_product / twice_area;
  const double elevation = glm::dot(up, patch.corners[std::max(patch.center, 0)]);
  const double disc2 = center.radius * center.radius - elevation * elevation;
  if (!(disc2 > 0)) return;
  const dvec3 e1 = glm::normalize(b - a), e2 = glm::cross(up, e1);
  const auto flat = [&](dvec3 v) { return dvec2(glm::dot(v, e1), glm::dot(v, e2)); };
  const std::array<dvec2, 3> corners{flat(a), flat(b), flat(c)};
  const DiscRegion region = clip_by_disc(corners, std::sqrt(disc2));
  const dvec2 star = patch.center >= 0 ? corners[patch.center] : nearest_to_origin(corners);
  const dvec2 ab = corners[1] - corners[0], ac = corners[2] - corners[0];
  visit_region(region, star, rule, [&](dvec2 x, double weight) {
    const dvec2 from_a = x - corners[0];
    add_barycentric(moments, center, patch, cross(from_a, ac) / twice_area, cross(ab, from_a) / twice_area, weight);
  });
  visit_arcs(region, rule, [&](dvec2 x, double angle) {
    const dvec2 from_a = x - corners[0];
    add_strip(moments, center, patch, cross(from_a, ac) / twice_area, cross(ab, from_a) / twice_area, angle, disc2);
  });
}

// Nearer triangles get finer rules, because the integrands vary with direction and as 1/rho^2.
void add_triangle(Moments &moments, const Center &center, const Patch &patch) {
  const auto &[a, b, c] = patch.corners;
  const dvec3 cross_product = glm::cross(b - a, c - a);
  const double area = 0.5 * glm::length(cross_product);
  if (!(area > 0)) return;
  const double farthest = std::max({glm::dot(a, a), glm::dot(b, b), glm::dot(c, c)});
  const double size2 = std::max({glm::dot(b - a, b - a), glm::dot(c - b, c - b), glm::dot(a - c, a - c)});
  const dvec3 middle = (a + b + c) / 3.0;
  const double nearness = patch.center >= 0 ? 10 : std::sqrt(size2 / std::max(glm::dot(middle, middle), 1e-300));
  if (farthest <= center.radius * center.radius && nearness < 0.5)
    return add_whole_triangle(moments, center, patch, area, nearness < 0.05);
  const int points = nearness < 0.1 ? 2 : nearness < 0.3 ? 3 : nearness < 0.7 ? 4 : nearness < 1.5 ? 6 : 8;
  add_cut_triangle(moments, center, patch, cross_product, gauss_rule(points));
}

// ---- The neighborhood -------------------------------------------------------------------------------------------------------

// The standard error of H for independent noise of the vertices. By Gauss's theorem H is a sum of heights z, 2 z over the ball
// less r z along its rim, both blurred as normals are. The extrapolated estimator has no rim, and 48 times the variance.
double standard_error(const Moments &moments, const Center &center) {
  const double r = center.radius;
  const double vertex = 2 * moments.facets / moments.area, variance = moments.noise / moments.area * vertex;
  const double blurred = r * r + BLUR_OF_NORMALS * vertex, rim = r / std::sqrt(BLUR_OF_NORMALS * 4 * vertex);
  return std::sqrt(16 / pi * NOISE_SHARE * variance * (center.windows ? 48 : 1 + rim) / blurred) / blurred;
}

// Least squares for a symmetric S: X S + S X = M + MT, which are three separate equations in the principal frame of X. S is xx,
// xy, yy.
std::optional<dvec3> fitted(const Fit &fit) {
  constexpr double least_ratio = 1e-6; // of the extents across and along; a thinner neighborhood does not determine S
  const double angle = 0.5 * std::atan2(2 * fit.xy, fit.xx - fit.yy);
  const double c = std::cos(angle), s = std::sin(angle);
  const double along = c * c * fit.xx + 2 * c * s * fit.xy + s * s * fit.yy;
  const double across = s * s * fit.xx - 2 * c * s * fit.xy + c * c * fit.yy;
  if (!(across > least_ratio * along)) return {};
  const double m11 = c * c * fit.m11 + c * s * fit.m12 + s * s * fit.m22;
  const double m22 = s * s * fit.m11 - c * s * fit.m12 + c * c * fit.m22;
  const double m12 = (c * c - s * s) * fit.m12 + 2 * c * s * (fit.m22 - fit.m11);
  const double s11 = m11 / along, s22 = m22 / across, s12 = m12 / (along + across);
  return dvec3(c * c * s11 - 2 * c * s * s12 + s * s * s22, c * s * (s11 - s22) + (c * c - s * s) * s12,
               s * s * s11 + 2 * c * s * s12 + c * c * s22);
}

// Uses the ball alone; or both windows, which blur by half and two fifths of what the rim of a ball alone would.
std::optional<dvec3> shape_operator(const Moments &moments, bool windows) {
  if (!windows) return fitted(moments.ball);
  const auto wide = fitted(moments.wide), narrow = fitted(moments.narrow);
  if (!wide || !narrow) return {};
  return 5.0 * *narrow - 4.0 * *wide;
}

void find_curvatures(const Moments &moments, const Center &center, ReferenceNeighborhood &neighborhood) {
  neighborhood.k1 = neighborhood.k2 = neighborhood.mean = neighborhood.gauss = undefined;
  neighborhood.direction_max = neighborhood.direction_min = dvec3(undefined);
  neighborhood.standard_error = undefined;
  const std::optional<dvec3> shape = shape_operator(moments, center.windows);
  if (!shape) return;
  neighborhood.standard_error = standard_error(moments, center);
  const double mean = 0.5 * (shape->x + shape->z), gap = 0.5 * (shape->x - shape->z), half_difference = std::hypot(gap, shape->y);
  neighborhood.k1 = mean + half_difference;
  neighborhood.k2 = mean - half_difference;
  neighborhood.mean = mean;
  neighborhood.gauss = neighborhood.k1 * neighborhood.k2;
  const double turn = 0.5 * std::atan2(shape->y, gap); // from the tangent to the direction of k1
  neighborhood.direction_max = std::cos(turn) * center.tangent + std::sin(turn) * center.bitangent;
  neighborhood.direction_min = glm::cross(center.normal, neighborhood.direction_max);
}

// Paper eq. (8).
double ball_mean_curvature(const ReferenceNeighborhood &neighborhood) {
  return neighborhood.rho > 0 ? -8.0 / (3.0 * neighborhood.radius) * neighborhood.height / neighborhood.rho : undefined;
}

// H, K, k1 and k2 by paper eq. (8), (11) and (10).
void take_integrals(ReferenceNeighborhood &neighborhood) {
  const double r = neighborhood.radius, square = r * r;
  neighborhood.mean = ball_mean_curvature(neighborhood);
  neighborhood.gauss = 12.0 * (pi * square - neighborhood.geodesic_area) / (pi * square * square);
  const double root = std::sqrt(std::max(neighborhood.mean * neighborhood.mean - neighborhood.gauss, 0.0));
  neighborhood.k1 = neighborhood.mean + root;
  neighborhood.k2 = neighborhood.mean - root;
}

// Returns whether the segment from a to b comes nearer to the origin than the radius.
bool meets_ball(dvec3 a, dvec3 b, double radius) {
  const dvec3 edge = b - a;
  const double length2 = glm::dot(edge, edge);
  const double t = length2 > 0 ? std::clamp(-glm::dot(a, edge) / length2, 0.0, 1.0) : 0;
  const dvec3 foot = a + t * edge;
  return glm::dot(foot, foot) < radius * radius;
}

// The connected part of the surface within the ball, for one point after another. Stamps live as long as the flood.
class Flood {
public:
  explicit Flood(const Surface &surface) : surface_(surface), stamp_(static_cast<size_t>(surface.triangles.triangle_count), -1) {}

  ReferenceNeighborhood measure(int point, const ReferenceSettings &settings) {
    const double radius = settings.radius;
    start(point, settings);
    Moments moments;
    ReferenceNeighborhood neighborhood;
    for (int face; !stack_.empty();) {
      face = stack_.back();
      stack_.pop_back();
      const Patch patch = patch_of(face);
      if (cross_edges(face, patch, radius)) neighborhood.boundary = true;
      const double before = moments.area;
      add_triangle(moments, center_, patch);
      const auto &[a, b, c] = patch.corners;
      moments.noise += (moments.area - before) * patch.noise;
      moments.facets += (moments.area - before) * 0.5 * glm::length(glm::cross(b - a, c - a));
    }
    neighborhood.radius = radius;
    neighborhood.area = moments.area;
    neighborhood.rho = moments.rho;
    neighborhood.height = moments.height;
    neighborhood.bending = moments.bending;
    neighborhood.geodesic_area = moments.area - (settings.geodesic_ball ? 0.0 : moments.strip);
    find_curvatures(moments, center_, neighborhood);
    if (settings.estimator == PDESC_ESTIMATOR_INTEGRAL) take_integrals(neighborhood);
    if (!center_.with_map) return neighborhood;
    neighborhood.window = finish_window(moments.window, center_.tangent, center_.bitangent, radius);
    neighborhood.window.harris_k = settings.harris_k;
    if (std::isnan(center_.map.w)) neighborhood.window.tensor = dvec3(undefined);
    return neighborhood;
  }

private:
  void start(int point, const ReferenceSettings &settings) {
    point_ = point;
    ++mark_;
    const auto i = static_cast<size_t>(point);
    position_ = dvec3(surface_.triangles.positions[surface_.half_edges.point_vertex[i]]);
    const dvec3 n = glm::normalize(dvec3(surface_.normals.point[i]));
    const dvec3 tangent = tangent_of(n);
    const bool with_map = surface_.map != nullptr;
    center_ = {n,
               tangent,
               glm::cross(n, tangent),
               settings.radius,
               settings.geodesic_ball,
               settings.estimator == PDESC_ESTIMATOR_EXTRAPOLATED,
               with_map,
               with_map ? dvec4((*surface_.map)[i]) : dvec4(0),
               settings.map_radius,
               settings.map_sigma};
    stack_.clear();
    for_each_corner_around(surface_.half_edges, point, [&](int32_t corner) { enter(corner / 3); });
  }

  void enter(int face) {
    int &stamp = stamp_[face];
    if (stamp == mark_) return;
    stamp = mark_;
    stack_.push_back(face);
  }

  Patch patch_of(int face) const {
    Patch patch;
    patch.noise = static_cast<double>(surface_.normals.noise_of(face));
    for (size_t k = 0; k < 3; ++k) {
      const size_t corner = 3 * static_cast<size_t>(face) + k;
      const int vertex = surface_.triangles.corner_vertex[corner];
      patch.corners[k] = dvec3(surface_.triangles.positions[vertex]) - position_;
      patch.normals[k] = dvec3(surface_.normals.corner(corner));
      const int point = surface_.half_edges.corner_point[corner];
      if (point == point_) patch.center = static_cast<int>(k);
      if (center_.with_map) patch.map[k] = dvec4((*surface_.map)[point]);
    }
    return patch;
  }

  // Enters the triangles across edges that meet the ball; returns true if one of these edges has no other side.
  bool cross_edges(int face, const Patch &patch, double radius) {
    bool boundary = false;
    for (size_t k = 0; k < 3; ++k) {
      if (!meets_ball(patch.corners[k], patch.corners[(k + 1) % 3], radius)) continue;
      const int twin = surface_.half_edges.twin[3 * static_cast<size_t>(face) + k];
      if (twin >= 0)
        enter(twin / 3);
      else
        boundary = true;
    }
    return boundary;
  }

  const Surface &surface_;
  std::vector<int32_t> stamp_, stack_;
  int point_ = -1;
  int32_t mark_ = 0; // of this flood
  dvec3 position_{0};
  Center center_{};
};

// ---- All points -------------------------------------------------------------------------------------------------------------

void store(double value, float *out) { *out = static_cast<float>(value); }
void store(dvec3 value, float *out) {
  for (int i = 0; i < 3; ++i) out[i] = static_cast<float>(value[i]);
}

struct Row {
  size_t components;
  void (*write)(const ReferenceNeighborhood &, float *out);
};
constexpr Row rows[] = {
#define DESCRIPTOR(name, label, description, power, is_signed, neutral, low, high, components, terms)                            \
  {components, [](const ReferenceNeighborhood &neighborhood, float *out) { store(reference_##name(neighborhood), out); }},
#include "descriptor/descriptors.def"
#undef DESCRIPTOR
#define OPERATOR(name, label, description, power, degree, needs, is_signed, neutral, low, high, components, terms)               \
  {components, [](const ReferenceNeighborhood &neighborhood, float *out) { store(reference_##name(neighborhood), out); }},
#include "descriptor/operators.def"
#undef OPERATOR
};

} // namespace

ReferenceField compute_reference(const Triangles &triangles, const HalfEdges &half_edges, const Normals &normals,
                                 const ReferenceSettings &settings, std::span<const int> descriptors, int threads,
                                 const std::function<void(double)> &progress) {
  const Surface surface{triangles, half_edges, normals, settings.map};
  const auto count = static_cast<size_t>(half_edges.point_count);
  ReferenceField field;
  for (const int row : descriptors) field.values.emplace_back(count * rows[row].components, static_cast<float>(undefined));
  field.boundary.resize(count);
  Pool<Flood> floods;
  const bool all = settings.points.empty();
  const int requested = all ? half_edges.point_count : static_cast<int>(settings.points.size());
  std::atomic<int> done{0};
  const CancelScope cancel([&] {
    if (progress) progress(static_cast<double>(done) / requested);
  });
  parallel_blocks(requested, threads, block_size, [&](int begin, int end) {
    floods.with_one([&] { return Flood(surface); },
                    [&](Flood &flood) {
                      for (int i = begin; i < end; ++i) {
                        const int point = all ? i : settings.points[i];
                        const ReferenceNeighborhood neighborhood = flood.measure(point, settings);
                        for (size_t k = 0; k < descriptors.size(); ++k) {
                          const Row &row = rows[descriptors[k]];
                          row.write(neighborhood, &field.values[k][static_cast<size_t>(point) * row.components]);
                        }
                        field.boundary[point] = neighborhood.boundary;
                        ++done;
                        checkpoint();
                      }
                    });
  });
  return field;
}

} // namespace paradesc
