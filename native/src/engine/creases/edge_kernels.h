// Edges around a center → integrals of the kernel of H along them, once for both triangles of an edge.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "support/math.h"

namespace paradesc {

// A quadrature node on the part of an edge within the ball.
struct KernelNode {
  double place2; // squared place along the edge's line, from the point nearest to the center
  double weight;
  double up_to; // integral of kernel times distance, up to the edge
};
struct EdgeKernel {
  double along = 0; // its integral
  int32_t begin = 0, end = 0;
};

// Reused by one thread from center to center, so that arrays stay allocated.
class EdgeKernels {
public:
  explicit EdgeKernels(double radius) : radius_(radius), slots_(1 << 8) {}

  void start(); // begins with another center
  // begin, end: relative to the center. An edge is identified by the smaller of its half-edges.
  EdgeKernel at(int32_t half_edge, int32_t twin, dvec3 begin, dvec3 end);
  // Returns the edge's contribution to the kernel's integral over a face at this height. across: distance in the face's plane
  // from the foot of the center to the edge's line, positive if the foot is to the left.
  double over(const EdgeKernel &edge, double height, double across) const;

private:
  struct Slot {
    int32_t center = 0; // the last center that used the slot
    int32_t half_edge = 0;
    EdgeKernel kernel;
  };

  Slot &slot_of(int32_t half_edge); // the edge's own slot, or a free one
  void grow();
  void add_nodes(EdgeKernel &kernel, dvec3 begin, dvec3 end);

  double radius_;
  int32_t centers_ = 0;
  std::vector<Slot> slots_; // a hash table: a power of two, at most half full
  size_t taken_ = 0;
  std::vector<KernelNode> nodes_;
};

} // namespace paradesc
