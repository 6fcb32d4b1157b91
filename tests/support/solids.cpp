// Points and polygons, polygons as fans of triangles.
#include "support/solids.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

namespace paradesc::test {

namespace {

class Builder {
public:
  // One vertex at each place.
  int32_t vertex(dvec3 p) {
    const auto rounded = [](double x) { return std::lround(x * 1e6); };
    const auto [found, added] =
        vertices_.try_emplace({rounded(p.x), rounded(p.y), rounded(p.z)}, static_cast<int32_t>(vertices_.size()));
    if (added) triangles_.positions.emplace_back(p);
    return found->second;
  }

  // Convex, around the origin's far side: turned so that it looks away from the origin.
  void polygon(const std::vector<dvec3> &corners) {
    const bool outward = glm::dot(glm::cross(corners[1] - corners[0], corners[2] - corners[0]), corners[0]) > 0;
    for (size_t i = 1; i + 1 < corners.size(); ++i) {
      const dvec3 second = corners[outward ? i : i + 1], third = corners[outward ? i + 1 : i];
      for (const dvec3 &p : {corners[0], second, third}) triangles_.corner_vertex.push_back(vertex(p));
    }
  }

  Triangles finish() { return shape(std::move(triangles_.positions), std::move(triangles_.corner_vertex)); }

private:
  Triangles triangles_;
  std::map<std::tuple<long, long, long>, int32_t> vertices_;
};

} // namespace

Triangles shape(std::vector<vec3> positions, std::vector<int32_t> corners) {
  Triangles triangles;
  triangles.vertex_count = static_cast<int>(positions.size());
  triangles.triangle_count = static_cast<int>(corners.size() / 3);
  triangles.positions = std::move(positions);
  triangles.corner_vertex = std::move(corners);
  triangles.half_edge_sharp.assign(triangles.corner_vertex.size(), 0);
  return triangles;
}

Triangles cone(int sides) {
  std::vector<vec3> positions{{0, 0, 1}};
  std::vector<int32_t> corners;
  for (int i = 0; i < sides; ++i) {
    const double angle = 2 * pi * i / sides;
    positions.emplace_back(std::cos(angle), std::sin(angle), 0);
    corners.insert(corners.end(), {0, 1 + i, 1 + (i + 1) % sides});
  }
  return shape(std::move(positions), std::move(corners));
}

Triangles box(int cells) {
  Builder builder;
  for (int side = 0; side < 6; ++side)
    for (int i = 0; i < cells; ++i)
      for (int j = 0; j < cells; ++j) {
        const auto at = [&](int a, int b) {
          dvec3 p(0);
          p[side / 2] = side % 2 ? -1 : 1;
          p[(side / 2 + 1) % 3] = 2.0 * a / cells - 1;
          p[(side / 2 + 2) % 3] = 2.0 * b / cells - 1;
          return p;
        };
        builder.polygon({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
      }
  return builder.finish();
}

Triangles bevelled_box(double width) {
  Builder builder;
  const auto at = [&](int corner, int axis) { // of the three points that a corner is cut into, the one on the side of this axis
    dvec3 p(0);
    for (int k = 0; k < 3; ++k) p[k] = (corner >> k & 1 ? -1 : 1) * (k == axis ? 1 : 1 - width);
    return p;
  };
  for (int axis = 0; axis < 3; ++axis) {
    const int b = 1 << (axis + 1) % 3, c = 1 << (axis + 2) % 3;
    for (const int a : {0, 1 << axis}) builder.polygon({at(a, axis), at(a | b, axis), at(a | b | c, axis), at(a | c, axis)});
    for (const int k : {0, b, c, b | c}) { // along this axis
      const int one = (axis + 1) % 3, other = (axis + 2) % 3;
      builder.polygon({at(k, one), at(k | 1 << axis, one), at(k | 1 << axis, other), at(k, other)});
    }
  }
  for (int corner = 0; corner < 8; ++corner) builder.polygon({at(corner, 0), at(corner, 1), at(corner, 2)});
  return builder.finish();
}

Triangles prism(int sides, int rows, int rings) {
  Builder builder;
  const auto at = [&](int side, double z, double scale = 1) {
    const double angle = 2 * pi * (side % sides) / sides;
    return dvec3(scale * std::cos(angle), scale * std::sin(angle), z);
  };
  for (int i = 0; i < sides; ++i) {
    for (int row = 0; row < rows; ++row) {
      const double low = 2.0 * row / rows - 1, high = 2.0 * (row + 1) / rows - 1;
      builder.polygon({at(i, low), at(i + 1, low), at(i + 1, high), at(i, high)});
    }
    for (const double z : {-1.0, 1.0}) {
      for (int ring = 1; ring < rings; ++ring) {
        const double inner = static_cast<double>(ring) / rings, outer = static_cast<double>(ring + 1) / rings;
        builder.polygon({at(i, z, inner), at(i + 1, z, inner), at(i + 1, z, outer), at(i, z, outer)});
      }
      builder.polygon({dvec3(0, 0, z), at(i, z, 1.0 / rings), at(i + 1, z, 1.0 / rings)});
    }
  }
  return builder.finish();
}

double diagonal_of(const Triangles &triangles) {
  dvec3 low(1e30), high(-1e30);
  for (const vec3 p : triangles.positions)
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], static_cast<double>(p[k]));
      high[k] = std::max(high[k], static_cast<double>(p[k]));
    }
  return glm::length(high - low);
}

} // namespace paradesc::test
