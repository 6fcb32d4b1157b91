// Finds places where creases may change curvature, before any triangles are visited.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/creases/face_rows.h"

namespace paradesc {

struct NearCrease {
  double distance;
  int32_t half_edge;
};

class NearCreases {
public:
  NearCreases(const CreasedSurface &surface, double radius);
  // Finds the creases of the triangle's component that are nearer than CREASE_REACH radii.
  void find(dvec3 position, int32_t triangle, std::vector<NearCrease> &found) const;

private:
  // The creases of one component, in the cells of their bounding box.
  struct Grid : Bounds<dvec3> {
    double cell = 0;
    size_t begin = 0, end = 0; // range in entries_
    dvec3 cell_at(dvec3 position) const { return glm::floor((glm::clamp(position, low, high) - low) / cell); }
  };

  void fill(Grid &grid, const std::vector<int32_t> &edges, size_t begin, size_t end);
  void add_edge(const Grid &grid, int32_t edge);

  CreasedSurface surface_;
  double radius_;
  std::vector<Grid> grids_;       // (components)
  std::vector<uint64_t> entries_; // cell and edge; those of each component are sorted
};

} // namespace paradesc
