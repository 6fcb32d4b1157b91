// Corners whose normals are clearly above rounding are handled in floats, four faces at a time; the others in doubles.
#include "mesh/steady_faces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "support/angle.h"
#include "support/parallel.h"

namespace paradesc {

namespace {

constexpr int lanes = 4;
using Floats [[gnu::vector_size(lanes * sizeof(float))]] = float;
struct Vectors {
  Floats x, y, z;
};

Vectors operator-(const Vectors &a, const Vectors &b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vectors cross(const Vectors &a, const Vectors &b) {
  return {a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y};
}
Floats square(const Vectors &a) { return a.x * a.x + a.y * a.y + a.z * a.z; }
Floats larger(const Floats &a, const Floats &b) { return a < b ? b : a; }

bool is_needle(const Triangles &triangles, int index) {
  const Face face(triangles, index);
  return face.is_needle(face.product());
}

// The longest edge of the face other than `other`.
int longest_edge(const Triangles &triangles, int face, int other) {
  int longest = -1;
  double most = -1;
  for (int corner = 3 * face; corner < 3 * face + 3; ++corner) {
    const dvec3 edge = along(triangles, corner);
    if (corner != other && glm::dot(edge, edge) > most) {
      most = glm::dot(edge, edge);
      longest = corner;
    }
  }
  return longest;
}

} // namespace

Face::Face(const Triangles &triangles, int face)
    : a(triangles.position(3 * face)), b(triangles.position(3 * face + 1)), c(triangles.position(3 * face + 2)) {}

bool Face::is_needle(dvec3 product) const {
  const auto square = [](dvec3 v) { return glm::dot(v, v); };
  const double longest2 = std::max({square(b - a), square(c - b), square(a - c)});
  const dvec3 most = glm::max(glm::max(glm::abs(a), glm::abs(b)), glm::abs(c));
  const double largest = std::max({most.x, most.y, most.z});
  return glm::dot(product, product) < ROUNDING * ROUNDING * largest * largest * longest2;
}

int steady_face(const Triangles &triangles, const HalfEdges &half_edges, int face) {
  constexpr int most_steps = 8; // several steps, because needles lie beside needles
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

static void round_some(const Triangles &triangles, const HalfEdges &half_edges, int begin, int end, std::span<vec3> normals) {
  constexpr float least_sine = 0.1f, least_square = 1e-30f; // limits below which floats keep too few digits
  constexpr auto rounding = static_cast<float>(4 * ROUNDING);
  for (int first = begin; first < end; first += lanes) {
    const auto corner = [&](int k) {
      Vectors corners;
      for (int i = 0; i < lanes; ++i) {
        const vec3 &position = triangles.position(3 * std::min(first + i, end - 1) + k);
        corners.x[i] = position.x;
        corners.y[i] = position.y;
        corners.z[i] = position.z;
      }
      return corners;
    };
    const Vectors a = corner(0), b = corner(1), c = corner(2), product = cross(b - a, c - a);
    const Floats left = square(b - a), right = square(c - a), area = square(product);
    const Floats farthest = rounding * rounding * larger(larger(square(a), square(b)), square(c));
    const Floats doubtful =
        larger(larger(least_sine * least_sine * left * right, farthest * (left + right)), Floats{} + least_square);
    Floats length;
    for (int i = 0; i < lanes; ++i) length[i] = std::sqrt(area[i]);
    const Vectors unit{product.x / length, product.y / length, product.z / length};
    for (int i = 0; i < lanes && first + i < end; ++i) {
      const bool plain = area[i] > doubtful[i] && area[i] <= std::numeric_limits<float>::max();
      normals[first + i] = plain ? vec3(unit.x[i], unit.y[i], unit.z[i]) : vec3(steady_normal(triangles, half_edges, first + i));
    }
  }
}

// The vector area of the faces around a point. It does not change when the point moves among its neighbors.
static dvec3 area_around(const Triangles &triangles, const HalfEdges &half_edges, int point) {
  dvec3 area(0);
  for_each_corner_around(half_edges, point, [&](int32_t corner) { area += Face(triangles, corner / 3).product(); });
  return area;
}

// The direction of the surface around a folded face, for instance one with a vertex that has moved past the opposite edge.
static std::optional<vec3> unfolded(const Triangles &triangles, const HalfEdges &half_edges, int face, dvec3 normal) {
  dvec3 sum(0);
  for (int corner = 3 * face; corner < 3 * face + 3; ++corner) {
    const dvec3 area = area_around(triangles, half_edges, half_edges.corner_point[corner]);
    if (glm::dot(area, normal) >= 0) return std::nullopt;
    sum += area;
  }
  return vec3(glm::normalize(sum));
}

static void unfold(const Triangles &triangles, const HalfEdges &half_edges, std::span<vec3> normals, int threads, int block) {
  std::vector<std::vector<std::pair<int, vec3>>> folded(static_cast<size_t>(triangles.triangle_count / block + 1));
  parallel_blocks(triangles.triangle_count, threads, block, [&](int begin, int end) {
    for (int t = begin; t < end; ++t) {
      const auto turns_back = [&](int h) {
        const int32_t twin = half_edges.twin[h];
        return twin >= 0 && glm::dot(normals[t], normals[twin / 3]) < 0;
      };
      if (!(turns_back(3 * t) || turns_back(3 * t + 1) || turns_back(3 * t + 2))) continue;
      if (const auto normal = unfolded(triangles, half_edges, t, dvec3(normals[t])))
        folded[begin / block].emplace_back(t, *normal);
    }
  });
  for (const auto &some : folded)
    for (const auto &[t, normal] : some) normals[t] = normal;
}

void round_steady_normals(const Triangles &triangles, const HalfEdges &half_edges, std::span<vec3> normals, int threads) {
  constexpr int block = 1024;
  parallel_blocks(triangles.triangle_count, threads, block,
                  [&](int begin, int end) { round_some(triangles, half_edges, begin, end, normals); });
  unfold(triangles, half_edges, normals, threads, block);
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

} // namespace paradesc
