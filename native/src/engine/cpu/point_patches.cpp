// Cuts the tree of points into small clusters, and then collects triangles and the adjacency of nodes and patches.
#include "engine/cpu/point_patches.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "engine/cpu/ball_sums.h"
#include "support/cancel.h"
#include "support/parallel.h"

namespace paradesc {

PointOrder order_points(const HalfEdges &half_edges) {
  PointOrder order;
  order.neighbors = find_point_neighbors(half_edges);
  order.tree = build_point_tree(order.neighbors);
  order.begin.resize(order.tree.levels());
  order.begin[0].resize(order.tree.size(0) + 1);
  std::iota(order.begin[0].begin(), order.begin[0].end(), 0);
  for (size_t level = 1; level < order.tree.levels(); ++level) {
    checkpoint();
    for (const int32_t child : order.tree.child_begin[level - 1]) order.begin[level].push_back(order.begin[level - 1][child]);
  }
  order.group_begin = group_points(order, group_lanes);
  return order;
}

// Returns where the largest clusters of at most `most` items begin, in the order of the tree, and the end. count(begin, end): the
// items among these points.
template <class Count> static std::vector<int32_t> cut_tree(const PointOrder &order, int32_t most, const Count &count) {
  std::vector<int32_t> begins;
  const auto cut = [&](const auto &self, size_t level, int32_t cluster) -> void {
    const int32_t begin = order.begin[level][cluster], end = order.begin[level][cluster + 1];
    if (level == 0 || count(begin, end) <= most) return begins.push_back(begin);
    const std::vector<int32_t> &children = order.tree.child_begin[level - 1];
    for (int32_t child = children[cluster]; child < children[cluster + 1]; ++child) self(self, level - 1, child);
  };
  const size_t top = order.tree.levels() - 1;
  for (size_t cluster = 0; cluster < order.tree.size(top); ++cluster) {
    checkpoint_at(cluster);
    cut(cut, top, static_cast<int32_t>(cluster));
  }
  begins.push_back(order.points());
  return begins;
}

std::vector<int32_t> group_points(const PointOrder &order, int32_t most) {
  return cut_tree(order, most, [](int32_t begin, int32_t end) { return end - begin; });
}

namespace {

constexpr int items_of_block = 4096;

// The entries that several items have, and where those of each item begin.
struct Lists {
  std::vector<int32_t> begin, entry;
};

// append(i, entries) appends those of item i.
template <class Append> Lists list_entries(int32_t count, int threads, const Append &append) {
  const Blocks blocks{count, items_of_block};
  std::vector<Lists> parts(static_cast<size_t>(blocks.number()));
  parallel_blocks(blocks.number(), threads, 1, [&](int block, int) {
    Lists &part = parts[block];
    for (int32_t i = blocks.begin(block); i < blocks.end(block); ++i) {
      part.begin.push_back(static_cast<int32_t>(part.entry.size()));
      append(i, part.entry);
    }
  });
  Lists all;
  for (const Lists &part : parts) {
    const auto before = static_cast<int32_t>(all.entry.size());
    for (const int32_t begin : part.begin) all.begin.push_back(before + begin);
    all.entry.insert(all.entry.end(), part.entry.begin(), part.entry.end());
  }
  all.begin.push_back(static_cast<int32_t>(all.entry.size()));
  return all;
}

void sort_once_each(std::vector<int32_t> &items) {
  std::sort(items.begin(), items.end());
  items.erase(std::unique(items.begin(), items.end()), items.end());
}

class Builder {
public:
  Builder(const PointOrder &order, const HalfEdges &half_edges, const std::vector<int32_t> &node_begin, int threads)
      : order_(order), half_edges_(half_edges), node_begin_(node_begin), threads_(threads) {}

  PointPatches run() {
    place_nodes();
    place_triangles();
    place_corners();
    place_rims();
    place_neighbors();
    link_patches();
    return std::move(to_);
  }

private:
  bool is_cluster(int32_t node) const { return to_.node[node] < 0; }

  void place_nodes() {
    const auto nodes = static_cast<int32_t>(node_begin_.size()) - 1;
    std::vector<int32_t> node_of(order_.tree.item.size()); // in the order of the tree
    for (int32_t i = 0; i < nodes; ++i) {
      checkpoint_at(static_cast<size_t>(i));
      std::fill(node_of.begin() + node_begin_[i], node_of.begin() + node_begin_[i + 1], i);
      const bool is_point = node_begin_[i + 1] - node_begin_[i] == 1;
      to_.node.push_back(is_point ? order_.tree.item[node_begin_[i]] : ~to_.clusters());
      if (!is_point) to_.cluster_node.push_back(i);
    }
    const auto count = [&](int32_t begin, int32_t end) { return node_of[end - 1] - node_of[begin] + 1; };
    for (const int32_t begin : cut_tree(order_, PointPatches::most_nodes, count))
      to_.patch_begin.push_back(begin < order_.points() ? node_of[begin] : nodes);
    for (int32_t p = 0; p < to_.patches(); ++p)
      to_.patch_of.insert(to_.patch_of.end(), static_cast<size_t>(to_.patch_begin[p + 1] - to_.patch_begin[p]), p);
    for (int32_t p = 0; p < to_.patches(); ++p) {
      const int32_t point = order_.tree.item[node_begin_[to_.patch_begin[p]]];
      to_.piece.push_back(half_edges_.triangle_piece[half_edges_.point_half_edge[point] / 3]);
    }
    to_.node_of_point.resize(order_.tree.rank.size());
    for (size_t i = 0; i < to_.node_of_point.size(); ++i) to_.node_of_point[i] = node_of[order_.tree.rank[i]];
    to_.cluster_begin.assign(1, 0);
    for (int32_t p = 0, next = 0; p < to_.patches(); ++p) {
      while (next < to_.clusters() && to_.cluster_node[next] < to_.patch_begin[p + 1]) ++next;
      to_.cluster_begin.push_back(next);
    }
  }

  // Returns the node that a triangle belongs to: of its corners that are clusters, or of all if there is none, the middle one.
  int32_t owner_of(int32_t triangle) const {
    std::array<int32_t, 3> nodes;
    for (int32_t k = 0; k < 3; ++k) nodes[k] = to_.node_of_point[half_edges_.corner_point[3 * triangle + k]];
    std::ranges::sort(nodes);
    for (const size_t k : {size_t{1}, size_t{0}, size_t{2}})
      if (is_cluster(nodes[k])) return nodes[k];
    return nodes[1];
  }

  // Lists the triangles of each patch and of each cluster in the order of the mesh.
  void place_triangles() {
    const size_t count = half_edges_.corner_point.size() / 3;
    to_.node_of_triangle.assign(count, -1);
    to_.place.assign(count, -1);
    to_.triangle_begin.assign(static_cast<size_t>(to_.patches()) + 1, 0);
    to_.member_begin.assign(static_cast<size_t>(to_.clusters()) + 1, 0);
    const auto for_each = [&](const auto &use) {
      for (size_t t = 0; t < count; ++t) {
        checkpoint_at(t);
        if (const int32_t node = to_.node_of_triangle[t]; node >= 0) use(static_cast<int32_t>(t), node);
      }
    };
    parallel_blocks(static_cast<int>(count), threads_, items_of_block, [&](int begin, int end) {
      for (int32_t t = begin; t < end; ++t)
        if (half_edges_.corner_point[3 * t] >= 0) to_.node_of_triangle[t] = owner_of(t);
    });
    for_each([&](int32_t, int32_t node) {
      ++(is_cluster(node) ? to_.member_begin[~to_.node[node] + 1] : to_.triangle_begin[to_.patch_of[node] + 1]);
    });
    for (std::vector<int32_t> *begin : {&to_.triangle_begin, &to_.member_begin})
      std::partial_sum(begin->begin(), begin->end(), begin->begin());
    to_.triangle.resize(static_cast<size_t>(to_.triangle_begin.back()));
    to_.member.resize(static_cast<size_t>(to_.member_begin.back()));
    std::vector<int32_t> next(to_.triangle_begin.begin(), to_.triangle_begin.end() - 1),
        next_member(to_.member_begin.begin(), to_.member_begin.end() - 1);
    for_each([&](int32_t t, int32_t node) {
      if (is_cluster(node)) {
        to_.member[next_member[~to_.node[node]]++] = t;
        return;
      }
      to_.place[t] = next[to_.patch_of[node]]++;
      to_.triangle[to_.place[t]] = t;
    });
  }

  void place_corners() {
    constexpr int32_t boundary = -1, into_cluster = -2;
    to_.corner.resize(3 * (to_.triangle.size() + group_lanes), 0);
    to_.twin.resize(3 * to_.triangle.size());
    parallel_blocks(static_cast<int>(to_.triangle.size()), threads_, items_of_block, [&](int begin, int end) {
      for (int32_t i = begin; i < end; ++i)
        for (int32_t k = 0; k < 3; ++k) {
          const int32_t half_edge = 3 * to_.triangle[i] + k, twin = half_edges_.twin[half_edge],
                        behind = twin < 0 ? -1 : to_.place[twin / 3];
          to_.corner[3 * i + k] = to_.node_of_point[half_edges_.corner_point[half_edge]];
          to_.twin[3 * i + k] = twin < 0 ? boundary : behind < 0 ? into_cluster : 3 * behind + twin % 3;
        }
    });
  }

  void place_rims() {
    Lists rims = list_entries(to_.clusters(), threads_, [&](int32_t cluster, std::vector<int32_t> &rim) {
      for (int32_t i = to_.member_begin[cluster]; i < to_.member_begin[cluster + 1]; ++i)
        for (int32_t half_edge = 3 * to_.member[i]; half_edge < 3 * to_.member[i] + 3; ++half_edge)
          if (half_edges_.twin[half_edge] < 0) rim.push_back(half_edge);
    });
    to_.rim_begin = std::move(rims.begin);
    to_.rim = std::move(rims.entry);
  }

  void place_neighbors() {
    constexpr auto room = static_cast<size_t>(PointPatches::near_neighbors);
    to_.neighbor.assign(room * static_cast<size_t>(to_.nodes()), to_.nodes());
    Lists more = list_entries(to_.nodes(), threads_, [&](int32_t i, std::vector<int32_t> &more_of_part) {
      std::vector<int32_t> others;
      for (int32_t p = node_begin_[i]; p < node_begin_[i + 1]; ++p)
        for (int32_t k = order_.neighbors.begin[order_.tree.item[p]]; k < order_.neighbors.begin[order_.tree.item[p] + 1]; ++k)
          if (const int32_t other = to_.node_of_point[order_.neighbors.neighbor[k]]; other != i) others.push_back(other);
      sort_once_each(others);
      const size_t near = std::min(others.size(), room);
      std::copy_n(others.begin(), near, to_.neighbor.begin() + static_cast<ptrdiff_t>(room) * i);
      more_of_part.insert(more_of_part.end(), others.begin() + static_cast<ptrdiff_t>(near), others.end());
    });
    to_.more_begin = std::move(more.begin);
    to_.more = std::move(more.entry);
  }

  void link_patches() {
    Lists links = list_entries(to_.patches(), threads_, [&](int32_t patch, std::vector<int32_t> &link) {
      std::vector<int32_t> others;
      const auto link_to = [&](int32_t node) {
        if (node < to_.nodes() && to_.patch_of[node] != patch) others.push_back(to_.patch_of[node]);
      };
      for (int32_t i = to_.patch_begin[patch]; i < to_.patch_begin[patch + 1]; ++i) {
        for (int32_t k = 0; k < PointPatches::near_neighbors; ++k) link_to(to_.neighbor[PointPatches::near_neighbors * i + k]);
        for (int32_t k = to_.more_begin[i]; k < to_.more_begin[i + 1]; ++k) link_to(to_.more[k]);
      }
      sort_once_each(others);
      link.insert(link.end(), others.begin(), others.end());
    });
    to_.link_begin = std::move(links.begin);
    to_.link = std::move(links.entry);
    Lists edges = list_entries(to_.patches(), threads_, [&](int32_t patch, std::vector<int32_t> &edge) {
      for (int32_t corner = 3 * to_.triangle_begin[patch]; corner < 3 * to_.triangle_begin[patch + 1]; ++corner)
        if (to_.twin[corner] == -1) edge.push_back(corner);
    });
    to_.edge_begin = std::move(edges.begin);
    to_.edge = std::move(edges.entry);
  }

  const PointOrder &order_;
  const HalfEdges &half_edges_;
  const std::vector<int32_t> &node_begin_;
  int threads_;
  PointPatches to_;
};

} // namespace

PointPatches build_point_patches(const PointOrder &order, const HalfEdges &half_edges, const std::vector<int32_t> &node_begin,
                                 int threads) {
  return Builder(order, half_edges, node_begin, threads).run();
}

} // namespace paradesc
