// Builds the tree level by level: each cluster joins the neighbor with which the union is roundest, measured in edges.
#include "mesh/cluster_tree.h"

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "support/cancel.h"

namespace paradesc {

namespace {

// The clusters of one level: how many edges each shares with its neighbors, and how many its border has in all.
struct ClusterGraph {
  struct Link {
    int32_t other, edges;
  };
  std::vector<int32_t> begin{0}; // (clusters + 1) into link
  std::vector<Link> link;
  std::vector<int32_t> perimeter; // edges
  std::vector<int32_t> items;

  int32_t size() const { return static_cast<int32_t>(perimeter.size()); }
};

// Squared border length over that of a disk of as many items, up to a constant factor. The added term grows with size, so that
// small clusters are merged first.
double roughness(int32_t perimeter, int32_t items) {
  const double edges = perimeter, count = items;
  return edges * edges / count + 0.05 * count;
}

// Assigns the clusters of one level to parents, the clusters of the next level.
class Matching {
public:
  explicit Matching(const ClusterGraph &graph) : graph_(graph), parent_(graph.perimeter.size(), -1) {
    for (int32_t cluster = 0; cluster < graph.size(); ++cluster) {
      checkpoint_at(cluster);
      if (parent_[cluster] < 0 && !pair(cluster) && !join(cluster)) open(cluster);
    }
  }

  std::vector<int32_t> take_parents() { return std::move(parent_); }
  int32_t count() const { return static_cast<int32_t>(members_.size()); }
  const std::vector<int32_t> &items() const { return items_; }

private:
  int32_t open(int32_t cluster) {
    members_.push_back(1);
    perimeter_.push_back(graph_.perimeter[cluster]);
    items_.push_back(graph_.items[cluster]);
    return parent_[cluster] = count() - 1;
  }

  void add(int32_t cluster, int32_t group, int32_t edges) {
    parent_[cluster] = group;
    ++members_[group];
    perimeter_[group] += graph_.perimeter[cluster] - 2 * edges;
    items_[group] += graph_.items[cluster];
  }

  struct Size {
    int32_t perimeter, items;
  };

  // The link to the neighbor with which the union is roundest; other is -1 if there is none. size_of(link): the size of what lies
  // behind the link, or none if that cannot be joined.
  template <class SizeOf> ClusterGraph::Link roundest(int32_t cluster, const SizeOf &size_of) const {
    double least = std::numeric_limits<double>::max();
    ClusterGraph::Link best{-1, 0};
    for (int32_t k = graph_.begin[cluster]; k < graph_.begin[cluster + 1]; ++k) {
      const ClusterGraph::Link link = graph_.link[k];
      const std::optional<Size> size = size_of(link);
      if (!size) continue;
      const double rough =
          roughness(size->perimeter + graph_.perimeter[cluster] - 2 * link.edges, size->items + graph_.items[cluster]);
      if (rough >= least) continue;
      least = rough;
      best = link;
    }
    return best;
  }

  bool pair(int32_t cluster) {
    const ClusterGraph::Link best = roundest(cluster, [&](const ClusterGraph::Link &link) -> std::optional<Size> {
      if (parent_[link.other] >= 0) return {};
      return Size{graph_.perimeter[link.other], graph_.items[link.other]};
    });
    if (best.other >= 0) add(best.other, open(cluster), best.edges);
    return best.other >= 0;
  }

  // For a cluster whose neighbors all have groups: joins the group of one of them that still has room.
  bool join(int32_t cluster) {
    const ClusterGraph::Link best = roundest(cluster, [&](const ClusterGraph::Link &link) -> std::optional<Size> {
      const int32_t group = parent_[link.other];
      if (members_[group] >= static_cast<int>(ClusterTree::max_children)) return {};
      return Size{perimeter_[group], items_[group]};
    });
    if (best.other >= 0) add(cluster, parent_[best.other], best.edges);
    return best.other >= 0;
  }

  const ClusterGraph &graph_;
  std::vector<int32_t> parent_;
  std::vector<int32_t> members_, perimeter_, items_; // of each group
};

// The members of each parent, listed parent after parent.
struct Members {
  std::vector<int32_t> begin, member;
  Members(const std::vector<int32_t> &parent, int32_t parents)
      : begin(static_cast<size_t>(parents) + 1, 0), member(parent.size()) {
    for (const int32_t p : parent) ++begin[p + 1];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<int32_t> next(begin.begin(), begin.end() - 1);
    for (size_t i = 0; i < parent.size(); ++i) {
      checkpoint_at(i);
      member[next[parent[i]]++] = static_cast<int32_t>(i);
    }
  }
};

} // namespace

static ClusterGraph coarsen(const ClusterGraph &graph, const std::vector<int32_t> &parent, const Matching &matching) {
  const Members members(parent, matching.count());
  ClusterGraph coarse;
  coarse.items = matching.items();
  coarse.link.reserve(graph.link.size() / 2);
  std::vector<size_t> at(static_cast<size_t>(matching.count()), 0); // where the link to another group is, if it is this group's
  for (int32_t group = 0; group < matching.count(); ++group) {
    checkpoint_at(group);
    const size_t first = coarse.link.size();
    int32_t perimeter = 0;
    for (int32_t m = members.begin[group]; m < members.begin[group + 1]; ++m) {
      const int32_t member = members.member[m];
      perimeter += graph.perimeter[member];
      for (int32_t k = graph.begin[member]; k < graph.begin[member + 1]; ++k) {
        const ClusterGraph::Link link = graph.link[k];
        const int32_t other = parent[link.other];
        if (other == group) {
          perimeter -= link.edges;
        } else if (at[other] >= first && at[other] < coarse.link.size() && coarse.link[at[other]].other == other) {
          coarse.link[at[other]].edges += link.edges;
        } else {
          at[other] = coarse.link.size();
          coarse.link.push_back({other, link.edges});
        }
      }
    }
    coarse.perimeter.push_back(perimeter);
    coarse.begin.push_back(static_cast<int32_t>(coarse.link.size()));
  }
  return coarse;
}

// Orders the clusters of each level from the top down, so that each cluster is a range of every level below.
static void put_in_order(const std::vector<std::vector<int32_t>> &parents, const std::vector<int32_t> &sizes, ClusterTree &tree) {
  std::vector<int32_t> order(static_cast<size_t>(sizes.back()));
  std::iota(order.begin(), order.end(), 0);
  tree.child_begin.resize(parents.size());
  for (size_t level = parents.size(); level-- > 0;) {
    const Members members(parents[level], sizes[level + 1]);
    std::vector<int32_t> below, &begin = tree.child_begin[level];
    below.reserve(parents[level].size());
    begin.assign(1, 0);
    for (const int32_t cluster : order) {
      checkpoint_at(begin.size());
      below.insert(below.end(), members.member.begin() + members.begin[cluster],
                   members.member.begin() + members.begin[cluster + 1]);
      begin.push_back(static_cast<int32_t>(below.size()));
    }
    order.swap(below);
  }
  std::vector<int32_t> items;
  items.reserve(order.size());
  checkpoint();
  for (const int32_t i : order) items.push_back(tree.item[i]);
  checkpoint();
  tree.item.swap(items);
}

// tree: its items, and their places.
static void build_levels(ClusterGraph graph, ClusterTree &tree) {
  constexpr double least_gain = 0.95; // a level with hardly fewer clusters is the last: the rest are separate components
  std::vector<std::vector<int32_t>> parents;
  std::vector<int32_t> sizes{graph.size()};
  while (graph.size() > 1) {
    Matching matching(graph);
    if (matching.count() > least_gain * graph.size()) break;
    parents.push_back(matching.take_parents());
    sizes.push_back(matching.count());
    graph = coarsen(graph, parents.back(), matching);
  }
  put_in_order(parents, sizes, tree);
  for (size_t i = 0; i < tree.item.size(); ++i) tree.rank[tree.item[i]] = static_cast<int32_t>(i);
}

// A point's faces are one fan: turning around it meets its neighbors one after the other.
PointNeighbors find_point_neighbors(const HalfEdges &half_edges) {
  PointNeighbors found;
  found.begin.reserve(static_cast<size_t>(half_edges.point_count) + 1);
  for (int32_t point = 0; point < half_edges.point_count; ++point) {
    checkpoint_at(static_cast<size_t>(point));
    const auto meet = [&](int32_t corner) {
      if (half_edges.corner_point[corner] != point) found.neighbor.push_back(half_edges.corner_point[corner]);
    };
    for_each_corner_around(half_edges, point, [&](int32_t corner) {
      meet(next_corner(corner));
      if (const int32_t previous = previous_corner(corner); half_edges.twin[previous] < 0) meet(previous);
    });
    found.begin.push_back(static_cast<int32_t>(found.neighbor.size()));
  }
  return found;
}

// Returns whether neighbors are about as near each other in this order of a component's points as in the rows of a square grid.
// place: of each point in the order.
static bool follow_each_other(const PointNeighbors &neighbors, std::span<const int32_t> points,
                              const std::vector<int32_t> &place) {
  double gaps = 0, links = 0;
  for (const int32_t point : points) {
    for (int32_t k = neighbors.begin[point]; k < neighbors.begin[point + 1]; ++k)
      gaps += std::abs(place[neighbors.neighbor[k]] - place[point]);
    links += neighbors.begin[point + 1] - neighbors.begin[point];
  }
  return gaps * gaps <= static_cast<double>(points.size()) * links * links;
}

// The points component by component, each from its first point outwards.
struct Components {
  std::vector<int32_t> point, begin{0};
  std::vector<int32_t> of_point;

  explicit Components(const PointNeighbors &neighbors) : of_point(neighbors.begin.size() - 1, -1) {
    point.reserve(of_point.size());
    for (size_t first = 0; first < of_point.size(); ++first) {
      if (of_point[first] >= 0) continue;
      const auto component = static_cast<int32_t>(begin.size()) - 1;
      const auto list = [&](int32_t other) {
        if (std::exchange(of_point[other], component) < 0) point.push_back(other);
      };
      list(static_cast<int32_t>(first));
      for (auto next = static_cast<size_t>(begin.back()); next < point.size(); ++next) {
        checkpoint_at(next);
        for (int32_t k = neighbors.begin[point[next]]; k < neighbors.begin[point[next] + 1]; ++k) list(neighbors.neighbor[k]);
      }
      begin.push_back(static_cast<int32_t>(point.size()));
    }
  }
};

// Returns an order in which neighbors follow each other: for each component that of the input, or outwards. The rows of a grid
// follow each other, and the points that a subdivision appended do not.
static std::vector<int32_t> order_for_pairs(const PointNeighbors &neighbors) {
  Components components(neighbors);
  std::vector<int32_t> input(components.point.size()), place(input.size()), next = components.begin;
  for (size_t point = 0; point < place.size(); ++point) {
    checkpoint_at(point);
    place[point] = next[components.of_point[point]]++;
    input[place[point]] = static_cast<int32_t>(point);
  }
  for (size_t i = 0; i + 1 < components.begin.size(); ++i) {
    checkpoint_at(i);
    const int32_t begin = components.begin[i], count = components.begin[i + 1] - begin;
    if (follow_each_other(neighbors, std::span(input).subspan(begin, count), place))
      std::copy_n(input.begin() + begin, count, components.point.begin() + begin);
  }
  return std::move(components.point);
}

ClusterTree build_point_tree(const PointNeighbors &neighbors) {
  ClusterTree tree;
  tree.item = order_for_pairs(neighbors);
  tree.rank.resize(tree.item.size());
  for (size_t i = 0; i < tree.item.size(); ++i) tree.rank[tree.item[i]] = static_cast<int32_t>(i);
  ClusterGraph graph;
  graph.link.reserve(neighbors.neighbor.size());
  for (const int32_t point : tree.item) {
    checkpoint_at(graph.perimeter.size());
    for (int32_t k = neighbors.begin[point]; k < neighbors.begin[point + 1]; ++k)
      graph.link.push_back({tree.rank[neighbors.neighbor[k]], 1});
    graph.perimeter.push_back(neighbors.begin[point + 1] - neighbors.begin[point]);
    graph.begin.push_back(static_cast<int32_t>(graph.link.size()));
  }
  graph.items.assign(graph.perimeter.size(), 1);
  build_levels(std::move(graph), tree);
  return tree;
}

} // namespace paradesc
