// Where creases may change curvature: told before triangles are looked through.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/creases/solid.h"

namespace paradesc {

class NearCreases {
public:
  NearCreases(const CreasedSurface &surface, double radius);
  bool reach(dvec3 position, int32_t triangle) const; // whether one of its component is near enough

private:
  struct Edge {
    uint64_t cell;
    int32_t edge;
    auto operator<=>(const Edge &) const = default;
  };

  void add_edge(int32_t edge);
  dvec3 cell_at(dvec3 position) const;

  CreasedSurface surface_;
  double radius_, cell_;
  dvec3 low_{0};
  std::vector<Edge> edges_; // in their order
};

} // namespace paradesc
