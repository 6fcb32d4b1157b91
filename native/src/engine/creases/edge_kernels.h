// Edges around a center → the kernel of H along them, once for both triangles of each.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "support/math.h"

namespace paradesc {

// The part of an edge within the ball.
struct KernelNode {
  double place2; // along the edge from where its line is nearest to the center, squared
  double weight;
  double up_to; // the kernel times the distance, added up to the edge
};
struct EdgeKernel {
  double along = 0; // its integral
  int32_t begin = 0, end = 0;
};

// What one thread keeps from center to center.
class EdgeKernels {
public:
  explicit EdgeKernels(double radius) : radius_(radius), slots_(1 << 8) {}

  void start(); // at another center
  // From the center; an edge goes by the smaller of its half-edges.
  EdgeKernel at(int32_t half_edge, int32_t twin, dvec3 begin, dvec3 end);
  // What belongs to the edge of the kernel's integral over a face at this height. across: of the face's plane, from the foot of
  // the center to the edge's line, positive where the foot is to the left.
  double over(const EdgeKernel &edge, double height, double across) const;

private:
  struct Slot {
    int32_t center = 0; // the last that took it
    int32_t half_edge = 0;
    EdgeKernel kernel;
  };

  Slot &slot_of(int32_t half_edge); // its own, or a free one
  void grow();
  void add_nodes(EdgeKernel &kernel, dvec3 begin, dvec3 end);

  double radius_;
  int32_t centers_ = 0;
  std::vector<Slot> slots_; // by hashes, a power of two of them: at most half are taken
  size_t taken_ = 0;
  std::vector<KernelNode> nodes_;
};

} // namespace paradesc
