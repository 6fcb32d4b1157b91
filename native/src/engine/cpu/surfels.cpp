// Determines bottom-up which clusters are small enough for one surfel, and then top-down the index of each surfel and cell.
#include "engine/cpu/surfels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "support/parallel.h"

namespace paradesc {

namespace {

constexpr int block_size = 8192;
constexpr float samples_of_cell = 96;
constexpr float least_spread = 1e-13f;  // floats cannot resolve smaller pieces
constexpr float spread_of_clusters = 2; // relative to the squared radius over the number of samples
constexpr float spread_with_map = 1;    // the same, if operators read a map

// The properties of a piece of surface that determine whether it can be one surfel.
struct Size {
  vec3 middle, normal, face; // means
  float area, spread;
};

// The numbers of a cluster's parts.
struct Counts {
  float samples; // approximate
  int32_t surfels;
  int32_t cells;
  bool is_small; // it is one surfel, or part of one
};

class Builder {
public:
  Builder(const SurfelSource &source, float radius, Fineness fineness)
      : source_(source), tree_(source.tree), least_coherence_(fineness.coherence) {
    const float spread = source.map ? spread_with_map : spread_of_clusters;
    largest_spread_ = std::max(spread * radius * radius / static_cast<float>(fineness.samples), least_spread);
    result_.radius = radius;
    result_.largest_spread = fineness.triangles * largest_spread_;
  }

  Surfels run() {
    counts_.resize(tree_.levels());
    counts_[0].resize(tree_.size(0));
    leave_out(result_.face, vec3(0.0f));
    if (tree_.levels() == 1) for_each(tree_.size(0), [&](size_t i) { measure_triangle(i); });
    bool any_small = true;
    for (size_t level = 1; level < tree_.levels(); ++level) any_small = measure_level(level, any_small);
    sizes_ = {};
    place();
    gather_clusters();
    link();
    return std::move(result_);
  }

private:
  template <class Body> void for_each(size_t count, const Body &body) const {
    parallel_blocks(static_cast<int>(count), source_.threads, block_size, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) body(static_cast<size_t>(i));
    });
  }

  // Allocates an entry for each triangle, with this value for those that are left out.
  template <class T> void leave_out(UnsetVector<T> &items, T value) const {
    items.resize(tree_.rank.size());
    if (tree_.size(0) < tree_.rank.size()) std::ranges::fill(items, value);
  }

  Size measure_triangle(size_t i) {
    const int32_t corner = 3 * tree_.item[i];
    const vec3 a = source_.position(corner), ab = source_.position(corner + 1) - a, ac = source_.position(corner + 2) - a;
    const vec3 bc = ac - ab, plane = cross(ab, ac);
    const float twice_area = length(plane), spread = (dot(ab, ab) + dot(ac, ac) + dot(bc, bc)) * (1.0f / 36.0f);
    vec3 normals[3];
    for (int32_t k = 0; k < 3; ++k) normals[k] = source_.normals.corner(static_cast<size_t>(corner + k));
    const float turning_spread = std::min(spread, spread_by_height(twice_area, dot(ab, ab), dot(bc, bc), dot(ac, ac)));
    const float turn_of_part =
        squared_turn(normals[0], normals[1], normals[2]) / std::max(turning_spread / result_.largest_spread, 1.0f);
    const float largest = result_.largest_spread_at(turn_of_part);
    counts_[0][i] = {samples_of(0.5f * twice_area, spread, largest), 1, 1, spread <= largest};
    const vec3 face = twice_area > 0.0f ? plane / twice_area : vec3(0.0f);
    result_.face[tree_.item[i]] = face;
    return {a + (ab + ac) * (1.0f / 3.0f), (normals[0] + normals[1] + normals[2]) * (1.0f / 3.0f), face, 0.5f * twice_area,
            spread};
  }

  // Returns the square of a third of the triangle's height, which is the spread of an equilateral triangle of that height. The
  // normals of a sliver turn across it until its pieces are narrower than that.
  static float spread_by_height(float twice_area, float ab, float bc, float ac) {
    return twice_area * twice_area / (9.0f * std::max({ab, bc, ac, 1e-30f}));
  }

  // Returns the approximate number of samples of a triangle. For a sliver, it is proportional to the length only.
  static float samples_of(float area, float spread, float largest_spread) {
    constexpr float area_of_equilateral = 5.2f; // over its spread
    return std::max({1.0f, std::sqrt(spread / largest_spread), area / (area_of_equilateral * largest_spread)});
  }

  // Returns whether any cluster of this level may be one surfel.
  bool measure_level(size_t level, bool any_small_below) {
    const std::vector<int32_t> &children = tree_.child_begin[level - 1];
    const size_t count = tree_.size(level);
    UnsetVector<Size> sizes(any_small_below ? count : 0);
    counts_[level].resize(count);
    std::atomic<bool> any_small{false};
    for_each(count, [&](size_t i) {
      const auto begin = static_cast<size_t>(children[i]), end = static_cast<size_t>(children[i + 1]);
      std::array<Size, ClusterTree::max_children> triangles; // not stored for this level
      for (size_t k = begin; level == 1 && k < end; ++k) triangles[k - begin] = measure_triangle(k);
      Counts counts{0, 0, 0, any_small_below};
      for (size_t k = begin; k < end; ++k) {
        const Counts &child = counts_[level - 1][k];
        counts.samples += child.samples;
        counts.surfels += child.surfels;
        counts.cells += child.cells;
        counts.is_small = counts.is_small && child.is_small;
      }
      if (counts.is_small) {
        sizes[i] = join(level == 1 ? std::span<const Size>(triangles).first(end - begin)
                                   : std::span(sizes_).subspan(begin, end - begin));
        counts.is_small = is_small(sizes[i]);
      }
      if (counts.is_small) {
        counts.samples = 1;
        counts.surfels = 1;
        any_small = true;
      }
      if (counts.samples <= samples_of_cell) counts.cells = 1;
      counts_[level][i] = counts;
    });
    sizes_ = std::move(sizes);
    return any_small;
  }

  static Size join(std::span<const Size> parts) {
    Size whole{};
    for (const Size &part : parts) {
      whole.area += part.area;
      whole.middle += part.area * (part.middle - parts[0].middle);
      whole.normal += part.area * part.normal;
      whole.face += part.area * part.face;
    }
    if (!(whole.area > 0.0f)) return parts[0];
    whole.middle /= whole.area;
    whole.normal /= whole.area;
    whole.face /= whole.area;
    for (const Size &part : parts) {
      const vec3 gap = part.middle - parts[0].middle - whole.middle;
      whole.spread += part.area * (part.spread + dot(gap, gap)) / whole.area;
    }
    whole.middle += parts[0].middle;
    return whole;
  }

  // Returns whether one sample can represent the piece.
  bool is_small(const Size &size) const {
    return size.spread <= largest_spread_ && dot(size.normal, size.normal) > least_coherence_ &&
           dot(size.face, size.face) > least_coherence_;
  }

  // The surfel and the cell that a cluster begins with, or is part of.
  struct Start {
    int32_t surfel, cell;
    bool in_surfel, in_cell;
  };

  // Assigns indices top-down, so that surfels and cells are in the order of the clusters.
  void place() {
    const size_t top = tree_.levels() - 1;
    UnsetVector<Start> starts(tree_.size(top)), below;
    Start next{};
    for (size_t i = 0; i < starts.size(); ++i) {
      starts[i] = next;
      next.surfel += counts_[top][i].surfels;
      next.cell += counts_[top][i].cells;
    }
    result_.surfel.resize(static_cast<size_t>(next.surfel));
    result_.first.resize(result_.surfel.size() + 1);
    result_.first.back() = static_cast<int32_t>(tree_.size(0));
    result_.cell_begin.resize(static_cast<size_t>(next.cell) + 1);
    result_.cell_begin.back() = next.surfel;
    for (size_t level = top; level > 0; --level) {
      below.resize(tree_.size(level - 1));
      for_each(starts.size(), [&](size_t i) { place_cluster(level, i, starts[i], below); });
      starts.swap(below);
    }
    place_triangles(starts);
  }

  void place_cluster(size_t level, size_t i, Start start, UnsetVector<Start> &below) {
    const Counts &counts = counts_[level][i];
    if (counts.is_small && !start.in_surfel) result_.surfel[start.surfel] = {vec3(0.0f), 0.0f, 1.0f, 0}; // see gather_clusters()
    start.in_surfel = start.in_surfel || counts.is_small;
    start.in_cell = start.in_cell || counts.samples <= samples_of_cell;
    for (int32_t k = tree_.child_begin[level - 1][i]; k < tree_.child_begin[level - 1][i + 1]; ++k) {
      below[k] = start;
      if (!start.in_surfel) start.surfel += counts_[level - 1][k].surfels;
      if (!start.in_cell) start.cell += counts_[level - 1][k].cells;
    }
  }

  void place_triangles(const UnsetVector<Start> &starts) {
    leave_out(result_.triangle_cell, -1);
    leave_out(result_.triangle_surfel, -1);
    for_each(starts.size(), [&](size_t i) {
      const auto [surfel, cell, in_surfel, in_cell] = starts[i];
      result_.triangle_surfel[tree_.item[i]] = surfel;
      result_.triangle_cell[tree_.item[i]] = cell;
      if (i == 0 || starts[i - 1].surfel != surfel) result_.first[surfel] = static_cast<int32_t>(i);
      if (i == 0 || starts[i - 1].cell != cell) result_.cell_begin[cell] = surfel;
      if (in_surfel) return;
      const int32_t corner = 3 * tree_.item[i];
      const vec3 a = source_.position(corner), b = source_.position(corner + 1), c = source_.position(corner + 2);
      const vec3 middle = (a + b + c) * (1.0f / 3.0f);
      const float reach = std::max({length(a - middle), length(b - middle), length(c - middle)});
      const float samples = counts_[0][i].is_small ? 1.0f : std::max(counts_[0][i].samples, 2.0f);
      result_.surfel[surfel] = {middle, reach, samples, -1};
    });
  }

  // Sums the clusters of surfels with several triangles.
  void gather_clusters() {
    int32_t count = 0;
    for (Surfel &surfel : result_.surfel)
      if (surfel.cluster >= 0) surfel.cluster = count++;
    checkpoint();
    result_.cluster.resize(static_cast<size_t>(count));
    constexpr int surfels_of_block = 256; // with many triangles each
    parallel_blocks(static_cast<int>(result_.surfel.size()), source_.threads, surfels_of_block, [&](int begin, int end) {
      for (int i = begin; i < end; ++i)
        if (result_.surfel[i].cluster >= 0) gather_cluster(static_cast<size_t>(i));
    });
  }

  void gather_cluster(size_t i) {
    Surfel &surfel = result_.surfel[i];
    const auto triangles =
        std::span(tree_.item).subspan(result_.first[i], static_cast<size_t>(result_.first[i + 1] - result_.first[i]));
    ClusterSums sums(source_.position(3 * triangles[0]));
    for (const int32_t triangle : triangles) sums.add(sample_of(source_, triangle, 0.0f));
    Cluster &cluster = result_.cluster[surfel.cluster];
    cluster = sums.cluster();
    float square = 0.0f;
    for (const int32_t triangle : triangles)
      for (int32_t corner = 3 * triangle; corner < 3 * triangle + 3; ++corner) {
        const vec3 gap = source_.position(corner) - cluster.position;
        square = std::max(square, dot(gap, gap));
      }
    cluster.reach = std::sqrt(square);
    surfel.position = cluster.position;
    surfel.reach = cluster.reach;
    if (triangles.size() == 1) surfel.cluster = -1;
  }

  // The links, boundary edges and neighbors of consecutive cells.
  struct Part {
    std::vector<int32_t> links, boundary, neighbors, edges, link_count, boundary_count, neighbor_count, edge_count;
    std::vector<std::pair<size_t, int32_t>> edges_of_surfel;
  };

  void link() {
    const auto cells = static_cast<int>(result_.cell_begin.size()) - 1;
    constexpr int cells_of_part = 128;
    std::vector<Part> parts(static_cast<size_t>(Blocks{cells, cells_of_part}.number()));
    result_.cell_sphere.resize(static_cast<size_t>(cells));
    parallel_blocks(cells, source_.threads, cells_of_part, [&](int begin, int end) {
      Part part;
      for (int cell = begin; cell < end; ++cell) link_cell(cell, part);
      parts[begin / cells_of_part] = std::move(part);
    });
    join(parts, &Part::link_count, &Part::links, result_.link_begin, result_.link);
    join(parts, &Part::boundary_count, &Part::boundary, result_.boundary_begin, result_.boundary);
    join(parts, &Part::neighbor_count, &Part::neighbors, result_.neighbor_begin, result_.neighbor);
    join(parts, &Part::edge_count, &Part::edges, result_.edge_begin, result_.edge);
  }

  // Concatenates the lists of all parts, and finds where each begins.
  void join(const std::vector<Part> &parts, std::vector<int32_t> Part::*counts, std::vector<int32_t> Part::*items,
            UnsetVector<int32_t> &begin, UnsetVector<int32_t> &all) const {
    std::vector<size_t> first_count{0}, first_item{0};
    for (const Part &part : parts) {
      first_count.push_back(first_count.back() + (part.*counts).size());
      first_item.push_back(first_item.back() + (part.*items).size());
    }
    begin.resize(first_count.back() + 1);
    all.resize(first_item.back());
    begin.back() = static_cast<int32_t>(first_item.back());
    parallel_blocks(static_cast<int>(parts.size()), source_.threads, 1, [&](int i, int) {
      auto next = static_cast<int32_t>(first_item[i]);
      size_t at = first_count[i];
      for (const int32_t count : parts[i].*counts) {
        begin[at++] = next;
        next += count;
      }
      std::ranges::copy(parts[i].*items, all.begin() + static_cast<ptrdiff_t>(first_item[i]));
    });
  }

  // Returns the index of the value.
  static size_t add_once(std::vector<int32_t> &list, size_t first, int32_t value) {
    const auto found = std::find(list.begin() + static_cast<ptrdiff_t>(first), list.end(), value);
    const auto index = static_cast<size_t>(found - list.begin());
    if (found == list.end()) list.push_back(value);
    return index;
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
    std::vector<std::pair<size_t, int32_t>> &edges = part.edges_of_surfel; // with the indices of the neighbors
    edges.clear();
    for (int32_t i = result_.first[surfel]; i < result_.first[surfel + 1]; ++i)
      for (int32_t half_edge = 3 * tree_.item[i]; half_edge < 3 * tree_.item[i] + 3; ++half_edge) {
        const int32_t twin = source_.half_edges.twin[half_edge];
        if (twin < 0) {
          part.boundary.push_back(half_edge);
        } else if (const int32_t other = result_.triangle_surfel[twin / 3]; other != surfel) {
          edges.emplace_back(add_once(part.neighbors, first_neighbor, other), half_edge);
          if (const int32_t behind = result_.triangle_cell[twin / 3]; behind != cell) add_once(part.links, first_link, behind);
        }
      }
    part.neighbor_count.push_back(static_cast<int32_t>(part.neighbors.size() - first_neighbor));
    std::sort(edges.begin(), edges.end());
    part.edge_count.resize(part.neighbors.size(), 0);
    for (const auto &[neighbor, half_edge] : edges) {
      ++part.edge_count[neighbor];
      part.edges.push_back(half_edge);
    }
  }

  const SurfelSource &source_;
  const ClusterTree &tree_;
  float largest_spread_; // of clusters
  float least_coherence_;
  Surfels result_;
  std::vector<UnsetVector<Counts>> counts_;
  UnsetVector<Size> sizes_; // of the level that was measured last
};

} // namespace

float squared_turn(vec3 a, vec3 b, vec3 c) {
  const auto square = [](vec3 v) { return dot(v, v); };
  constexpr float opposite = 4.0f;
  const float farthest = std::max({square(b - a), square(c - b), square(a - c)}),
              least = std::min({square(a), square(b), square(c)});
  return farthest < opposite * least ? farthest / least : opposite;
}

float Surfels::largest_spread_at(float turn) const {
  constexpr float hardly = 0.1f, finer = 30.0f; // a turn of 0.1 is 18 degrees
  return largest_spread / (1.0f + finer * std::max(turn - hardly, 0.0f));
}

UnsetVector<vec3> positions_in(const BakeSpace &space, const Triangles &triangles, int threads) {
  UnsetVector<vec3> positions(triangles.positions.size());
  parallel_blocks(static_cast<int>(positions.size()), threads, block_size, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) positions[i] = space.to_buffer(triangles.positions[i]);
  });
  return positions;
}

float lean_of(const SurfelSource &source, const Surfels &surfels, int32_t surfel, vec3 face) {
  const std::vector<int32_t> &twin = source.half_edges.twin;
  float square = 0.0f;
  const auto look_at = [&](int32_t corner) {
    const vec3 gap = surfels.face[corner / 3] - face;
    square = std::max(square, dot(gap, gap));
  };
  const auto look_around = [&](int32_t first) {
    int32_t corner = first;
    while ((corner = twin[previous_corner(corner)]) >= 0 && corner != first) look_at(corner);
    if (corner == first) return;
    corner = first; // the fan ends at the boundary; continues on its other side
    while ((corner = twin[corner]) >= 0) look_at(corner = next_corner(corner));
  };
  for (int32_t i = surfels.first[surfel]; i < surfels.first[surfel + 1]; ++i) {
    const int32_t first = 3 * source.tree.item[i];
    look_at(first);
    for (int32_t corner = first; corner < first + 3; ++corner)
      if (twin[corner] < 0 || surfels.triangle_surfel[twin[corner] / 3] != surfel)
        look_around(corner); // within the surfel, all triangles around are its own
  }
  return std::sqrt(square);
}

Sample sample_of(const SurfelSource &source, int32_t triangle, float lean) {
  vec3 corners[3], normals[3];
  for (int32_t k = 0; k < 3; ++k) {
    corners[k] = source.position(3 * triangle + k);
    normals[k] = source.normals.corner(static_cast<size_t>(3 * triangle + k));
  }
  Sample sample = sample_of_triangle(corners, normals, lean);
  sample.noise = source.noise_of(triangle);
  sample.facet = sample.area;
  return sample;
}

Surfels build_surfels(const SurfelSource &source, float radius, Fineness fineness) {
  return Builder(source, radius, fineness).run();
}

} // namespace paradesc
