// Cells and their links → the ranges of samples of each center's neighborhood.
#include "sample/neighborhoods.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>
#include <string>

#include "sample/cell_search.h"
#include "support/error.h"
#include "support/parallel.h"

namespace paradesc {

// Triangles are divided until pieces are small against the radius; the middle of each piece is a sample.
TexellessSamples sample_texelless_triangles(const Cells &cells, const Triangles &triangles, const Normals &normals,
                                            const BakeSpace &bake_space, float radius, const DisplacedSurface *displaced) {
  TexellessSamples samples;
  samples.begin.push_back(0);
  for (size_t cell = 0; cell + 1 < cells.texelless_begin.size(); ++cell) {
    for (int32_t k = cells.texelless_begin[cell]; k < cells.texelless_begin[cell + 1]; ++k) {
      const auto corner = 3 * static_cast<size_t>(cells.texelless[k]);
      vec3 p[3];
      for (size_t i = 0; i < 3; ++i) p[i] = bake_space.to_buffer(triangles.positions[triangles.corner_vertex[corner + i]]);
      const float longest = std::max({length(p[1] - p[0]), length(p[2] - p[1]), length(p[0] - p[2])});
      // Limited before it becomes an integer: radii may be as small as floats are.
      const int side = static_cast<int>(std::fmax(1.0f, std::fmin(std::ceil(4.0f * longest / radius), 16.0f)));
      const float area = 0.5f * length(cross(p[1] - p[0], p[2] - p[0])) / static_cast<float>(side * side);
      auto add = [&](float a, float b) { // barycentric coordinates of corners 1 and 2
        if (displaced) {
          const SurfacePoint point = displaced->at(static_cast<int>(corner / 3), a, b);
          samples.samples.push_back({point.position, area * point.area_ratio, point.normal, 0});
          return;
        }
        const vec3 n = normals.corner(corner) * (1.0f - a - b) + normals.corner(corner + 1) * a + normals.corner(corner + 2) * b;
        const float span = length(n);
        samples.samples.push_back({p[0] + (p[1] - p[0]) * a + (p[2] - p[0]) * b, area,
                                   span > 0.0f ? n / span : normals.corner(corner), static_cast<int32_t>(corner / 3)});
        samples.weights.emplace_back(a, b);
      };
      for (int i = 0; i < side; ++i)
        for (int j = 0; i + j < side; ++j) {
          const auto step = 1.0f / static_cast<float>(side);
          add((static_cast<float>(i) + 1.0f / 3.0f) * step, (static_cast<float>(j) + 1.0f / 3.0f) * step);
          if (i + j + 1 < side) add((static_cast<float>(i) + 2.0f / 3.0f) * step, (static_cast<float>(j) + 2.0f / 3.0f) * step);
        }
    }
    samples.begin.push_back(static_cast<int32_t>(samples.samples.size()));
  }
  return samples;
}

void Neighborhoods::permute(const std::vector<int32_t> &order_now) {
  std::vector<NeighborhoodRanges> ordered;
  ordered.reserve(center.size());
  for (const int32_t i : order_now) ordered.push_back(center[i]);
  center.swap(ordered);
}

namespace {

// The ranges of some centers, before they are joined to one list.
struct Part {
  std::vector<ivec2> range;
  std::vector<int32_t> left; // centers that have to search by themselves
};

} // namespace

static std::vector<Bounds> link_bounds(const Cells &cells, const std::vector<vec3> &points, int threads) {
  std::vector<Bounds> bounds(cells.link_begin.size() - 1);
  parallel_blocks(static_cast<int>(bounds.size()), threads, 4096, [&](int begin, int end) {
    for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
      vec3 low(1e30f), high(-1e30f);
      for (int32_t k = cells.link_begin[i]; k < cells.link_begin[i + 1]; ++k) {
        low = glm::min(low, points[k]);
        high = glm::max(high, points[k]);
      }
      bounds[i] = {low, high};
    }
  });
  return bounds;
}

// The cells, with spheres and cones that enclose the samples of their texelless triangles as well.
static std::vector<CellData> with_texelless_samples(const SearchSpace &space) {
  std::vector<CellData> cells(space.measured.begin(), space.measured.end());
  for (size_t cell = 0; cell + 1 < space.texelless.begin.size(); ++cell)
    for (int32_t k = space.texelless.begin[cell]; k < space.texelless.begin[cell + 1]; ++k) {
      const TexellessSample &sample = space.texelless.samples[static_cast<size_t>(k)];
      CellData &data = cells[cell];
      if (data.sphere.w < 0.0f) {
        data.sphere = vec4(sample.position, 0.0f);
        data.cone = vec4(sample.normal, 1.0f);
      }
      data.sphere.w = std::max(data.sphere.w, length(sample.position - vec3(data.sphere)));
      data.cone.w = std::min(data.cone.w, dot(vec3(data.cone), sample.normal));
    }
  return cells;
}

static std::vector<CellLeaves> list_leaves(const SearchSpace &space, float radius, int threads) {
  const int side = space.cells.block_size / 2;
  std::vector<CellLeaves> leaves(space.measured.size());
  parallel_blocks(static_cast<int>(leaves.size()), threads, 4096, [&](int begin, int end) {
    for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i)
      leaves[i] = leaves_of(space.measured[i], space.samples.strides, i, side * side, radius);
  });
  return leaves;
}

// The cell from which a center's group searches, or -1.
static int32_t start_of(const Cells &cells, const SearchCenter &center) {
  if (center.cell >= 0) return center.cell;
  for (const int32_t wedge : center.wedges)
    if (const int32_t cell = cells.wedge_cell[wedge]; cell >= 0) return cell;
  return -1;
}

namespace {

// Centers by the square that they start in: a block, or two by two or four by four where these are small against the radius.
struct Groups {
  std::vector<int32_t> start; // (centers) cell, or -1
  std::vector<int32_t> order; // centers
  std::vector<int32_t> begin; // (groups + 1) into order; the first: those that start nowhere
};

} // namespace

static Groups group(const Cells &cells, std::span<const CellData> measured, const std::vector<SearchCenter> &centers,
                    float radius) {
  double spheres = 0.0;
  for (const CellData &cell : measured) spheres += static_cast<double>(std::max(cell.sphere.w, 0.0f));
  const double radii = static_cast<double>(radius) * static_cast<double>(measured.size()) / std::max(spheres, 1e-30);
  const int width = (radii > 4.4 ? 4 : radii > 2.6 ? 2 : 1) * cells.block_size; // at most about the radius
  int across = 1;
  for (const ivec4 box : cells.box) across = std::max({across, box.x / width + 1, box.y / width + 1});
  auto square_of = [&](int32_t cell) {
    if (cell < 0) return 0;
    const ivec4 box = cells.box[cell];
    return 1 + box.y / width * across + box.x / width;
  };
  Groups groups;
  groups.start.resize(centers.size());
  std::vector<int32_t> begin(static_cast<size_t>(across) * static_cast<size_t>(across) + 2, 0);
  for (size_t i = 0; i < centers.size(); ++i) {
    groups.start[i] = start_of(cells, centers[i]);
    ++begin[static_cast<size_t>(square_of(groups.start[i])) + 1];
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  groups.begin.push_back(0);
  for (size_t square = 0; square + 1 < begin.size(); ++square)
    if (square == 0 || begin[square + 1] > begin[square]) groups.begin.push_back(begin[square + 1]);
  groups.order.resize(centers.size());
  for (size_t i = 0; i < centers.size(); ++i) groups.order[begin[square_of(groups.start[i])]++] = static_cast<int32_t>(i);
  return groups;
}

namespace {

// Some of a group's centers: how far they lie apart.
struct Spread {
  vec3 low, high;
  Spread(const std::vector<SearchCenter> &centers, std::span<const int32_t> members)
      : low(std::numeric_limits<float>::max()), high(-low) {
    for (const int32_t i : members) {
      low = glm::min(low, centers[i].position);
      high = glm::max(high, centers[i].position);
    }
  }
  vec3 middle() const { return 0.5f * (low + high); }
  float radius() const { return 0.5f * length(high - low); }
  int longest_axis() const {
    const vec3 side = high - low;
    return side.x >= side.y && side.x >= side.z ? 0 : side.y >= side.z ? 1 : 2;
  }
};

} // namespace

// The members of one group that lie near each other: first those that are connected to the first member's cell, then those
// connected to the first of the others…
static void search_together(CellSearch &search, const std::vector<SearchCenter> &centers, const std::vector<int32_t> &start,
                            std::vector<int32_t> members, Neighborhoods &neighborhoods, Part &part) {
  std::vector<int32_t> others;
  while (!members.empty()) {
    const Spread spread(centers, members);
    search.flood_from(start[members[0]], spread.middle(), spread.radius());
    others.clear();
    for (const int32_t i : members) {
      if (!search.was_found(start[i])) {
        others.push_back(i);
        continue;
      }
      const vec3 position = centers[i].position;
      search.measure(position);
      if (search.is_single_sheet(position)) {
        neighborhoods.center[i] = search.list(position, false, part.range);
        neighborhoods.single_sheet[i] = 1;
      } else {
        part.left.push_back(i);
      }
    }
    members.swap(others);
  }
}

// A group, in halves until each lies within a part of the radius: the map may stretch a square to any length.
static void search_in_halves(CellSearch &search, const std::vector<SearchCenter> &centers, const std::vector<int32_t> &start,
                             std::span<int32_t> members, float radius, Neighborhoods &neighborhoods, Part &part) {
  constexpr float near = 0.6f;
  const Spread spread(centers, members);
  if (members.size() < 2 || spread.radius() <= near * radius)
    return search_together(search, centers, start, {members.begin(), members.end()}, neighborhoods, part);
  const int axis = spread.longest_axis();
  const float middle = spread.middle()[axis];
  const auto split =
      std::stable_partition(members.begin(), members.end(), [&](int32_t i) { return centers[i].position[axis] < middle; });
  const auto first = static_cast<size_t>(split - members.begin());
  if (first == 0 || first == members.size()) // as far apart as floats tell
    return search_together(search, centers, start, {members.begin(), members.end()}, neighborhoods, part);
  search_in_halves(search, centers, start, members.first(first), radius, neighborhoods, part);
  search_in_halves(search, centers, start, members.subspan(first), radius, neighborhoods, part);
}

// Appends the ranges of all parts to one list; part_centers[i]: the centers of part i.
static void join(std::vector<Part> &parts, const std::vector<std::span<const int32_t>> &part_centers,
                 Neighborhoods &neighborhoods) {
  size_t all = neighborhoods.range.size();
  for (const Part &part : parts) all += part.range.size();
  neighborhoods.range.reserve(all);
  for (size_t i = 0; i < parts.size(); ++i) {
    const auto offset = static_cast<int32_t>(neighborhoods.range.size());
    for (const int32_t center : part_centers[i]) {
      NeighborhoodRanges &data = neighborhoods.center[center];
      for (int32_t *at : {&data.first, &data.middle, &data.last, &data.end}) *at += offset;
    }
    neighborhoods.range.insert(neighborhoods.range.end(), parts[i].range.begin(), parts[i].range.end());
    parts[i].range = {}; // all together are as much again
  }
}

[[noreturn]] static void refuse_ranges(size_t centers, size_t max_ranges) {
  throw Error(PDESC_ERROR_OUT_OF_MEMORY, "The neighborhoods of " + std::to_string(centers) + " places have more than " +
                                             std::to_string(max_ranges) +
                                             " pieces of charts, for which there is no memory; use a "
                                             "smaller radius, smaller buffers, or a UV map of fewer charts.");
}

namespace {

// What both passes over the centers read, and how many ranges they have listed.
struct Passes {
  const SearchSpace &space;
  std::span<const CellData> measured;
  std::span<const CellLeaves> leaves;
  const std::vector<SearchCenter> &centers;
  float radius;
  int threads;
  size_t max_ranges;
  std::atomic<size_t> all{0};

  void count(size_t added) {
    if ((all += added) > max_ranges) refuse_ranges(centers.size(), max_ranges);
  }
};

} // namespace

// Searches group by group. Returns the centers that are left to search_alone().
static std::vector<int32_t> search_groups(Passes &passes, Groups &groups, Neighborhoods &neighborhoods) {
  constexpr int block = 64;
  const auto count = static_cast<int>(groups.begin.size()) - 1;
  auto members_of = [&](int first, int last) {
    const auto begin = static_cast<size_t>(groups.begin[first]);
    return std::span(groups.order).subspan(begin, static_cast<size_t>(groups.begin[last]) - begin);
  };
  std::vector<Part> parts(static_cast<size_t>((count + block - 1) / block));
  std::vector<std::span<const int32_t>> part_centers;
  for (int begin = 0; begin < count; begin += block) part_centers.push_back(members_of(begin, std::min(begin + block, count)));
  parallel_blocks(count, passes.threads, block, [&](int begin, int end) {
    CellSearch search(passes.space, passes.measured, passes.leaves, passes.radius);
    Part part; // of its own: neighboring vectors share cache lines
    for (int g = begin; g < end; ++g) {
      const size_t before = part.range.size();
      const std::span<int32_t> members = members_of(g, g + 1);
      if (g == 0) // they start nowhere
        part.left.assign(members.begin(), members.end());
      else
        search_in_halves(search, passes.centers, groups.start, members, passes.radius, neighborhoods, part);
      passes.count(part.range.size() - before);
    }
    parts[begin / block] = std::move(part);
  });
  join(parts, part_centers, neighborhoods);
  std::vector<int32_t> left;
  for (const Part &part : parts) left.insert(left.end(), part.left.begin(), part.left.end());
  return left;
}

// Searches for each of these centers by the links from its own cell.
static void search_alone(Passes &passes, std::span<const int32_t> left, Neighborhoods &neighborhoods) {
  constexpr int alone = 512;
  const std::vector<vec3> &link_points = passes.space.link_points();
  const std::vector<Bounds> links = link_bounds(passes.space.cells, link_points, passes.threads);
  std::vector<Part> parts((left.size() + alone - 1) / alone);
  std::vector<std::span<const int32_t>> part_centers;
  for (size_t first = 0; first < left.size(); first += alone)
    part_centers.push_back(left.subspan(first, std::min<size_t>(alone, left.size() - first)));
  parallel_blocks(static_cast<int>(left.size()), passes.threads, alone, [&](int begin, int) {
    CellSearch search(passes.space, passes.measured, passes.leaves, passes.radius);
    Part part;
    for (std::span<const int32_t> others = part_centers[begin / alone]; !others.empty();) {
      const std::span<const int32_t> members = others.first(search.together(passes.centers, others));
      others = others.subspan(members.size());
      search.run(passes.centers, members, links, link_points);
      const size_t before = part.range.size();
      for (size_t lane = 0; lane < members.size(); ++lane) {
        const vec3 position = passes.centers[members[lane]].position;
        const bool boundary = search.choose(lane, position);
        neighborhoods.center[members[lane]] = search.list(position, boundary, part.range);
      }
      passes.count(part.range.size() - before);
    }
    parts[begin / alone] = std::move(part);
  });
  join(parts, part_centers, neighborhoods);
}

Neighborhoods find_neighborhoods(const SearchSpace &space, const std::vector<SearchCenter> &centers, float radius, int threads,
                                 size_t max_ranges) {
  const std::vector<CellData> with_texelless =
      space.texelless.samples.empty() ? std::vector<CellData>() : with_texelless_samples(space);
  const std::span<const CellData> measured = with_texelless.empty() ? space.measured : with_texelless;
  const std::vector<CellLeaves> leaves = list_leaves(space, radius, threads);
  Passes passes{
      space, measured, leaves, centers, radius, threads, std::min<size_t>(max_ranges, std::numeric_limits<int32_t>::max())};
  Groups groups = group(space.cells, measured, centers, radius);
  Neighborhoods neighborhoods;
  neighborhoods.center.resize(centers.size());
  neighborhoods.single_sheet.resize(centers.size(), 0);
  const std::vector<int32_t> left = search_groups(passes, groups, neighborhoods);
  neighborhoods.order = std::move(groups.order);
  if (!left.empty()) search_alone(passes, left, neighborhoods);
  return neighborhoods;
}

} // namespace paradesc
