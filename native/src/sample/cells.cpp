// Texels → cells by union within blocks; links by texels side by side, by mesh edges and by seams.
#include "sample/cells.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>

#include "support/parallel.h"

namespace paradesc {

namespace {

// Without the call that std::floor is where processors before 2008 have to be served.
int floor_of(double x) {
  const int whole = static_cast<int>(x);
  return whole - (x < whole);
}

// Where a place of a chart belongs, and whether two places of a chart are joined by a straight way on it.
class ChartMap {
public:
  ChartMap(const std::vector<int32_t> &ids, const BorderGrid &grid, const Triangles &triangles)
      : ids_(ids), grid_(grid), triangles_(triangles), size_(grid.size) {}

  bool inside(int x, int y) const { return x >= 0 && y >= 0 && x < size_ && y < size_; }
  size_t index(int x, int y) const { return static_cast<size_t>(y) * static_cast<size_t>(size_) + static_cast<size_t>(x); }
  // The chart of a texel whose center lies on one, else -1.
  int32_t chart(int x, int y) const { return ids_[2 * index(x, y) + 1] >= 0 ? ids_[2 * index(x, y)] : -1; }

  // A texel's center; beside a border, a little towards the middle of its triangle: rasterizers round, and what they call inside
  // may be outside by a hair.
  dvec2 middle(int x, int y) const {
    const dvec2 center(x + 0.5, y + 0.5);
    const int32_t triangle = ids_[2 * index(x, y) + 1];
    if (!has_border(x, y) || triangle < 0) return center;
    dvec2 sum(0.0);
    for (size_t i = 0; i < 3; ++i) sum += dvec2(triangles_.corner_uv[3 * static_cast<size_t>(triangle) + i]);
    const dvec2 way = sum * (size_ / 3.0) - center;
    return center + way * std::min(0.5, 0.02 / std::max(length(way), 1e-9));
  }

  // No border of the chart crosses the way from a to b, which lie in these two texels or beside them.
  bool joined(dvec2 a, dvec2 b, int32_t of_chart) const {
    const int x0 = floor_of(std::min(a.x, b.x)), x1 = floor_of(std::max(a.x, b.x));
    const int y0 = floor_of(std::min(a.y, b.y)), y1 = floor_of(std::max(a.y, b.y));
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x)
        if (inside(x, y) && crossed(x, y, a, b, of_chart)) return false;
    return true;
  }

  // Whether the way from a to b, both in this texel, crosses the chart's borders an odd number of times.
  bool crosses_oddly(int x, int y, dvec2 a, dvec2 b, int32_t of_chart) const {
    bool odd = false;
    each_border(x, y, of_chart, [&](dvec2 c, dvec2 d) {
      const bool between = (cross(b - a, c - a) > 0.0) != (cross(b - a, d - a) > 0.0);
      if (between && (cross(d - c, a - c) > 0.0) != (cross(d - c, b - c) > 0.0)) odd = !odd;
    });
    return odd;
  }

  bool has_border(int x, int y) const { return grid_.cells[2 * index(x, y)] < 0; }
  // No border runs through the texels around.
  bool is_far_from_borders(int x, int y) const { return grid_.cells[2 * index(x, y)] > 0; }
  int32_t owner(int x, int y) const { return ids_[2 * index(x, y)]; } // the chart that has the texel, also by a line

  // The texel that carries a place on a chart: its own, or one beside it in sight; -1: none.
  int64_t carrier(dvec2 place, int32_t of_chart) const {
    const int x = floor_of(place.x), y = floor_of(place.y);
    if (inside(x, y) && chart(x, y) == of_chart && (!has_border(x, y) || joined(place, middle(x, y), of_chart)))
      return static_cast<int64_t>(index(x, y));
    int64_t best = -1;
    double nearest = 1e9;
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        if (!inside(x + dx, y + dy) || chart(x + dx, y + dy) != of_chart) continue;
        const dvec2 there = middle(x + dx, y + dy);
        const double distance = dot(there - place, there - place);
        if (distance >= nearest || !joined(place, there, of_chart)) continue;
        nearest = distance;
        best = static_cast<int64_t>(index(x + dx, y + dy));
      }
    return best;
  }

private:
  template <class Visit> void each_border(int x, int y, int32_t of_chart, const Visit &visit) const {
    const size_t texel = index(x, y);
    const int32_t begin = grid_.cells[2 * texel + 1];
    for (int32_t i = begin; i < begin - std::min(grid_.cells[2 * texel], 0); ++i) {
      if (grid_.list[2 * static_cast<size_t>(i) + 1] != of_chart) continue;
      const dvec4 uv =
          dvec4(grid_.border_uv[static_cast<size_t>(grid_.list[2 * static_cast<size_t>(i)])]) * static_cast<double>(size_);
      visit(dvec2(uv.x, uv.y), dvec2(uv.z, uv.w));
    }
  }

  bool crossed(int x, int y, dvec2 a, dvec2 b, int32_t of_chart) const {
    bool result = false;
    each_border(x, y, of_chart, [&](dvec2 c, dvec2 d) {
      const double side_c = cross(b - a, c - a), side_d = cross(b - a, d - a), side_a = cross(d - c, a - c),
                   side_b = cross(d - c, b - c);
      result |= side_c * side_d <= 0.0 && side_a * side_b < 0.0;
    });
    return result;
  }

  const std::vector<int32_t> &ids_;
  const BorderGrid &grid_;
  const Triangles &triangles_;
  int size_;
};

struct Unions {
  std::vector<int32_t> parent;
  explicit Unions(size_t count) : parent(count) { std::iota(parent.begin(), parent.end(), 0); }
  int32_t root(int32_t i) {
    while (parent[static_cast<size_t>(i)] != i)
      i = parent[static_cast<size_t>(i)] = parent[static_cast<size_t>(parent[static_cast<size_t>(i)])];
    return i;
  }
  // The lower number stays root, so that labels do not depend on the order of unions.
  void join(int32_t a, int32_t b) {
    a = root(a);
    b = root(b);
    parent[static_cast<size_t>(std::max(a, b))] = std::min(a, b);
  }
};

using Pairs = std::vector<uint64_t>; // two numbers each, for sorting

// One place where the surface goes over from cell to cell.
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
    ++begin[static_cast<size_t>(pair >> 32) + 1];
    list.push_back(static_cast<int32_t>(pair & 0xffffffffu));
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
}

constexpr int one_block = 4096; // edges, triangles or sites, for one thread at a time

class Builder {
public:
  Builder(const std::vector<int32_t> &ids, const BorderGrid &grid, const Triangles &triangles, const HalfEdges &half_edges,
          const Charts &charts, int block_size, int threads)
      : map_(ids, grid, triangles), triangles_(triangles), half_edges_(half_edges), charts_(charts), size_(grid.size),
        threads_(threads) {
    cells_.block_size = block_size;
  }

  Cells build() {
    label_texels();
    link_along_edges();
    attach_bare_triangles();
    list_links();
    to_lists(boundaries_, cells_.count, cells_.boundary_begin, cells_.boundary);
    cells_.site_cell.resize(charts_.sites.size());
    parallel_blocks(static_cast<int>(charts_.sites.size()), threads_, one_block, [&](int begin, int end) {
      for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
        const Site &site = charts_.sites[i];
        cells_.site_cell[i] = cell_at(nudged(site.uv, site.inside), site.chart);
      }
    });
    // A site that no texel carries starts where the surface around it does.
    for (size_t corner = 0; corner < charts_.corner_site.size(); ++corner) {
      const int32_t site = charts_.corner_site[corner];
      if (site >= 0 && cells_.site_cell[static_cast<size_t>(site)] < 0)
        cells_.site_cell[static_cast<size_t>(site)] = cells_.triangle_cell[corner / 3];
    }
    cover_texels();
    return std::move(cells_);
  }

private:
  // Calls visit(texel, other) for texels side by side or at a corner that are joined.
  template <class Visit> void each_joined_pair(const Visit &visit) const {
    for (int y = 0; y < size_; ++y)
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

  void label_texels() {
    const size_t texels = static_cast<size_t>(size_) * static_cast<size_t>(size_);
    const int block = cells_.block_size;
    Unions unions(texels);
    std::vector<std::pair<int32_t, int32_t>> between; // texels joined over the sides of blocks
    each_joined_pair([&](int x, int y, int x2, int y2) {
      const auto a = static_cast<int32_t>(map_.index(x, y)), b = static_cast<int32_t>(map_.index(x2, y2));
      if (x / block == x2 / block && y / block == y2 / block)
        unions.join(a, b);
      else
        between.emplace_back(a, b);
    });
    cells_.label.assign(texels, -1);
    for (int y = 0; y < size_; ++y)
      for (int x = 0; x < size_; ++x) {
        if (map_.chart(x, y) < 0) continue;
        const auto texel = static_cast<int32_t>(map_.index(x, y));
        const int32_t root = unions.root(texel);
        if (root == texel) {
          cells_.label[static_cast<size_t>(texel)] = cells_.count++;
          cells_.corner.push_back(x / block * block);
          cells_.corner.push_back(y / block * block);
        } else {
          cells_.label[static_cast<size_t>(texel)] = cells_.label[static_cast<size_t>(root)];
        }
      }
    for (const auto &[a, b] : between) link(a, b, crossings_);
  }

  // texel: on either of them, beside the place where one goes over into the other.
  void link(int64_t texel_a, int64_t texel_b, std::vector<Crossing> &crossings) const {
    if (texel_a < 0 || texel_b < 0) return;
    const int32_t a = cells_.label[static_cast<size_t>(texel_a)], b = cells_.label[static_cast<size_t>(texel_b)];
    if (a != b) crossings.push_back({std::min(a, b), std::max(a, b), static_cast<int32_t>(std::min(texel_a, texel_b))});
  }

  // By their lower cell first, one bucket each: what most of them differ by.
  void sort_crossings() {
    std::vector<int32_t> begin(static_cast<size_t>(cells_.count) + 2, 0);
    for (const Crossing &crossing : crossings_) ++begin[static_cast<size_t>(crossing.low) + 2];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<Crossing> sorted(crossings_.size());
    for (const Crossing &crossing : crossings_)
      sorted[static_cast<size_t>(begin[static_cast<size_t>(crossing.low) + 1]++)] = crossing;
    parallel_blocks(cells_.count, threads_, one_block, [&](int first, int last) {
      for (auto cell = static_cast<size_t>(first); cell < static_cast<size_t>(last); ++cell)
        std::sort(sorted.begin() + begin[cell], sorted.begin() + begin[cell + 1]);
    });
    sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
    crossings_ = std::move(sorted);
  }

  void list_links() {
    sort_crossings();
    std::vector<ivec2> ends; // of each link
    for (size_t i = 0; i < crossings_.size(); ++i) {
      const Crossing &crossing = crossings_[i];
      if (i == 0 || crossing.low != crossings_[i - 1].low || crossing.high != crossings_[i - 1].high) {
        cells_.link_begin.push_back(static_cast<int32_t>(i));
        ends.emplace_back(crossing.low, crossing.high);
      }
      cells_.link_texel.push_back(crossing.texel);
    }
    cells_.link_begin.push_back(static_cast<int32_t>(crossings_.size()));
    cells_.side_begin.assign(static_cast<size_t>(cells_.count) + 1, 0);
    for (const ivec2 pair : ends)
      for (const int32_t cell : {pair.x, pair.y}) ++cells_.side_begin[static_cast<size_t>(cell) + 1];
    std::partial_sum(cells_.side_begin.begin(), cells_.side_begin.end(), cells_.side_begin.begin());
    cells_.side.resize(2 * ends.size());
    std::vector<int32_t> next(cells_.side_begin.begin(), cells_.side_begin.end() - 1);
    for (size_t i = 0; i < ends.size(); ++i) {
      cells_.side[static_cast<size_t>(next[static_cast<size_t>(ends[i].x)]++)] = ivec2(ends[i].y, i);
      cells_.side[static_cast<size_t>(next[static_cast<size_t>(ends[i].y)]++)] = ivec2(ends[i].x, i);
    }
  }

  // A texel on a border counts by the part that its chart covers, also where its center lies beyond: else seams are as rough as
  // texels.
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
  }

  // The cell of a texel on a border, and how many of 16 places in it lie on the chart. A texel whose center is off the chart goes
  // to the cell beside it in the same block, if there is one.
  std::pair<int32_t, int> partly_covered(int x, int y) const {
    const int32_t chart = map_.owner(x, y);
    const bool center_inside = map_.chart(x, y) >= 0;
    const dvec2 center = center_inside ? map_.middle(x, y) : dvec2(x + 0.5, y + 0.5);
    int32_t cell = center_inside ? cells_.label[map_.index(x, y)] : -1;
    int part = 0;
    for (int i = 0; i < 16; ++i) {
      // Off the regular places by a little, so that no border runs through them.
      const dvec2 place(x + (i % 4 + 0.4987) / 4.0, y + (i / 4 + 0.5023) / 4.0);
      if (map_.crosses_oddly(x, y, center, place, chart) == center_inside) continue;
      ++part;
      if (cell >= 0) continue;
      const int64_t carrier = map_.carrier(place, chart);
      const int block = cells_.block_size;
      if (carrier >= 0 && carrier % size_ / block == x / block && carrier / size_ / block == y / block) cell = cell_of(carrier);
    }
    return {cell, part};
  }

  dvec2 uv_of(int corner) const { return dvec2(triangles_.corner_uv[static_cast<size_t>(corner)]) * static_cast<double>(size_); }

  // A little way into the chart, in texels: a place on a border lies on both sides of it.
  dvec2 nudged(vec2 uv, vec2 inside) const {
    const dvec2 place = dvec2(uv) * static_cast<double>(size_), way = dvec2(inside) * static_cast<double>(size_) - place;
    return place + way * std::min(0.1, 0.01 / std::max(length(way), 1e-9));
  }

  int32_t cell_of(int64_t texel) const { return texel < 0 ? -1 : cells_.label[static_cast<size_t>(texel)]; }
  int32_t cell_at(dvec2 place, int32_t chart) const { return cell_of(map_.carrier(place, chart)); }

  // A half-edge in the UV map, in texels, and the middle of its triangle.
  struct Line {
    dvec2 start, way, middle;
    int32_t chart;
  };

  Line line_of(int half_edge) const {
    const dvec2 a = uv_of(half_edge), b = uv_of(next_corner(half_edge)), c = uv_of(previous_corner(half_edge));
    return {a, b - a, (a + b + c) / 3.0, charts_.triangle_chart[static_cast<size_t>(half_edge / 3)]};
  }

  // The texel that carries a place on a half-edge, just inside its triangle.
  int64_t texel_on(const Line &line, double t) const {
    const dvec2 place = line.start + line.way * t;
    const dvec2 way = line.middle - place;
    return map_.carrier(place + way * std::min(0.1, 0.01 / std::max(length(way), 1e-9)), line.chart);
  }

  // Along every edge of the mesh, texel by texel: what lies on one triangle is connected even where texels do not show it, and
  // over a seam the same place of the edge is on both sides.
  void link_along_edges() {
    struct Found {
      std::vector<Crossing> crossings;
      Pairs boundaries;
    };
    const int count = 3 * triangles_.triangle_count;
    std::vector<Found> found(static_cast<size_t>((count + one_block - 1) / one_block));
    parallel_blocks(count, threads_, one_block, [&](int begin, int end) {
      Found &here = found[static_cast<size_t>(begin / one_block)];
      for (int half_edge = begin; half_edge < end; ++half_edge) link_along(half_edge, here.crossings, here.boundaries);
      sort_unique(here.crossings);
    });
    for (const Found &here : found) {
      crossings_.insert(crossings_.end(), here.crossings.begin(), here.crossings.end());
      boundaries_.insert(boundaries_.end(), here.boundaries.begin(), here.boundaries.end());
    }
  }

  void link_along(int half_edge, std::vector<Crossing> &crossings, Pairs &boundaries) const {
    if (charts_.triangle_chart[static_cast<size_t>(half_edge / 3)] < 0) return;
    const int32_t border = charts_.half_edge_border[static_cast<size_t>(half_edge)];
    const int32_t twin = half_edges_.twin[static_cast<size_t>(half_edge)];
    if (border < 0 && twin > half_edge) return; // an inner edge once
    const bool seam = border >= 0 && charts_.borders[static_cast<size_t>(border)].kind == BorderKind::seam;
    const bool ends = border >= 0 && charts_.borders[static_cast<size_t>(border)].kind == BorderKind::boundary;
    const Line line = line_of(half_edge), beyond = seam ? line_of(twin) : line;
    const double span = std::max(length(line.way), length(beyond.way));
    const int steps = std::clamp(static_cast<int>(std::ceil(span / 0.7)), 1, 4 * size_);
    int64_t previous = -1;
    for (int i = 0; i <= steps; ++i) {
      const double t = static_cast<double>(i) / steps;
      const int64_t texel = texel_on(line, t);
      if (texel < 0) continue;
      link(previous, texel, crossings);
      if (seam) link(texel, texel_on(beyond, 1.0 - t), crossings);
      if (ends) boundaries.push_back(pair_of(cell_of(texel), half_edge));
      previous = texel;
    }
  }

  // The texel that carries each triangle's middle, or -1.
  std::vector<int64_t> carriers() const {
    std::vector<int64_t> texel(static_cast<size_t>(triangles_.triangle_count), -1);
    parallel_blocks(triangles_.triangle_count, threads_, one_block, [&](int begin, int end) {
      for (int32_t t = begin; t < end; ++t) {
        const int32_t chart = charts_.triangle_chart[static_cast<size_t>(t)];
        if (half_edges_.corner_point[static_cast<size_t>(3 * t)] < 0 || chart < 0) continue;
        texel[static_cast<size_t>(t)] = map_.carrier((uv_of(3 * t) + uv_of(3 * t + 1) + uv_of(3 * t + 2)) / 3.0, chart);
      }
    });
    return texel;
  }

  // Triangles without a texel near belong to the cell from which the surface leads to them first; where such ways from two cells
  // meet, the cells are linked.
  void attach_bare_triangles() {
    std::vector<int64_t> texel = carriers();
    std::vector<uint8_t> bare(texel.size(), 0);
    for (size_t t = 0; t < bare.size(); ++t) bare[t] = texel[t] < 0 && half_edges_.corner_point[3 * t] >= 0;
    std::queue<int32_t> queue;
    for (int32_t h = 0; h < 3 * triangles_.triangle_count; ++h) { // only what lies beside a bare one leads anywhere
      const int32_t twin = half_edges_.twin[static_cast<size_t>(h)];
      if (texel[static_cast<size_t>(h / 3)] < 0 || twin < 0 || !bare[static_cast<size_t>(twin / 3)]) continue;
      if (queue.empty() || queue.back() != h / 3) queue.push(h / 3);
    }
    Pairs pairs;
    while (!queue.empty()) {
      const int32_t t = queue.front();
      queue.pop();
      for (int i = 0; i < 3; ++i) {
        const int32_t twin = half_edges_.twin[static_cast<size_t>(3 * t + i)];
        if (twin < 0) continue;
        int64_t &other = texel[static_cast<size_t>(twin / 3)];
        if (other < 0) {
          other = texel[static_cast<size_t>(t)];
          pairs.push_back(pair_of(cell_of(other), twin / 3));
          queue.push(twin / 3);
        } else if (bare[static_cast<size_t>(t)] || bare[static_cast<size_t>(twin / 3)]) {
          link(texel[static_cast<size_t>(t)], other, crossings_);
        }
      }
    }
    to_lists(pairs, cells_.count, cells_.bare_begin, cells_.bare);
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
  Pairs boundaries_;
};

} // namespace

Cells build_cells(const std::vector<int32_t> &ids, const BorderGrid &grid, const Triangles &triangles,
                  const HalfEdges &half_edges, const Charts &charts, int block_size, int threads) {
  return Builder(ids, grid, triangles, half_edges, charts, block_size, threads).build();
}

std::vector<int32_t> find_cells(const Cells &cells, const std::vector<int32_t> &ids, const BorderGrid &grid,
                                const Triangles &triangles, const Charts &charts, const std::vector<LayoutPlace> &places,
                                int threads) {
  const ChartMap map(ids, grid, triangles);
  std::vector<int32_t> found(places.size());
  parallel_blocks(static_cast<int>(places.size()), threads, 1024, [&](int begin, int end) {
    for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
      const auto triangle = static_cast<size_t>(places[i].triangle);
      const dvec2 texel = dvec2(places[i].uv) * static_cast<double>(grid.size);
      const int64_t carrier = map.carrier(texel, charts.triangle_chart[triangle]);
      found[i] = carrier >= 0 ? cells.label[2 * static_cast<size_t>(carrier)] : cells.triangle_cell[triangle];
    }
  });
  return found;
}

} // namespace paradesc
