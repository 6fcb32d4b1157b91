// Sums the signed volumes of the tetrahedra between each triangle and the middle of the mesh, part by part.
#include "mesh/winding.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "support/cancel.h"
#include "support/parallel.h"

namespace paradesc {
namespace {

constexpr double no_volume = 1e-6; // relative to the part's box: rounding leaves about this much of a part that is folded flat
constexpr size_t most_outer = 64;  // number of the largest parts that others are tested against

// Consecutive triangles of one part.
struct Run {
  int32_t part;
  double volume = 0.0; // six times, and signed
  bool is_closed = true;
};

// Blocks have a fixed size, so that sums do not depend on the number of threads.
std::vector<Run> measure_runs(const Triangles &triangles, const HalfEdges &half_edges, dvec3 middle, int threads) {
  constexpr int block = 65536;
  std::vector<std::vector<Run>> found((triangles.triangle_count + block - 1) / block);
  parallel_blocks(triangles.triangle_count, threads, block, [&](int begin, int end) {
    std::vector<Run> &runs = found[begin / block];
    for (int32_t triangle = begin; triangle < end; ++triangle) {
      const int32_t part = half_edges.triangle_piece[triangle];
      if (part < 0) continue;
      if (runs.empty() || runs.back().part != part) runs.push_back({part});
      const auto corner = [&](int i) { return dvec3(triangles.position(3 * triangle + i)) - middle; };
      runs.back().volume += glm::dot(corner(0), glm::cross(corner(1), corner(2)));
      for (int h = 3 * triangle; h < 3 * triangle + 3; ++h) runs.back().is_closed &= half_edges.twin[h] >= 0;
    }
  });
  std::vector<Run> all;
  for (const std::vector<Run> &runs : found) all.insert(all.end(), runs.begin(), runs.end());
  return all;
}

struct Part {
  double volume = 0.0; // as a run's; 0 of an open part
  Bounds<dvec3> box;

  double size() const { return box.size().x * box.size().y * box.size().z; }
  bool contains(const Part &other) const {
    return glm::all(glm::lessThanEqual(box.low, other.box.low)) && glm::all(glm::greaterThanEqual(box.high, other.box.high));
  }
};

std::vector<Part> measure_parts(const Triangles &triangles, const HalfEdges &half_edges, const Box &box, int threads) {
  std::vector<Part> parts(half_edges.components);
  std::vector<uint8_t> is_open(half_edges.components, 0);
  for (const Run &run : measure_runs(triangles, half_edges, 0.5 * (box.low + box.high), threads)) {
    parts[run.part].volume += run.volume;
    if (!run.is_closed) is_open[run.part] = 1;
  }
  for (size_t i = 0; i < parts.size(); ++i)
    if (is_open[i]) parts[i].volume = 0.0;
  return parts;
}

void measure_boxes(const Triangles &triangles, const HalfEdges &half_edges, std::vector<Part> &parts) {
  for (int32_t corner = 0; corner < 3 * triangles.triangle_count; ++corner) {
    checkpoint_at(corner);
    const int32_t part = half_edges.triangle_piece[corner / 3];
    if (part >= 0) parts[part].box.add(dvec3(triangles.position(corner)));
  }
}

} // namespace

int count_inward_parts(const Triangles &triangles, const HalfEdges &half_edges, const Box &box, int threads) {
  std::vector<Part> parts = measure_parts(triangles, half_edges, box, threads);
  if (std::ranges::none_of(parts, [](const Part &part) { return part.volume < 0; })) return 0;
  measure_boxes(triangles, half_edges, parts);
  std::vector<Part> inward, outward;
  for (const Part &part : parts)
    if (std::abs(part.volume) > no_volume * part.size()) (part.volume < 0 ? inward : outward).push_back(part);
  std::ranges::sort(outward, [](const Part &a, const Part &b) { return a.volume > b.volume; });
  outward.resize(std::min(outward.size(), most_outer));
  return static_cast<int>(std::ranges::count_if(inward, [&](const Part &part) {
    return std::ranges::none_of(outward, [&](const Part &outer) { return outer.volume > -part.volume && outer.contains(part); });
  }));
}

} // namespace paradesc
