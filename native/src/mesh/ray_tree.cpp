// Boxes are halved at the median of the triangles' middles along their longest axis, level by level, the boxes of a level on all
// cores. All decisions are made in doubles, and a hit depends on the triangles alone: the tree only skips what lies too far
// away.
#include "mesh/ray_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "support/parallel.h"

namespace paradesc {

namespace {

constexpr int leaf_triangles = 4;
constexpr int deepest = 64; // of the tree; it has at most 31 levels
// Rays and triangles are known to a few roundings of their coordinates; boxes are enlarged by this share of them.
constexpr double rounding = 1e-13;
constexpr double infinite = std::numeric_limits<double>::infinity();

// The z coordinate of the cross product: twice the signed area in the first two coordinates.
double cross(const dvec3 &a, const dvec3 &b) { return a.x * b.y - a.y * b.x; }

double largest(const dvec3 &a) { return std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z)}); }

} // namespace

bool is_nearer(const RayHit &a, const RayHit &b) {
  if (a.triangle < 0 || b.triangle < 0) return a.triangle >= 0 && b.triangle < 0;
  return std::tuple(std::abs(a.distance), a.distance < 0, a.triangle) <
         std::tuple(std::abs(b.distance), b.distance < 0, b.triangle);
}

Ray::Ray(dvec3 point, dvec3 direction) : point_(point) {
  direction /= largest(direction); // otherwise its square might overflow
  direction = glm::normalize(direction);
  for (int axis = 0; axis < 3; ++axis) {
    const double along = direction[axis];
    inverse_[axis] = std::abs(along) > 1e-300 ? 1 / along : std::copysign(1e300, along);
  }
  z_ = 0;
  for (int axis = 1; axis < 3; ++axis)
    if (std::abs(direction[axis]) > std::abs(direction[z_])) z_ = axis;
  x_ = (z_ + 1) % 3;
  y_ = (x_ + 1) % 3;
  if (direction[z_] < 0) std::swap(x_, y_); // keeps the winding
  shear_x_ = direction[x_] / direction[z_];
  shear_y_ = direction[y_] / direction[z_];
  scale_ = 1 / direction[z_];
}

dvec3 Ray::sheared(dvec3 position) const {
  const dvec3 from = position - point_;
  return {from[x_] - shear_x_ * from[z_], from[y_] - shear_y_ * from[z_], scale_ * from[z_]};
}

RayHit Ray::meet(int32_t triangle, dvec3 a, dvec3 b, dvec3 c) const {
  const dvec3 from[3] = {sheared(a), sheared(b), sheared(c)};
  const double parts[3] = {cross(from[1], from[2]), cross(from[2], from[0]), cross(from[0], from[1])};
  const double whole = parts[0] + parts[1] + parts[2];
  if (!(parts[0] >= 0 && parts[1] >= 0 && parts[2] >= 0 && whole > 0)) return {};
  RayHit hit{triangle, 0, {}};
  for (int i = 0; i < 3; ++i) {
    hit.weights[i] = parts[i] / whole;
    hit.distance += hit.weights[i] * from[i].z;
  }
  return hit;
}

RayTree::RayTree(std::span<const float> positions, std::span<const int32_t> triangle_vertices, int threads)
    : positions_(positions), vertices_(triangle_vertices) {
  const auto count = static_cast<int32_t>(triangle_vertices.size() / 3);
  for (int32_t triangle = 0; triangle < count; ++triangle)
    if (has_place(triangle)) order_.push_back(triangle);
  if (order_.empty()) return;
  nodes_.push_back({{}, {}, 0, static_cast<int32_t>(order_.size())});
  std::vector<vec3> middles(static_cast<size_t>(count));
  parallel_blocks(static_cast<int>(order_.size()), threads, 4096, [&](int begin, int end) {
    for (int i = begin; i < end; ++i)
      for (int corner = 0; corner < 3; ++corner) middles[order_[i]] += vec3(position(order_[i], corner) / 3.0);
  });
  for (size_t level = 0; level < nodes_.size();) level = divide(level, middles, threads);
  corners_.resize(order_.size());
  for (size_t i = 0; i < order_.size(); ++i)
    for (int corner = 0; corner < 3; ++corner) corners_[i][static_cast<size_t>(corner)] = vec3(position(order_[i], corner));
  for (int axis = 0; axis < 3; ++axis)
    largest_ = std::max(
        {largest_, std::abs(static_cast<double>(nodes_[0].low[axis])), std::abs(static_cast<double>(nodes_[0].high[axis]))});
}

dvec3 RayTree::position(int32_t triangle, int corner) const {
  const float *at = positions_.data() + size_t{3} * static_cast<size_t>(vertices_[size_t{3} * triangle + corner]);
  return {at[0], at[1], at[2]};
}

bool RayTree::has_place(int32_t triangle) const {
  for (int corner = 0; corner < 3; ++corner)
    if (!std::isfinite(largest(position(triangle, corner)))) return false;
  return true;
}

void RayTree::bound(Node &node) const {
  node.low.fill(std::numeric_limits<float>::max());
  node.high.fill(-std::numeric_limits<float>::max());
  for (int32_t i = node.first; i < node.first + node.count; ++i)
    for (int corner = 0; corner < 3; ++corner) {
      const dvec3 at = position(order_[i], corner);
      for (int axis = 0; axis < 3; ++axis) {
        node.low[axis] = std::min(node.low[axis], static_cast<float>(at[axis]));
        node.high[axis] = std::max(node.high[axis], static_cast<float>(at[axis]));
      }
    }
}

// Partitions a node's triangles at the median along its longest axis, the lower half first.
void RayTree::split(const Node &node, const std::vector<vec3> &middles) {
  int axis = 0;
  for (int other = 1; other < 3; ++other)
    if (node.high[other] - node.low[other] > node.high[axis] - node.low[axis]) axis = other;
  const auto first = order_.begin() + node.first;
  std::nth_element(first, first + node.count / 2, first + node.count,
                   [&](int32_t a, int32_t b) { return std::pair(middles[a][axis], a) < std::pair(middles[b][axis], b); });
}

size_t RayTree::divide(size_t level, const std::vector<vec3> &middles, int threads) {
  const size_t end = nodes_.size();
  const auto count = static_cast<int>(end - level);
  parallel_blocks(count, threads, 1 + count / 64, [&](int begin_node, int end_node) {
    for (int i = begin_node; i < end_node; ++i) {
      Node &node = nodes_[level + static_cast<size_t>(i)];
      bound(node);
      if (node.count > leaf_triangles) split(node, middles);
    }
  });
  for (size_t i = level; i < end; ++i) {
    const Node node = nodes_[i];
    if (node.count <= leaf_triangles) continue;
    nodes_[i].first = static_cast<int32_t>(nodes_.size());
    nodes_[i].count = 0;
    nodes_.push_back({{}, {}, node.first, node.count / 2});
    nodes_.push_back({{}, {}, node.first + node.count / 2, node.count - node.count / 2});
  }
  return end;
}

void RayTree::meet_all(const Node &node, const Ray &ray, double reach, RayHit &best) const {
  for (int32_t i = node.first; i < node.first + node.count; ++i) {
    const auto &[a, b, c] = corners_[i];
    const RayHit hit = ray.meet(order_[i], a, b, c);
    if (std::abs(hit.distance) <= reach && is_nearer(hit, best)) best = hit;
  }
}

RayHit RayTree::nearest(const Ray &ray, double reach) const {
  RayHit best;
  if (nodes_.empty()) return best;
  const double slack = rounding * std::max(largest(ray.point()), largest_);
  // The distance along the ray from its point to where it enters a box, if it does.
  const dvec3 below = ray.point() + slack, above = ray.point() - slack;
  const auto nearest_in_box = [&](const Node &node) {
    double begin = -infinite, end = infinite;
    for (int axis = 0; axis < 3; ++axis) {
      const double low = (static_cast<double>(node.low[axis]) - below[axis]) * ray.inverse()[axis];
      const double high = (static_cast<double>(node.high[axis]) - above[axis]) * ray.inverse()[axis];
      begin = std::max(begin, std::min(low, high));
      end = std::min(end, std::max(low, high));
    }
    return begin > end ? infinite : std::max({begin, -end, 0.0});
  };
  struct Waiting {
    int32_t node;
    double distance;
  } waiting[deepest];
  int count = 0;
  const auto limit = [&] { return (best.triangle < 0 ? reach : std::abs(best.distance)) + slack; };
  const auto add = [&](int32_t node, double distance) {
    if (distance <= limit()) waiting[count++] = {node, distance};
  };
  add(0, nearest_in_box(nodes_[0]));
  while (count > 0) {
    const Waiting next = waiting[--count];
    if (next.distance > limit()) continue;
    const Node &node = nodes_[next.node];
    if (node.count > 0) {
      meet_all(node, ray, reach, best);
      continue;
    }
    const double one = nearest_in_box(nodes_[node.first]), other = nearest_in_box(nodes_[node.first + 1]);
    const int32_t nearer = one <= other ? 0 : 1; // pushed last, so that it is visited first
    add(node.first + 1 - nearer, std::max(one, other));
    add(node.first + nearer, std::min(one, other));
  }
  return best;
}

} // namespace paradesc
