// From the triangles up: which clusters are small enough for one surfel; from the top down: where each surfel and each cell
// stands.
#include "engine/cpu/surfels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "support/parallel.h"

namespace paradesc {

namespace {

constexpr int block_size = 8192;
constexpr float samples_of_cell = 48;
constexpr float least_spread = 1e-13f; // pieces of less could not be told apart by floats
// What the rim cuts of triangles is known exactly, so that they may be larger than clusters. Where a map is looked at, which no
// sample knows how it varies, all are smaller.
constexpr float spread_of_triangles = 2;
constexpr float least_coherence = 0.95f; // of a surfel's mean normals, squared: it does not fold

// What a cluster consists of.
struct Counts {
  float samples = 0; // about
  int32_t surfels = 0;
  int32_t cells = 0;
  bool is_small = false; // it is one surfel, or part of one
};

class Builder {
public:
  Builder(const SurfelSource &source, float radius, int samples) : source_(source), tree_(source.tree) {
    const bool with_map = source.map != nullptr;
    largest_spread_ = std::max((with_map ? 0.5f : 2.0f) * radius * radius / static_cast<float>(samples), least_spread);
    result_.radius = radius;
    result_.largest_spread = with_map ? largest_spread_ : spread_of_triangles * largest_spread_;
  }

  Surfels run() {
    result_.clusters.resize(tree_.levels());
    counts_.resize(tree_.levels());
    measure_triangles();
    bool any_small = true;
    for (size_t level = 1; level < tree_.levels(); ++level) any_small = measure_level(level, any_small);
    place();
    link();
    return std::move(result_);
  }

private:
  template <class Body> void for_each(size_t count, const Body &body) const {
    parallel_blocks(static_cast<int>(count), source_.threads, block_size, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) body(static_cast<size_t>(i));
    });
  }

  void measure_triangles() {
    counts_[0].resize(tree_.size(0));
    result_.face.assign(tree_.rank.size(), vec3(0.0f));
    for_each(tree_.size(0), [&](size_t i) {
      const int32_t corner = 3 * tree_.triangle[i];
      const vec3 a = source_.position(corner), ab = source_.position(corner + 1) - a, ac = source_.position(corner + 2) - a;
      const vec3 bc = ac - ab, plane = cross(ab, ac);
      const float twice_area = length(plane), spread = (dot(ab, ab) + dot(ac, ac) + dot(bc, bc)) * (1.0f / 36.0f);
      counts_[0][i] = {samples_of(0.5f * twice_area, spread), 1, 1, spread <= result_.largest_spread};
      if (twice_area > 0.0f) result_.face[tree_.triangle[i]] = plane / twice_area;
    });
  }

  // About as many as a triangle is divided into: of a sliver, along its length alone.
  float samples_of(float area, float spread) const {
    constexpr float area_of_equilateral = 5.2f; // over its spread
    return std::max({1.0f, std::sqrt(spread / result_.largest_spread), area / (area_of_equilateral * result_.largest_spread)});
  }

  // Whether any cluster of this level may be one surfel.
  bool measure_level(size_t level, bool any_small_below) {
    const std::vector<int32_t> &children = tree_.child_begin[level - 1];
    const size_t count = tree_.size(level);
    std::vector<Cluster> &clusters = result_.clusters[level];
    if (any_small_below) clusters.resize(count);
    counts_[level].resize(count);
    std::atomic<bool> any_small{false};
    for_each(count, [&](size_t i) {
      const auto begin = static_cast<size_t>(children[i]), end = static_cast<size_t>(children[i + 1]);
      Counts counts{0, 0, 0, any_small_below};
      for (size_t k = begin; k < end; ++k) {
        const Counts &child = counts_[level - 1][k];
        counts.samples += child.samples;
        counts.surfels += child.surfels;
        counts.cells += child.cells;
        counts.is_small = counts.is_small && child.is_small;
      }
      if (counts.is_small) {
        clusters[i] = join_children(level, begin, end);
        counts.is_small = is_small(clusters[i]);
      }
      if (counts.is_small) {
        counts.samples = 1;
        counts.surfels = 1;
        any_small = true;
      }
      if (counts.samples <= samples_of_cell) counts.cells = 1;
      counts_[level][i] = counts;
    });
    return any_small;
  }

  // Whether one sample stands for it.
  bool is_small(const Cluster &cluster) const {
    return cluster.spread() <= largest_spread_ && dot(cluster.normal, cluster.normal) > least_coherence &&
           dot(cluster.face, cluster.face) > least_coherence;
  }

  Cluster join_children(size_t level, size_t begin, size_t end) const {
    if (level > 1) return join(std::span(result_.clusters[level - 1]).subspan(begin, end - begin));
    std::array<Cluster, ClusterTree::max_children> triangles;
    for (size_t k = begin; k < end; ++k) {
      const int32_t triangle = tree_.triangle[k];
      const float lean = lean_of(source_, result_, triangle);
      triangles[k - begin] = cluster_of(sample_of(source_, triangle, lean), lean);
    }
    return join(std::span(triangles).first(end - begin));
  }

  // Which surfel and which cell a cluster begins with, or is part of.
  struct Start {
    int32_t surfel = 0, cell = 0;
    bool in_surfel = false, in_cell = false;
  };

  // From the top down: surfels and cells follow each other in the order of the clusters.
  void place() {
    const size_t top = tree_.levels() - 1;
    std::vector<Start> starts(tree_.size(top)), below;
    Start next;
    for (size_t i = 0; i < starts.size(); ++i) {
      starts[i] = next;
      next.surfel += counts_[top][i].surfels;
      next.cell += counts_[top][i].cells;
    }
    result_.surfel.resize(static_cast<size_t>(next.surfel));
    result_.first.assign(result_.surfel.size() + 1, static_cast<int32_t>(tree_.size(0)));
    result_.cell_begin.assign(static_cast<size_t>(next.cell) + 1, next.surfel);
    for (size_t level = top; level > 0; --level) {
      below.resize(tree_.size(level - 1));
      for_each(starts.size(), [&](size_t i) { place_cluster(level, i, starts[i], below); });
      starts.swap(below);
    }
    place_triangles(starts);
  }

  void place_cluster(size_t level, size_t i, Start start, std::vector<Start> &below) {
    const Counts &counts = counts_[level][i];
    if (counts.is_small && !start.in_surfel) {
      const Cluster &cluster = result_.clusters[level][i];
      result_.surfel[start.surfel] = {cluster.position, cluster.reach, 1.0f, static_cast<int32_t>(level),
                                      static_cast<int32_t>(i)};
    }
    start.in_surfel = start.in_surfel || counts.is_small;
    start.in_cell = start.in_cell || counts.samples <= samples_of_cell;
    for (int32_t k = tree_.child_begin[level - 1][i]; k < tree_.child_begin[level - 1][i + 1]; ++k) {
      below[k] = start;
      if (!start.in_surfel) start.surfel += counts_[level - 1][k].surfels;
      if (!start.in_cell) start.cell += counts_[level - 1][k].cells;
    }
  }

  void place_triangles(const std::vector<Start> &starts) {
    result_.triangle_cell.assign(tree_.rank.size(), -1);
    result_.triangle_surfel.assign(tree_.rank.size(), -1);
    for_each(starts.size(), [&](size_t i) {
      const auto [surfel, cell, in_surfel, in_cell] = starts[i];
      result_.triangle_surfel[tree_.triangle[i]] = surfel;
      result_.triangle_cell[tree_.triangle[i]] = cell;
      if (i == 0 || starts[i - 1].surfel != surfel) result_.first[surfel] = static_cast<int32_t>(i);
      if (i == 0 || starts[i - 1].cell != cell) result_.cell_begin[cell] = surfel;
      if (in_surfel) return;
      const int32_t corner = 3 * tree_.triangle[i];
      const vec3 a = source_.position(corner), b = source_.position(corner + 1), c = source_.position(corner + 2);
      const vec3 middle = (a + b + c) * (1.0f / 3.0f);
      const float reach = std::max({length(a - middle), length(b - middle), length(c - middle)});
      const float samples = counts_[0][i].is_small ? 1.0f : std::max(counts_[0][i].samples, 2.0f);
      result_.surfel[surfel] = {middle, reach, samples, 0, static_cast<int32_t>(i)};
    });
  }

  // The links, the boundary and the surfels' neighbors of some cells in a row.
  struct Part {
    std::vector<int32_t> links, boundary, neighbors, link_count, boundary_count, neighbor_count;
  };

  void link() {
    const auto cells = static_cast<int>(result_.cell_begin.size()) - 1;
    constexpr int cells_of_part = 512;
    std::vector<Part> parts(static_cast<size_t>((cells + cells_of_part - 1) / cells_of_part));
    result_.cell_sphere.resize(static_cast<size_t>(cells));
    parallel_blocks(cells, source_.threads, cells_of_part, [&](int begin, int end) {
      Part part;
      for (int cell = begin; cell < end; ++cell) link_cell(cell, part);
      parts[begin / cells_of_part] = std::move(part);
    });
    for (auto *begin : {&result_.link_begin, &result_.boundary_begin, &result_.neighbor_begin}) begin->assign(1, 0);
    const auto append = [](const std::vector<int32_t> &counts, const std::vector<int32_t> &items, std::vector<int32_t> &begin,
                           std::vector<int32_t> &all) {
      for (const int32_t count : counts) begin.push_back(begin.back() + count);
      all.insert(all.end(), items.begin(), items.end());
    };
    for (const Part &part : parts) {
      append(part.link_count, part.links, result_.link_begin, result_.link);
      append(part.boundary_count, part.boundary, result_.boundary_begin, result_.boundary);
      append(part.neighbor_count, part.neighbors, result_.neighbor_begin, result_.neighbor);
    }
  }

  static void add_once(std::vector<int32_t> &list, size_t first, int32_t value) {
    if (std::find(list.begin() + static_cast<ptrdiff_t>(first), list.end(), value) == list.end()) list.push_back(value);
  }

  void link_cell(int32_t cell, Part &part) {
    const size_t first_link = part.links.size(), first_boundary = part.boundary.size();
    vec3 low(std::numeric_limits<float>::max()), high(-low);
    for (int32_t surfel = result_.cell_begin[cell]; surfel < result_.cell_begin[cell + 1]; ++surfel) {
      link_surfel(surfel, cell, first_link, part);
      const Surfel &sample = result_.surfel[surfel];
      low = glm::min(low, sample.position - sample.reach);
      high = glm::max(high, sample.position + sample.reach);
    }
    const vec3 middle = 0.5f * (low + high);
    float radius = 0.0f;
    for (int32_t surfel = result_.cell_begin[cell]; surfel < result_.cell_begin[cell + 1]; ++surfel) {
      const Surfel &sample = result_.surfel[surfel];
      radius = std::max(radius, length(sample.position - middle) + sample.reach);
    }
    result_.cell_sphere[cell] = vec4(middle, radius);
    part.link_count.push_back(static_cast<int32_t>(part.links.size() - first_link));
    part.boundary_count.push_back(static_cast<int32_t>(part.boundary.size() - first_boundary));
  }

  void link_surfel(int32_t surfel, int32_t cell, size_t first_link, Part &part) {
    const size_t first_neighbor = part.neighbors.size();
    const bool is_cluster = result_.first[surfel + 1] - result_.first[surfel] > 1;
    for (int32_t i = result_.first[surfel]; i < result_.first[surfel + 1]; ++i)
      for (int32_t half_edge = 3 * tree_.triangle[i]; half_edge < 3 * tree_.triangle[i] + 3; ++half_edge) {
        const int32_t twin = source_.half_edges.twin[half_edge];
        if (twin < 0) {
          part.boundary.push_back(half_edge);
        } else if (const int32_t other = result_.triangle_surfel[twin / 3]; other != surfel) {
          if (is_cluster) add_once(part.neighbors, first_neighbor, other);
          if (const int32_t behind = result_.triangle_cell[twin / 3]; behind != cell) add_once(part.links, first_link, behind);
        }
      }
    part.neighbor_count.push_back(static_cast<int32_t>(part.neighbors.size() - first_neighbor));
  }

  const SurfelSource &source_;
  const ClusterTree &tree_;
  float largest_spread_; // of clusters
  Surfels result_;
  std::vector<std::vector<Counts>> counts_;
};

} // namespace

float lean_of(const SurfelSource &source, const Surfels &surfels, int32_t triangle) {
  const std::vector<int32_t> &twin = source.half_edges.twin;
  const vec3 face = surfels.face[triangle];
  float square = 0.0f;
  const auto look_at = [&](int32_t corner) {
    const vec3 gap = surfels.face[corner / 3] - face;
    square = std::max(square, dot(gap, gap));
  };
  for (int32_t first = 3 * triangle; first < 3 * triangle + 3; ++first) {
    int32_t corner = first;
    while ((corner = twin[previous_corner(corner)]) >= 0 && corner != first) look_at(corner);
    if (corner == first) continue;
    corner = first; // the fan ends at the boundary: its other side
    while ((corner = twin[corner]) >= 0) look_at(corner = next_corner(corner));
  }
  return std::sqrt(square);
}

Sample sample_of(const SurfelSource &source, int32_t triangle, float lean) {
  vec3 corners[3], normals[3];
  for (int32_t k = 0; k < 3; ++k) {
    corners[k] = source.position(3 * triangle + k);
    normals[k] = source.normals.corner(static_cast<size_t>(3 * triangle + k));
  }
  return sample_of_triangle(corners, normals, lean);
}

// (surfels) the map's mean over each; at its triangles' corners where it is one triangle alone.
static std::vector<vec4> mean_map(const SurfelSource &source, const Surfels &surfels) {
  std::vector<vec4> means(surfels.surfel.size());
  parallel_blocks(static_cast<int>(means.size()), source.threads, block_size, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      vec4 sum(0.0f);
      float area = 0.0f;
      for (int32_t i = surfels.first[k]; i < surfels.first[k + 1]; ++i) {
        const int32_t corner = 3 * source.tree.triangle[i];
        const auto at = [&](int32_t c) { return (*source.map)[source.half_edges.corner_point[c]]; };
        const vec3 a = source.position(corner);
        const float part = length(cross(source.position(corner + 1) - a, source.position(corner + 2) - a));
        sum += (at(corner) + at(corner + 1) + at(corner + 2)) * (part / 3.0f);
        area += part;
      }
      means[k] = area > 0.0f ? sum / area : vec4(0.0f);
    }
  });
  return means;
}

Surfels build_surfels(const SurfelSource &source, float radius, int samples) {
  Surfels surfels = Builder(source, radius, samples).run();
  if (source.map) surfels.map = mean_map(source, surfels);
  return surfels;
}

} // namespace paradesc
