// Cells and their links → the cells of each center's neighborhood, by a search over links that lie in the ball.
#include "sample/supports.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string>

#include "sample/reach.h"
#include "support/error.h"
#include "support/parallel.h"

namespace paradesc {

// Divided until pieces are small against the radius: the middle of each is a sample.
BareSamples sample_bare_triangles(const Cells &cells, const Triangles &triangles, const Normals &normals,
                                  const BufferFrame &frame, float radius, const MappedSurface *mapped) {
  BareSamples samples;
  samples.begin.push_back(0);
  for (size_t cell = 0; cell + 1 < cells.bare_begin.size(); ++cell) {
    for (int32_t k = cells.bare_begin[cell]; k < cells.bare_begin[cell + 1]; ++k) {
      const auto corner = 3 * static_cast<size_t>(cells.bare[static_cast<size_t>(k)]);
      vec3 p[3];
      for (size_t i = 0; i < 3; ++i)
        p[i] = frame.to_buffer(triangles.positions[static_cast<size_t>(triangles.corner_vertex[corner + i])]);
      const float longest = std::max({length(p[1] - p[0]), length(p[2] - p[1]), length(p[0] - p[2])});
      const int side = std::clamp(static_cast<int>(std::ceil(4.0f * longest / radius)), 1, 16);
      const float area = 0.5f * length(cross(p[1] - p[0], p[2] - p[0])) / static_cast<float>(side * side);
      auto add = [&](float a, float b) { // barycentric coordinates of corners 1 and 2
        if (mapped) {
          const SurfacePoint point = mapped->at(static_cast<int>(corner / 3), a, b);
          samples.point.emplace_back(point.position, area * point.area_ratio);
          samples.point.emplace_back(point.normal, 0.0f);
          return;
        }
        const vec3 n = normals.corner[corner] * (1.0f - a - b) + normals.corner[corner + 1] * a + normals.corner[corner + 2] * b;
        const float span = length(n);
        samples.point.emplace_back(p[0] + (p[1] - p[0]) * a + (p[2] - p[0]) * b, area);
        samples.point.emplace_back(span > 0.0f ? n / span : normals.corner[corner], static_cast<float>(corner / 3));
        samples.weights.emplace_back(a, b);
      };
      for (int i = 0; i < side; ++i)
        for (int j = 0; i + j < side; ++j) {
          const auto step = 1.0f / static_cast<float>(side);
          add((static_cast<float>(i) + 1.0f / 3.0f) * step, (static_cast<float>(j) + 1.0f / 3.0f) * step);
          if (i + j + 1 < side) add((static_cast<float>(i) + 2.0f / 3.0f) * step, (static_cast<float>(j) + 2.0f / 3.0f) * step);
        }
    }
    samples.begin.push_back(static_cast<int32_t>(samples.point.size() / 2));
  }
  return samples;
}

namespace {

// Box around a link's surface points, buffer units.
struct Bounds {
  vec3 low, high;
};

} // namespace

static std::vector<Bounds> link_bounds(const Cells &cells, const std::vector<vec4> &positions, int threads) {
  std::vector<Bounds> bounds(cells.link_begin.size() - 1);
  parallel_blocks(static_cast<int>(bounds.size()), threads, 4096, [&](int begin, int end) {
    for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
      vec3 low(1e30f), high(-1e30f);
      for (int32_t k = cells.link_begin[i]; k < cells.link_begin[i + 1]; ++k) {
        const vec3 point(positions[static_cast<size_t>(cells.link_texel[static_cast<size_t>(k)])]);
        low = glm::min(low, point);
        high = glm::max(high, point);
      }
      bounds[i] = {low, high};
    }
  });
  return bounds;
}

// Squared distance from a point to a box.
static float box_distance(const Bounds &box, vec3 p) {
  const vec3 gap = glm::max(glm::max(box.low - p, p - box.high), vec3(0.0f));
  return dot(gap, gap);
}

namespace {

// The search for one center after another, with its visited marks.
class Search {
public:
  Search(const Cells &cells, const std::vector<Bounds> &links, const std::vector<vec4> &positions, const Triangles &triangles,
         const BufferFrame &frame, float radius)
      : cells_(cells), links_(links), positions_(positions), triangles_(triangles), frame_(frame), radius_(radius),
        visited_(static_cast<size_t>(cells.count), 0), near_(static_cast<size_t>(cells.count), 0) {}

  // Appends the cells of the connected part of the ball.
  void run(const SupportCenter &center, std::vector<int32_t> &found, uint8_t &boundary) {
    ++mark_;
    const size_t begin = found.size();
    add(center.cell, found);
    for (const int32_t site : center.sites) add(cells_.site_cell[static_cast<size_t>(site)], found);
    const size_t starts = found.size() - begin;
    // Finer detail than the radius counts through what lies near: cells there are marked, and sampled four times as finely each
    // way.
    const float near = 0.25f * radius_;
    for (size_t i = begin; i < found.size(); ++i) {
      const auto cell = static_cast<size_t>(found[i]);
      for (int32_t k = cells_.side_begin[cell]; k < cells_.side_begin[cell + 1]; ++k) {
        const ivec2 side = cells_.side[static_cast<size_t>(k)];
        const float distance = box_distance(links_[static_cast<size_t>(side.y)], center.position);
        if (distance < near * near) near_[cell] = mark_;
        if (visited_[static_cast<size_t>(side.x)] != mark_ && distance < radius_ * radius_ && in_ball(side.y, center))
          add(side.x, found);
      }
      for (int32_t k = cells_.boundary_begin[cell]; !boundary && k < cells_.boundary_begin[cell + 1]; ++k) {
        const int half_edge = cells_.boundary[static_cast<size_t>(k)];
        boundary = segment_in_ball(position(half_edge), position(next_corner(half_edge)), center.position, radius_);
      }
    }
    for (size_t i = begin; i < std::min(found.size(), begin + starts); ++i) near_[static_cast<size_t>(found[i])] = mark_;
    std::sort(found.begin() + static_cast<ptrdiff_t>(begin),
              found.end()); // one order of summation, whichever place the search began at
    for (size_t i = begin; i < found.size(); ++i)
      if (near_[static_cast<size_t>(found[i])] == mark_) found[i] = -1 - found[i];
  }

private:
  void add(int32_t cell, std::vector<int32_t> &found) {
    if (cell < 0 || visited_[static_cast<size_t>(cell)] == mark_) return;
    visited_[static_cast<size_t>(cell)] = mark_;
    found.push_back(cell);
  }

  // The surface goes over beside one of the link's texels. No margin: it would let in a neighboring finger as often as it keeps a
  // place that belongs.
  bool in_ball(int32_t link, const SupportCenter &center) const {
    for (int32_t k = cells_.link_begin[static_cast<size_t>(link)]; k < cells_.link_begin[static_cast<size_t>(link) + 1]; ++k) {
      const vec3 gap = vec3(positions_[static_cast<size_t>(cells_.link_texel[static_cast<size_t>(k)])]) - center.position;
      if (dot(gap, gap) < radius_ * radius_) return true;
    }
    return false;
  }

  dvec3 position(int corner) const {
    return dvec3(
        frame_.to_buffer(triangles_.positions[static_cast<size_t>(triangles_.corner_vertex[static_cast<size_t>(corner)])]));
  }

  const Cells &cells_;
  const std::vector<Bounds> &links_;
  const std::vector<vec4> &positions_;
  const Triangles &triangles_;
  const BufferFrame &frame_;
  float radius_;
  std::vector<uint32_t> visited_, near_;
  uint32_t mark_ = 0;
};

} // namespace

[[noreturn]] static void refuse_cells(size_t centers, size_t most) {
  throw Error(PDESC_ERROR_OUT_OF_MEMORY, "The neighborhoods of " + std::to_string(centers) + " places have more than " +
                                             std::to_string(most) +
                                             " pieces of charts, for which there is no memory; use a "
                                             "smaller radius, smaller buffers, or a UV map of fewer charts.");
}

Supports find_supports(const Cells &cells, const std::vector<vec4> &positions, const Triangles &triangles,
                       const BufferFrame &frame, const std::vector<SupportCenter> &centers, float radius, int threads,
                       size_t most) {
  constexpr int block = 512;
  most = std::min<size_t>(most, std::numeric_limits<int32_t>::max());
  std::atomic<size_t> all{0};
  const std::vector<Bounds> links = link_bounds(cells, positions, threads);
  const auto count = static_cast<int>(centers.size());
  Supports supports;
  supports.range.resize(centers.size());
  supports.boundary.assign(centers.size(), 0);
  std::vector<std::vector<int32_t>> found(static_cast<size_t>((count + block - 1) / block));
  parallel_blocks(count, threads, block, [&](int begin, int end) {
    Search search(cells, links, positions, triangles, frame, radius);
    auto &list = found[static_cast<size_t>(begin / block)];
    for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
      const auto first = static_cast<int32_t>(list.size());
      search.run(centers[i], list, supports.boundary[i]);
      if ((all += list.size() - static_cast<size_t>(first)) > most) refuse_cells(centers.size(), most);
      supports.range[i] = ivec2(first, static_cast<int32_t>(list.size()) - first);
    }
  });
  for (size_t i = 0; i < found.size(); ++i) {
    const auto offset = static_cast<int32_t>(supports.cell.size());
    const size_t last = std::min(centers.size(), (i + 1) * block);
    for (size_t k = i * block; k < last; ++k) supports.range[k].x += offset;
    supports.cell.insert(supports.cell.end(), found[i].begin(), found[i].end());
  }
  return supports;
}

} // namespace paradesc
