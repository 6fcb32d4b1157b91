// Adds up the tetrahedra between each triangle and the middle of the mesh, part by part.
#include "mesh/winding.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "support/cancel.h"

namespace paradesc {
namespace {

constexpr double no_volume = 1e-6; // of the box: what rounding leaves of a part that is folded flat
constexpr size_t most_outer = 64;  // parts, the largest, that others are looked for in

struct Part {
  double volume = 0.0; // six times, and signed
  bool is_closed = true;
  Box box;

  bool contains(const Part &other) const {
    return glm::all(glm::lessThanEqual(box.low, other.box.low)) && glm::all(glm::greaterThanEqual(box.high, other.box.high));
  }
};

std::vector<Part> measure_parts(const Triangles &triangles, const HalfEdges &half_edges, const Box &box) {
  const dvec3 middle = 0.5 * (box.low + box.high);
  std::vector<Part> parts(half_edges.components, {0.0, true, {box.high, box.low}});
  for (int32_t triangle = 0; triangle < triangles.triangle_count; ++triangle) {
    checkpoint_at(triangle);
    const int32_t piece = half_edges.triangle_piece[triangle];
    if (piece < 0 || !parts[piece].is_closed) continue;
    Part &part = parts[piece];
    dvec3 corner[3];
    for (int i = 0; i < 3; ++i) {
      part.is_closed = part.is_closed && half_edges.twin[3 * triangle + i] >= 0;
      const dvec3 p(triangles.position(3 * triangle + i));
      corner[i] = p - middle;
      part.box.low = glm::min(part.box.low, p);
      part.box.high = glm::max(part.box.high, p);
    }
    part.volume += glm::dot(corner[0], glm::cross(corner[1], corner[2]));
  }
  return parts;
}

} // namespace

int count_inward_parts(const Triangles &triangles, const HalfEdges &half_edges, const Box &box) {
  std::vector<Part> inward, outward;
  for (const Part &part : measure_parts(triangles, half_edges, box)) {
    const dvec3 size = part.box.high - part.box.low;
    const double least = no_volume * size.x * size.y * size.z;
    if (!part.is_closed || std::abs(part.volume) <= least) continue;
    (part.volume < 0 ? inward : outward).push_back(part);
  }
  std::ranges::sort(outward, [](const Part &a, const Part &b) { return a.volume > b.volume; });
  outward.resize(std::min(outward.size(), most_outer));
  return static_cast<int>(std::ranges::count_if(inward, [&](const Part &part) {
    return std::ranges::none_of(outward, [&](const Part &outer) { return outer.volume > -part.volume && outer.contains(part); });
  }));
}

} // namespace paradesc
