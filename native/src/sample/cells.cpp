// Texels → cells by union-find within blocks; links between cells by adjacent texels, by mesh edges and by seams.
#include "sample/cells.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>
#include <tuple>

#include "mesh/cluster_tree.h"
#include "sample/chart_map.h"
#include "support/curve.h"
#include "support/parallel.h"

namespace paradesc {

namespace {

struct Unions {
  std::vector<int32_t> parent;
  explicit Unions(size_t count) : parent(count) { std::iota(parent.begin(), parent.end(), 0); }
  int32_t root(int32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  }
  // The lower number stays the root, so that labels do not depend on the order of unions.
  void join(int32_t a, int32_t b) {
    a = root(a);
    b = root(b);
    parent[std::max(a, b)] = std::min(a, b);
  }
};

using Pairs = std::vector<uint64_t>; // two numbers each, for sorting

// A texel at which the surface crosses from one cell to another.
struct Crossing {
  int32_t low, high; // cells
  int32_t texel;
  auto operator<=>(const Crossing &) const = default;
};

uint64_t pair_of(int64_t a, int64_t b) { return static_cast<uint64_t>(a) << 32 | static_cast<uint64_t>(b); }

template <class Value> void sort_unique(std::vector<Value> &values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

// Sorted pairs → lists by the first number.
void to_lists(Pairs &pairs, int count, std::vector<int32_t> &begin, std::vector<int32_t> &list) {
  sort_unique(pairs);
  begin.assign(static_cast<size_t>(count) + 1, 0);
  for (const uint64_t pair : pairs) {
    ++begin[(pair >> 32) + 1];
    list.push_back(static_cast<int32_t>(pair & 0xffffffffu));
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
}

constexpr int one_block = 4096; // edges, triangles or wedges per block of a parallel loop

class Builder {
public:
  Builder(const std::vector<int32_t> &ids, const BorderGrid &grid, const Triangles &triangles, const HalfEdges &half_edges,
          const Charts &charts, int block_size, int threads)
      : map_(ids, grid, charts), triangles_(triangles), half_edges_(half_edges), charts_(charts), size_(grid.size),
        threads_(threads) {
    cells_.block_size = block_size;
  }

  Cells build() {
    label_texels();
    link_along_edges();
    attach_texelless_triangles();
    checkpoint();
    list_links();
    checkpoint();
    to_lists(boundaries_, cells_.count, cells_.boundary_begin, cells_.boundary);
    cells_.wedge_cell.resize(charts_.wedges.size());
    parallel_blocks(static_cast<int>(charts_.wedges.size()), threads_, one_block, [&](int begin, int end) {
      for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
        const Wedge &wedge = charts_.wedges[i];
        cells_.wedge_cell[i] = cell_at(nudged(wedge.uv, wedge.inside), wedge.chart);
      }
    });
    // A wedge without a texel starts at the first texel along the edges from it, else in its triangle's cell.
    for (size_t corner = 0; corner < charts_.corner_wedge.size(); ++corner) {
      const int32_t wedge = charts_.corner_wedge[corner];
      if (wedge >= 0 && cells_.wedge_cell[wedge] < 0) cells_.wedge_cell[wedge] = cell_beside(static_cast<int>(corner));
    }
    cover_texels();
    return std::move(cells_);
  }

private:
  template <class Visit> void each_texel(const Visit &visit) const {
    for (int y = 0; y < size_; ++y)
      for (int x = 0; x < size_; ++x) visit(x, y, static_cast<int32_t>(map_.index(x, y)));
  }

  // Calls visit(texel, other) for texels that share a side or a corner and are joined.
  template <class Visit> void each_joined_pair(const Visit &visit) const {
    for (int y = 0; y < size_; ++y) {
      checkpoint();
      for (int x = 0; x < size_; ++x) {
        const int32_t chart = map_.chart(x, y);
        if (chart < 0) continue;
        for (const auto &[dx, dy] : {std::pair(1, 0), std::pair(0, 1), std::pair(1, 1), std::pair(-1, 1)}) {
          if (!map_.inside(x + dx, y + dy) || map_.chart(x + dx, y + dy) != chart) continue;
          if (map_.is_far_from_borders(x, y) || map_.joined(map_.middle(x, y), map_.middle(x + dx, y + dy), chart))
            visit(x, y, x + dx, y + dy);
        }
      }
    }
  }

  void label_texels() {
    const size_t texels = static_cast<size_t>(size_) * static_cast<size_t>(size_);
    const int block = cells_.block_size;
    Unions unions(texels);
    std::vector<std::pair<int32_t, int32_t>> between; // joined texels in different blocks
    each_joined_pair([&](int x, int y, int x2, int y2) {
      const auto a = static_cast<int32_t>(map_.index(x, y)), b = static_cast<int32_t>(map_.index(x2, y2));
      if (x / block == x2 / block && y / block == y2 / block)
        unions.join(a, b);
      else
        between.emplace_back(a, b);
    });
    const std::vector<int32_t> rank = build_cluster_tree(half_edges_).rank;
    std::vector<std::tuple<int32_t, int32_t, int32_t>> roots; // triangle's rank in the cluster tree, block's order, first texel
    each_texel([&](int x, int y, int32_t texel) {
      if (map_.chart(x, y) >= 0 && unions.root(texel) == texel)
        roots.emplace_back(rank[map_.triangle(x, y)], on_curve(x / block, y / block), texel);
    });
    std::sort(roots.begin(), roots.end());
    cells_.label.assign(texels, -1);
    for (const auto &[of_triangle, of_block, texel] : roots) cells_.label[texel] = cells_.count++;
    each_texel([&](int x, int y, int32_t texel) {
      if (map_.chart(x, y) >= 0) cells_.label[texel] = cells_.label[unions.root(texel)];
    });
    for (const auto &[a, b] : between) link(a, b, crossings_);
  }

  // Links the cells of the two texels, if they differ.
  void link(int64_t texel_a, int64_t texel_b, std::vector<Crossing> &crossings) const {
    if (texel_a < 0 || texel_b < 0) return;
    const int32_t a = cells_.label[texel_a], b = cells_.label[texel_b];
    if (a != b) crossings.push_back({std::min(a, b), std::max(a, b), static_cast<int32_t>(std::min(texel_a, texel_b))});
  }

  // Sorts crossings into one bucket per lower cell first, since most crossings differ in it.
  void sort_crossings() {
    std::vector<int32_t> begin(static_cast<size_t>(cells_.count) + 2, 0);
    for (const Crossing &crossing : crossings_) ++begin[crossing.low + 2];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<Crossing> sorted(crossings_.size());
    for (const Crossing &crossing : crossings_) sorted[begin[crossing.low + 1]++] = crossing;
    parallel_blocks(cells_.count, threads_, one_block, [&](int first, int last) {
      for (auto cell = static_cast<size_t>(first); cell < static_cast<size_t>(last); ++cell)
        std::sort(sorted.begin() + begin[cell], sorted.begin() + begin[cell + 1]);
    });
    sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
    crossings_ = std::move(sorted);
  }

  void list_links() {
    sort_crossings();
    std::vector<ivec2> ends; // the two cells of each link
    for (size_t i = 0; i < crossings_.size(); ++i) {
      const Crossing &crossing = crossings_[i];
      if (i == 0 || crossing.low != crossings_[i - 1].low || crossing.high != crossings_[i - 1].high) {
        cells_.link_begin.push_back(static_cast<int32_t>(i));
        ends.emplace_back(crossing.low, crossing.high);
      }
      cells_.link_texel.push_back(crossing.texel);
    }
    cells_.link_begin.push_back(static_cast<int32_t>(crossings_.size()));
    cells_.adjacency_begin.assign(static_cast<size_t>(cells_.count) + 1, 0);
    for (const ivec2 pair : ends)
      for (const int32_t cell : {pair.x, pair.y}) ++cells_.adjacency_begin[cell + 1];
    std::partial_sum(cells_.adjacency_begin.begin(), cells_.adjacency_begin.end(), cells_.adjacency_begin.begin());
    cells_.adjacency.resize(2 * ends.size());
    std::vector<int32_t> next(cells_.adjacency_begin.begin(), cells_.adjacency_begin.end() - 1);
    for (size_t i = 0; i < ends.size(); ++i) {
      cells_.adjacency[next[ends[i].x]++] = ivec2(ends[i].y, i);
      cells_.adjacency[next[ends[i].y]++] = ivec2(ends[i].x, i);
    }
  }

  // Measures texels on borders by the part that their chart covers, also if their centers lie off the chart: otherwise seams
  // would be as rough as texels.
  void cover_texels() {
    std::vector<int32_t> covered(2 * cells_.label.size());
    parallel_blocks(size_, threads_, 8, [&](int begin, int end) {
      for (int y = begin; y < end; ++y)
        for (int x = 0; x < size_; ++x) {
          const size_t texel = map_.index(x, y);
          const auto [cell, part] =
              map_.has_border(x, y) && map_.owner(x, y) >= 0 ? partly_covered(x, y) : std::pair(cells_.label[texel], 16);
          covered[2 * texel] = cell;
          covered[2 * texel + 1] = part * 4096;
        }
    });
    cells_.label = std::move(covered);
    std::vector<ivec4> bounds(static_cast<size_t>(cells_.count), ivec4(size_, size_, 0, 0)); // low, past the end
    each_texel([&](int x, int y, int32_t texel) {
      const int32_t cell = cells_.label[2 * static_cast<size_t>(texel)];
      if (cell < 0) return;
      ivec4 &box = bounds[cell];
      box = ivec4(std::min(box.x, x), std::min(box.y, y), std::max(box.z, x + 1), std::max(box.w, y + 1));
    });
    for (const ivec4 box : bounds) cells_.box.push_back(box.z > 0 ? ivec4(box.x, box.y, box.z - box.x, box.w - box.y) : ivec4(0));
  }

  // The cell of a texel on a border, and how many of 16 positions in the texel lie on the chart. A texel whose center is off the
  // chart goes to an adjacent cell in the same block, if there is one.
  std::pair<int32_t, int> partly_covered(int x, int y) const {
    const int32_t chart = map_.owner(x, y);
    const bool center_inside = map_.chart(x, y) >= 0;
    const dvec2 center = center_inside ? map_.middle(x, y) : dvec2(x + 0.5, y + 0.5);
    int32_t cell = center_inside ? cells_.label[map_.index(x, y)] : -1;
    int part = 0;
    for (int i = 0; i < 16; ++i) {
      // Positions are slightly off a regular grid, so that no border runs through them.
      const dvec2 position(x + (i % 4 + 0.4987) / 4.0, y + (i / 4 + 0.5023) / 4.0);
      if (map_.crosses_oddly(x, y, center, position, chart) == center_inside) continue;
      ++part;
      if (cell >= 0) continue;
      const int64_t carrier = map_.carrier(position, chart);
      const int block = cells_.block_size;
      if (carrier >= 0 && carrier % size_ / block == x / block && carrier / size_ / block == y / block) cell = cell_of(carrier);
    }
    return {cell, part};
  }

  dvec2 uv_of(int corner) const { return dvec2(charts_.corner_uv[corner]) * static_cast<double>(size_); }

  // The wedge's position in texels, moved slightly into the chart: a position on the border would be on both sides.
  dvec2 nudged(vec2 uv, vec2 inside) const {
    const dvec2 position = dvec2(uv) * static_cast<double>(size_), way = dvec2(inside) * static_cast<double>(size_) - position;
    return position + way * std::min(0.1, 0.01 / std::max(length(way), 1e-9));
  }

  int32_t cell_of(int64_t texel) const { return texel < 0 ? -1 : cells_.label[texel]; }
  int32_t cell_at(dvec2 position, int32_t chart) const { return cell_of(map_.carrier(position, chart)); }

  // A half-edge in the UV map, in texels, and the middle of its triangle.
  struct Line {
    dvec2 start, way, middle;
    int32_t chart;
  };

  Line line_of(int half_edge) const {
    const dvec2 a = uv_of(half_edge), b = uv_of(next_corner(half_edge)), c = uv_of(previous_corner(half_edge));
    return {a, b - a, (a + b + c) / 3.0, charts_.triangle_chart[half_edge / 3]};
  }

  // The texel that carries a position on a half-edge, moved slightly into its triangle.
  int64_t texel_on(const Line &line, double t) const {
    const dvec2 position = line.start + line.way * t;
    const dvec2 way = line.middle - position;
    return map_.carrier(position + way * std::min(0.1, 0.01 / std::max(length(way), 1e-9)), line.chart);
  }

  // The number of steps along an edge that skips no texel.
  int steps_along(const Line &line) const {
    return std::clamp(static_cast<int>(std::ceil(length(line.way) / 0.7)), 1, 4 * size_);
  }

  // The cell nearest to a corner along the two edges of its triangle, looking on both sides of each edge.
  int32_t cell_beside(int corner) const {
    int32_t best = cells_.triangle_cell[corner / 3];
    double nearest = 1e30;
    auto follow = [&](int half_edge, bool from_end) {
      if (half_edge < 0 || charts_.triangle_chart[half_edge / 3] < 0) return;
      const float length_3d = distance(position_of(half_edge), position_of(next_corner(half_edge)));
      const Line line = line_of(half_edge);
      const int steps = steps_along(line);
      for (int i = 0; i <= steps; ++i) {
        const double t = static_cast<double>(i) / steps;
        if (t * static_cast<double>(length_3d) >= nearest) return;
        const int64_t texel = texel_on(line, from_end ? 1.0 - t : t);
        if (texel < 0) continue;
        nearest = t * static_cast<double>(length_3d);
        best = cell_of(texel);
        return;
      }
    };
    const int before = next_corner(next_corner(corner));
    follow(corner, false);
    follow(half_edges_.twin[corner], true);
    follow(before, true);
    follow(half_edges_.twin[before], false);
    return best;
  }

  vec3 position_of(int corner) const { return triangles_.position(corner); }

  // Walks along every edge of the mesh, texel by texel: a triangle connects cells even if texels do not show it, and across a
  // seam each position on the edge is on both sides.
  void link_along_edges() {
    const int count = 3 * triangles_.triangle_count;
    first_.assign(static_cast<size_t>(count), -1);
    carried_.assign(static_cast<size_t>(count), 0);
    struct Found {
      std::vector<Crossing> crossings;
      Pairs boundaries;
    };
    std::vector<Found> found(static_cast<size_t>(Blocks{count, one_block}.number()));
    parallel_blocks(count, threads_, one_block, [&](int begin, int end) {
      Found here; // a local list, because neighboring vectors share cache lines
      for (int half_edge = begin; half_edge < end; ++half_edge) link_along(half_edge, here.crossings, here.boundaries);
      sort_unique(here.crossings);
      found[begin / one_block] = std::move(here);
    });
    for (const Found &here : found) {
      crossings_.insert(crossings_.end(), here.crossings.begin(), here.crossings.end());
      boundaries_.insert(boundaries_.end(), here.boundaries.begin(), here.boundaries.end());
    }
  }

  void link_along(int half_edge, std::vector<Crossing> &crossings, Pairs &boundaries) {
    if (charts_.triangle_chart[half_edge / 3] < 0) return;
    const int32_t border = charts_.half_edge_border[half_edge];
    const int32_t twin = half_edges_.twin[half_edge];
    if (border < 0 && twin > half_edge) return; // visits an inner edge once
    const bool seam = border >= 0 && charts_.borders[border].kind == BorderKind::seam;
    const bool ends = border >= 0 && charts_.borders[border].kind == BorderKind::boundary;
    const Line line = line_of(half_edge), beyond = seam ? line_of(twin) : line;
    const int steps = std::max(steps_along(line), steps_along(beyond));
    int64_t previous = -1;
    for (int i = 0; i <= steps; ++i) {
      const double t = static_cast<double>(i) / steps;
      const int64_t texel = texel_on(line, t);
      if (texel < 0) continue;
      link(previous, texel, crossings);
      if (previous < 0) first_[half_edge] = texel;
      const int64_t other = seam ? texel_on(beyond, 1.0 - t) : texel;
      if (seam) link(texel, other, crossings);
      carried_[half_edge] |= other >= 0;
      if (ends) boundaries.push_back(pair_of(cell_of(texel), half_edge));
      previous = texel;
    }
  }

  // The texel that carries each triangle's centroid, or -1.
  std::vector<int64_t> carriers() const {
    std::vector<int64_t> texel(static_cast<size_t>(triangles_.triangle_count), -1);
    parallel_blocks(triangles_.triangle_count, threads_, one_block, [&](int begin, int end) {
      for (int32_t t = begin; t < end; ++t) {
        const int32_t chart = charts_.triangle_chart[t];
        if (half_edges_.corner_point[3 * t] < 0 || chart < 0) continue;
        texel[t] = map_.carrier((uv_of(3 * t) + uv_of(3 * t + 1) + uv_of(3 * t + 2)) / 3.0, chart);
      }
    });
    return texel;
  }

  // Links the cells of two triangles whose common edge lies too far in a corner to have texels.
  void link_over_uncarried_edges(const std::vector<int64_t> &texel) {
    for (size_t half_edge = 0; half_edge < carried_.size(); ++half_edge) {
      const int32_t twin = half_edges_.twin[half_edge];
      if (twin < static_cast<int32_t>(half_edge) || carried_[half_edge] || carried_[twin]) continue;
      link(texel[half_edge / 3], texel[twin / 3], crossings_);
    }
  }

  // The first texel along an edge, or -1. For an inner edge only one of the two half-edges stores it.
  int64_t first_along(size_t half_edge) const {
    const int32_t twin = half_edges_.twin[half_edge];
    const bool inner = charts_.half_edge_border[half_edge] < 0 && twin >= 0;
    return inner && first_[half_edge] < 0 ? first_[twin] : first_[half_edge];
  }

  // Triangles without a texel nearby belong to the cell from which a breadth-first search over the surface reaches them first.
  // Cells whose searches meet are linked, and so are cells of texels that carry only an edge of such a triangle.
  void attach_texelless_triangles() {
    std::vector<int64_t> texel = carriers();
    std::vector<uint8_t> texelless(texel.size(), 0);
    for (size_t t = 0; t < texelless.size(); ++t) texelless[t] = texel[t] < 0 && half_edges_.corner_point[3 * t] >= 0;
    link_over_uncarried_edges(texel);
    std::queue<int32_t> queue;
    for (int32_t h = 0; h < 3 * triangles_.triangle_count; ++h) { // only triangles beside texelless ones start searches
      const int32_t twin = half_edges_.twin[h];
      if (texel[h / 3] < 0 || twin < 0 || !texelless[twin / 3]) continue;
      if (queue.empty() || queue.back() != h / 3) queue.push(h / 3);
    }
    Pairs pairs;
    while (!queue.empty()) {
      const int32_t t = queue.front();
      queue.pop();
      for (int i = 0; i < 3; ++i) {
        const int32_t twin = half_edges_.twin[3 * t + i];
        if (twin < 0) continue;
        int64_t &other = texel[twin / 3];
        if (other < 0) {
          other = texel[t];
          for (size_t k = 0; k < 3; ++k) link(first_along(3 * static_cast<size_t>(twin / 3) + k), other, crossings_);
          pairs.push_back(pair_of(cell_of(other), twin / 3));
          queue.push(twin / 3);
        } else if (texelless[t] || texelless[twin / 3]) {
          link(texel[t], other, crossings_);
        }
      }
    }
    to_lists(pairs, cells_.count, cells_.texelless_begin, cells_.texelless);
    cells_.triangle_cell.reserve(texel.size());
    for (const int64_t one : texel) cells_.triangle_cell.push_back(cell_of(one));
  }

  ChartMap map_;
  const Triangles &triangles_;
  const HalfEdges &half_edges_;
  const Charts &charts_;
  int size_, threads_;
  Cells cells_;
  std::vector<Crossing> crossings_;
  std::vector<int64_t> first_;   // (half-edges) the first texel along it, or -1; inner edges: on one of the two
  std::vector<uint8_t> carried_; // (half-edges) some position has texels on both sides
  Pairs boundaries_;
};

} // namespace

Cells build_cells(const std::vector<int32_t> &ids, const BorderGrid &grid, const Triangles &triangles,
                  const HalfEdges &half_edges, const Charts &charts, int block_size, int threads) {
  return Builder(ids, grid, triangles, half_edges, charts, block_size, threads).build();
}

std::vector<int32_t> find_cells(const Cells &cells, const std::vector<int32_t> &ids, const BorderGrid &grid, const Charts &charts,
                                const std::vector<LayoutPosition> &positions, int threads) {
  const ChartMap map(ids, grid, charts);
  std::vector<int32_t> found(positions.size());
  parallel_blocks(static_cast<int>(positions.size()), threads, 1024, [&](int begin, int end) {
    for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
      const auto triangle = static_cast<size_t>(positions[i].triangle);
      const dvec2 texel = dvec2(positions[i].uv) * static_cast<double>(grid.size);
      const int64_t carrier = map.carrier(texel, charts.triangle_chart[triangle]);
      found[i] = carrier >= 0 ? cells.label[2 * static_cast<size_t>(carrier)] : cells.triangle_cell[triangle];
    }
  });
  return found;
}

} // namespace paradesc
