// From the triangles up: which clusters are small enough for one surfel; from the top down: where each surfel and each cell
// stands.
#include "engine/cpu/surfels.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "support/parallel.h"

namespace paradesc {

namespace {

constexpr int block_size = 8192;
constexpr float samples_of_cell = 48;
constexpr float least_spread = 1e-13f;   // pieces of less could not be told apart by floats
constexpr float least_coherence = 0.95f; // of a surfel's mean normal, squared: it does not fold

// One cluster of the tree.
struct Cluster {
  vec3 position{0.0f}; // mean
  float area = 0;
  vec3 normal{0.0f}; // mean
  vec3 face{0.0f};   // mean
  float spread = 0;  // mean squared distance from the mean position
};

// What a cluster consists of.
struct Counts {
  float samples = 0; // about
  int32_t surfels = 0;
  int32_t cells = 0;
  bool is_small = false; // it is one surfel, or part of one
};

class Builder {
public:
  Builder(const SurfelSource &source, float radius, int samples)
      : source_(source), tree_(source.tree),
        largest_spread_(std::max(0.5f * radius * radius / static_cast<float>(samples), least_spread)) {
    result_.radius = radius;
    result_.largest_spread = largest_spread_;
  }

  Surfels run() {
    clusters_.resize(tree_.levels());
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
    clusters_[0].resize(tree_.size(0));
    counts_[0].resize(tree_.size(0));
    for_each(tree_.size(0), [&](size_t i) {
      const int32_t corner = 3 * tree_.triangle[i];
      const vec3 a = source_.position(corner), ab = source_.position(corner + 1) - a, ac = source_.position(corner + 2) - a;
      const vec3 bc = ac - ab;
      Cluster &cluster = clusters_[0][i];
      cluster.position = a + (ab + ac) * (1.0f / 3.0f);
      const vec3 plane = cross(ab, ac);
      const float size = length(plane);
      cluster.area = 0.5f * size;
      if (size > 0.0f) cluster.face = plane / size;
      for (int k = 0; k < 3; ++k) cluster.normal += source_.normals.corner(static_cast<size_t>(corner + k)) * (1.0f / 3.0f);
      cluster.spread = (dot(ab, ab) + dot(ac, ac) + dot(bc, bc)) * (1.0f / 36.0f);
      counts_[0][i] = {samples_of(cluster), 1, 1, cluster.spread <= largest_spread_};
    });
  }

  // About as many as a triangle is divided into: of a sliver, along its length alone.
  float samples_of(const Cluster &triangle) const {
    constexpr float area_of_equilateral = 5.2f; // over its spread
    return std::max(
        {1.0f, std::sqrt(triangle.spread / largest_spread_), triangle.area / (area_of_equilateral * largest_spread_)});
  }

  // Whether any cluster of this level may be one surfel.
  bool measure_level(size_t level, bool any_small_below) {
    const std::vector<int32_t> &children = tree_.child_begin[level - 1];
    const size_t count = tree_.size(level);
    if (any_small_below) clusters_[level].resize(count);
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
        clusters_[level][i] = join(level, begin, end);
        const Cluster &cluster = clusters_[level][i];
        counts.is_small = cluster.spread <= largest_spread_ && dot(cluster.normal, cluster.normal) > least_coherence;
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

  Cluster join(size_t level, size_t begin, size_t end) const {
    const std::vector<Cluster> &below = clusters_[level - 1];
    Cluster sum;
    for (size_t k = begin; k < end; ++k) {
      sum.area += below[k].area;
      sum.position += below[k].area * below[k].position;
      sum.normal += below[k].area * below[k].normal;
      sum.face += below[k].area * below[k].face;
    }
    if (!(sum.area > 0.0f)) return below[begin];
    sum.position /= sum.area;
    sum.normal /= sum.area;
    sum.face /= sum.area;
    for (size_t k = begin; k < end; ++k) {
      const vec3 gap = below[k].position - sum.position;
      sum.spread += below[k].area * (below[k].spread + dot(gap, gap));
    }
    sum.spread /= sum.area;
    return sum;
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
      const Cluster &cluster = clusters_[level][i];
      result_.surfel[start.surfel] = {cluster.position, cluster.area, cluster.normal, cluster.face, 1.0f};
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
      const Cluster &cluster = clusters_[0][i];
      result_.surfel[surfel] = {cluster.position, cluster.area, cluster.normal, cluster.face,
                                counts_[0][i].is_small ? 1.0f : std::max(counts_[0][i].samples, 2.0f)};
    });
  }

  // The links and the boundary of some cells in a row.
  struct Part {
    std::vector<int32_t> links, boundary, link_count, boundary_count;
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
    result_.link_begin.assign(1, 0);
    result_.boundary_begin.assign(1, 0);
    for (const Part &part : parts) {
      for (const int32_t count : part.link_count) result_.link_begin.push_back(result_.link_begin.back() + count);
      for (const int32_t count : part.boundary_count) result_.boundary_begin.push_back(result_.boundary_begin.back() + count);
      result_.link.insert(result_.link.end(), part.links.begin(), part.links.end());
      result_.boundary.insert(result_.boundary.end(), part.boundary.begin(), part.boundary.end());
    }
  }

  void link_cell(int32_t cell, Part &part) {
    const size_t first_link = part.links.size(), first_boundary = part.boundary.size();
    vec3 low(std::numeric_limits<float>::max()), high(-low);
    const auto begin = static_cast<size_t>(result_.first[result_.cell_begin[cell]]);
    const auto end = static_cast<size_t>(result_.first[result_.cell_begin[cell + 1]]);
    for (size_t i = begin; i < end; ++i)
      for (int32_t half_edge = 3 * tree_.triangle[i]; half_edge < 3 * tree_.triangle[i] + 3; ++half_edge) {
        const vec3 position = source_.position(half_edge);
        low = glm::min(low, position);
        high = glm::max(high, position);
        const int32_t twin = source_.half_edges.twin[half_edge];
        const int32_t other = twin < 0 ? -1 : result_.triangle_cell[twin / 3];
        if (twin < 0)
          part.boundary.push_back(half_edge);
        else if (other != cell &&
                 std::find(part.links.begin() + static_cast<ptrdiff_t>(first_link), part.links.end(), other) == part.links.end())
          part.links.push_back(other);
      }
    const vec3 middle = 0.5f * (low + high);
    float square = 0.0f;
    for (size_t i = begin; i < end; ++i)
      for (int32_t corner = 3 * tree_.triangle[i]; corner < 3 * tree_.triangle[i] + 3; ++corner) {
        const vec3 gap = source_.position(corner) - middle;
        square = std::max(square, dot(gap, gap));
      }
    result_.cell_sphere[cell] = vec4(middle, std::sqrt(square));
    part.link_count.push_back(static_cast<int32_t>(part.links.size() - first_link));
    part.boundary_count.push_back(static_cast<int32_t>(part.boundary.size() - first_boundary));
  }

  const SurfelSource &source_;
  const ClusterTree &tree_;
  float largest_spread_;
  Surfels result_;
  std::vector<std::vector<Cluster>> clusters_; // by level
  std::vector<std::vector<Counts>> counts_;
};

} // namespace

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
