// A place on the surface → the region connected to it within a ball: parts of facets, and triangles outside of facets.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/creases/face_rows.h"

namespace paradesc {

// A connected part of a facet's cut with the ball.
struct FacetPart {
  int32_t facet;
  int32_t begin, end; // the sides that meet the ball there, in FacetFlood::sides
};

// Reused by one thread from place to place, so that arrays stay allocated; the surface is borrowed.
class FacetFlood {
public:
  FacetFlood(const CreasedSurface &surface, const FaceRows &rows);

  // Floods from all triangles around a point of the mesh, or from within a triangle (point: -1).
  void run(dvec3 center, int32_t point, int32_t triangle, double radius);
  // Triangles outside of facets. Behind them, the first row is repeated as often as there are lanes.
  const FaceRow *const *rows() const { return rows_.data(); }
  int32_t triangles() const { return static_cast<int32_t>(reached_); }
  int32_t own_triangles() const { return static_cast<int32_t>(own_triangles_); } // those around the center, which come first
  std::span<const int32_t> large() const { return large_; }                      // those of them that are FACE_LARGE
  // Returns whether the flood reached the face of a half-edge that meets the ball.
  bool has_reached(int32_t half_edge) const;
  std::span<const FacetPart> parts() const { return parts_; }
  std::span<const int32_t> sides(const FacetPart &part) const {
    return std::span(sides_).subspan(static_cast<size_t>(part.begin), static_cast<size_t>(part.end - part.begin));
  }
  // Facets of the starting triangles; may contain duplicates.
  std::span<const int32_t> own_facets() const { return own_facets_; }
  bool is_inside(dvec3 place) const;

private:
  // The half-edge by which the flood reached a triangle, and whether begin (1) and end (2) of it lie in the ball.
  struct Entered {
    int32_t half_edge, inside;
  };
  enum class Mark : uint8_t {}; // of one of the last places; small, so that caches hold those of many triangles
  enum class Cut : uint8_t { one, several };
  struct Met {
    int32_t place = 0; // the last place that met it
    Cut cut = Cut::one;
  };

  void start(int32_t triangle);
  void reach(int32_t half_edge, bool begin_inside, bool end_inside);
  void append(int32_t half_edge, bool begin_inside, bool end_inside, bool is_new);
  void go_on(size_t reached);
  void cross(const FaceRow &row, int32_t k, bool begin_inside, bool end_inside);
  bool is_one(int32_t facet);
  void reach_part(int32_t triangle);
  void cross(const FacetSide &side);
  bool is_inside(int32_t corner) const { return is_inside(dvec3(triangles_.position(corner))); }
  bool meets(dvec3 begin, dvec3 end) const;
  bool meets(int32_t half_edge) const;

  const Triangles &triangles_;
  const HalfEdges &half_edges_;
  const Facets &facets_;
  const FaceRows &all_rows_;
  dvec3 center_{0};
  double radius_ = 0;
  std::vector<Mark> mark_;         // (triangles) of the last place that reached it
  std::vector<Met> met_;           // (facets)
  std::vector<int32_t> side_mark_; // the same for sides, if a facet has several parts
  int32_t places_ = 0;
  Mark own_mark_{};
  size_t reached_ = 0, own_triangles_ = 0;
  std::vector<Entered> entered_; // of reached triangles
  std::vector<const FaceRow *> rows_;
  std::vector<int32_t> large_, sides_, own_facets_;
  std::vector<FacetPart> parts_;
  std::vector<int32_t> waiting_; // triangles of a part
};

} // namespace paradesc
