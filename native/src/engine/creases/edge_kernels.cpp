// Logarithms dominate the cost of kernels, so each is computed once.
#include "engine/creases/edge_kernels.h"

#include <algorithm>
#include <cmath>

#include "engine/creases/closed_forms.h"

namespace paradesc {

void EdgeKernels::start() {
  ++centers_;
  taken_ = 0;
  nodes_.clear();
}

EdgeKernel EdgeKernels::at(int32_t half_edge, int32_t twin, dvec3 begin, dvec3 end) {
  const int32_t edge = twin < 0 ? half_edge : std::min(half_edge, twin);
  if (2 * taken_ > slots_.size()) grow();
  Slot &slot = slot_of(edge);
  if (slot.center == centers_) return slot.kernel;
  ++taken_;
  slot = {centers_, edge, {0, static_cast<int32_t>(nodes_.size()), 0}};
  add_nodes(slot.kernel, begin, end);
  slot.kernel.end = static_cast<int32_t>(nodes_.size());
  return slot.kernel;
}

EdgeKernels::Slot &EdgeKernels::slot_of(int32_t half_edge) {
  constexpr uint32_t golden = 2654435769u; // golden section of 2^32, which spreads neighboring numbers
  const size_t last = slots_.size() - 1;
  size_t i = (static_cast<uint32_t>(half_edge) * golden >> 8) & last;
  while (slots_[i].center == centers_ && slots_[i].half_edge != half_edge) i = (i + 1) & last;
  return slots_[i];
}

void EdgeKernels::grow() {
  std::vector<Slot> before(2 * slots_.size());
  before.swap(slots_);
  for (const Slot &slot : before)
    if (slot.center == centers_) slot_of(slot.half_edge) = slot;
}

void EdgeKernels::add_nodes(EdgeKernel &kernel, dvec3 begin, dvec3 end) {
  const dvec3 edge = end - begin;
  const double length = glm::length(edge);
  if (!(length > 0)) return;
  const double from = glm::dot(begin, edge) / length, square = radius_ * radius_;
  const double nearest2 = std::max(glm::dot(begin, begin) - from * from, 0.0), half2 = square - nearest2;
  if (!(half2 > 0)) return;
  const double half = std::sqrt(half2), low = std::max(from, -half), high = std::min(from + length, half);
  if (!(low < high)) return;
  const double nearest = std::sqrt(nearest2), least = least_distance * radius_;
  visit_steps(low, high, std::max(nearest, least), [&](double s, double t) {
    const GaussRule rule = step_rule(s, t, nearest2);
    for (size_t i = 0; i < rule.nodes.size(); ++i) {
      const double place = s + rule.nodes[i] * (t - s), weight = rule.weights[i] * std::abs(t - s);
      const KernelValues values = kernel_values(nearest2 + place * place, radius_);
      kernel.along += weight * values.at;
      nodes_.push_back({place * place, weight, values.up_to});
    }
  });
  if (nearest < least) kernel.along = kernel_on_segment(begin, end, radius_);
}

double EdgeKernels::over(const EdgeKernel &edge, double height, double across) const {
  const double low = kernel_values(height * height, radius_).up_to, across2 = across * across;
  double sum = 0;
  for (int32_t i = edge.begin; i < edge.end; ++i) {
    const KernelNode &node = nodes_[i];
    const double square = across2 + node.place2;
    if (square > 0) sum += node.weight * (node.up_to - low) / square;
  }
  return across * sum;
}

} // namespace paradesc
