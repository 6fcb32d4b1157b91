// Grows facets from triangle to triangle: each triangle must fit what the earlier ones have in common. Then outlines are traced
// and straightened. Components are independent of each other, so that those of many parts are built in parallel.
#include "mesh/facets.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mesh/steady_faces.h"
#include "support/angle.h"
#include "support/parallel.h"

namespace paradesc {

namespace {

// Distance of corners from a plane and of points from a line that rounding explains, relative to the largest coordinate.
constexpr double flatness = 1.0 / (1 << 20);
// Tolerance of normals: least_turn plus the angle by which a sixteenth of `flat` turns a triangle of this height, <= most_turn.
constexpr double least_turn = 1.0 / (1 << 19), most_turn = 1e-3, sixteenth = 0.0625;

struct Mesh {
  const Triangles &triangles;
  const HalfEdges &half_edges;
  const Normals &normals;
  const Creases &creases;
  double flat; // a distance

  dvec3 place(int32_t corner) const { return dvec3(triangles.position(corner)); }
  dvec3 normal(int32_t corner) const { return dvec3(normals.corner(static_cast<size_t>(corner))); }
  dvec3 product(int32_t triangle) const {
    const dvec3 a = place(3 * triangle);
    return glm::cross(place(3 * triangle + 1) - a, place(3 * triangle + 2) - a);
  }
  bool is_needle(int32_t triangle) const { return steady_face(triangles, half_edges, triangle) != triangle; }
};

// The properties that the triangles of a facet share: area-weighted sums, and the means that follow from them.
class Common {
public:
  Common(const Mesh &mesh, int32_t seed, dvec3 product)
      : mesh_(mesh), origin_(mesh.place(3 * seed)), normal_(glm::normalize(product)) {
    axes_.first = glm::normalize(mesh.place(3 * seed + 1) - origin_);
    axes_.second = glm::cross(normal_, axes_.first);
    add(seed);
  }

  bool lies_in_plane(int32_t corner) const {
    return std::abs(glm::dot(normal_, mesh_.place(corner) - origin_ - middle_)) <= mesh_.flat;
  }

  bool takes(int32_t triangle) const {
    double longest = 0;
    for (int32_t corner = 3 * triangle; corner < 3 * triangle + 3; ++corner) {
      if (!lies_in_plane(corner)) return false;
      longest = std::max(longest, glm::distance(mesh_.place(corner), mesh_.place(next_corner(corner))));
    }
    const dvec3 product = mesh_.product(triangle);
    constexpr double same_side = 0.9;
    const double area = glm::length(product);
    if (glm::dot(product, normal_) < same_side * area && !mesh_.is_needle(triangle)) return false;
    const double turn = area > 0 ? std::min(least_turn + sixteenth * mesh_.flat * longest / area, most_turn) : most_turn;
    for (int32_t corner = 3 * triangle; corner < 3 * triangle + 3; ++corner) {
      const dvec2 from_middle = axes_.of(mesh_.place(corner) - origin_ - middle_);
      const dvec3 off =
          mesh_.normal(corner) - mean_ - gradient_.along_first * from_middle.x - gradient_.along_second * from_middle.y;
      if (glm::dot(off, off) > turn * turn) return false;
    }
    return true;
  }

  void add(int32_t triangle) {
    const dvec3 product = mesh_.product(triangle);
    const double twice_area = glm::length(product);
    const NormalGradient gradient = gradient_times_twice_area(mesh_.triangles, mesh_.normals, triangle, axes_);
    products_ += product;
    twice_area_ += twice_area;
    for (int32_t corner = 3 * triangle; corner < 3 * triangle + 3; ++corner) {
      places_ += twice_area / 3 * (mesh_.place(corner) - origin_);
      normals_ += twice_area / 3 * mesh_.normal(corner);
    }
    gradients_.along_first += gradient.along_first;
    gradients_.along_second += gradient.along_second;
    normal_ = glm::normalize(products_);
    middle_ = places_ / twice_area_;
    mean_ = normals_ / twice_area_;
    gradient_ = {gradients_.along_first / twice_area_, gradients_.along_second / twice_area_};
  }

  Facet facet() const {
    Facet facet{};
    facet.normal = normal_;
    facet.middle = origin_ + middle_;
    facet.axes.first = glm::normalize(axes_.first - normal_ * glm::dot(normal_, axes_.first));
    facet.axes.second = glm::cross(normal_, facet.axes.first);
    facet.gradient = gradient_.in(facet.axes);
    return facet;
  }

private:
  const Mesh &mesh_;
  dvec3 origin_;
  PlaneAxes axes_{}; // of the first triangle
  dvec3 normal_, middle_{0}, mean_{0};
  NormalGradient gradient_{};
  dvec3 products_{0}, places_{0}, normals_{0};
  double twice_area_ = 0;
  NormalGradient gradients_{};
};

// The set of lines from the current point that pass all points so far within a distance.
class Sleeve {
public:
  Sleeve(dvec2 begin, double width) : begin_(begin), width_(width) {}

  // Tests whether the line can end at `end`; if so, extends it to there.
  bool takes(dvec2 end) {
    const dvec2 way = end - begin_;
    const double length = glm::length(way);
    if (is_open_ && (cross(low_, way) < 0 || cross(way, high_) < 0 || glm::dot(low_ + high_, way) < 0 || length < longest_))
      return false;
    longest_ = length;
    if (!(length > width_)) return true;
    const dvec2 across = dvec2(-way.y, way.x) * (width_ / length);
    if (!is_open_ || cross(low_, way - across) > 0) low_ = way - across;
    if (!is_open_ || cross(way + across, high_) > 0) high_ = way + across;
    return is_open_ = true;
  }

private:
  dvec2 begin_, low_{0}, high_{0};
  double width_, longest_ = 0;
  bool is_open_ = false;
};

// Builds the facets of some components, and numbers them from 0; move_to() gives them their numbers among all.
class Building {
public:
  Building(const Mesh &mesh, Facets &all) : mesh_(mesh), all_(all) {}

  void grow(std::span<const int32_t> triangles);
  void trace();
  size_t facets() const { return facet_.size(); }
  size_t sides() const { return side_.size(); }
  size_t outlines() const { return outline_.size(); }
  void move_to(int32_t first_facet, int32_t first_side, int32_t first_outline);

private:
  void grow_from(int32_t seed);
  int32_t behind(int32_t half_edge) const; // a facet; ~t for a triangle t that is in none; ~triangle_count at boundaries
  bool is_outline(int32_t half_edge, int32_t facet) const {
    return mesh_.creases.contains(half_edge) || behind(half_edge) != facet;
  }
  void trace(int32_t facet);
  void add_loop(int32_t facet, int32_t half_edge);
  void add_side(int32_t facet, std::span<const int32_t> half_edges);
  bool is_convex(const Facet &facet) const;

  const Mesh &mesh_;
  Facets &all_;
  std::vector<Facet> facet_; // as in Facets, like the next two
  std::vector<FacetSide> side_;
  std::vector<int32_t> outline_;
  std::vector<int32_t> loop_;
  std::vector<int32_t> member_, member_begin_{0}; // triangles, facet after facet
};

void Building::grow(std::span<const int32_t> triangles) {
  for (size_t i = 0; i < triangles.size(); ++i) {
    checkpoint_at(i);
    grow_from(triangles[i]);
  }
}

void Building::grow_from(int32_t seed) {
  if (all_.of_triangle[seed] >= 0 || mesh_.half_edges.corner_point[3 * seed] < 0) return;
  const dvec3 product = mesh_.product(seed);
  if (!(glm::dot(product, product) > 0) || mesh_.is_needle(seed)) return;
  const auto index = static_cast<int32_t>(facet_.size());
  const size_t first = member_.size();
  Common common(mesh_, seed, product);
  all_.of_triangle[seed] = index;
  member_.push_back(seed);
  for (size_t looked = first; looked < member_.size(); ++looked)
    for (int32_t edge = 3 * member_[looked], end = edge + 3; edge < end; ++edge) {
      const int32_t twin = mesh_.half_edges.twin[edge];
      if (twin < 0 || mesh_.creases.contains(edge) || all_.of_triangle[twin / 3] >= 0) continue;
      if (!common.lies_in_plane(previous_corner(twin)) || !common.takes(twin / 3)) continue;
      common.add(twin / 3);
      all_.of_triangle[twin / 3] = index;
      member_.push_back(twin / 3);
    }
  if (member_.size() == first + 1) {
    member_.pop_back();
    all_.of_triangle[seed] = -1;
    return;
  }
  member_begin_.push_back(static_cast<int32_t>(member_.size()));
  facet_.push_back(common.facet());
}

int32_t Building::behind(int32_t half_edge) const {
  const int32_t twin = mesh_.half_edges.twin[half_edge];
  if (twin < 0) return ~mesh_.triangles.triangle_count;
  const int32_t facet = all_.of_triangle[twin / 3];
  return facet >= 0 ? facet : ~(twin / 3);
}

void Building::trace() {
  for (int32_t facet = 0; facet < static_cast<int32_t>(facet_.size()); ++facet) {
    if (facet % 1024 == 0) checkpoint();
    trace(facet);
  }
}

void Building::trace(int32_t facet) {
  Facet &of = facet_[facet];
  of.side_begin = static_cast<int32_t>(side_.size());
  int loops = 0;
  for (int32_t m = member_begin_[facet]; m < member_begin_[facet + 1]; ++m)
    for (int32_t edge = 3 * member_[m], end = edge + 3; edge < end; ++edge) {
      if (all_.side_of[edge] >= 0 || !is_outline(edge, facet)) continue;
      add_loop(facet, edge);
      ++loops;
    }
  of.side_end = static_cast<int32_t>(side_.size());
  of.is_convex = loops == 1 && is_convex(of);
}

void Building::add_loop(int32_t facet, int32_t half_edge) {
  std::vector<int32_t> &loop = loop_;
  loop.clear();
  for (int32_t edge = half_edge; loop.empty() || edge != half_edge;) {
    loop.push_back(edge);
    for (edge = next_corner(edge); !is_outline(edge, facet);) edge = next_corner(mesh_.half_edges.twin[edge]);
  }
  const Facet &of = facet_[facet];
  const auto place = [&](int32_t corner) { return of.axes.of(mesh_.place(corner) - of.middle); };
  const auto goes_on = [&](Sleeve &sleeve, int32_t before, int32_t edge) {
    return behind(edge) == behind(before) && mesh_.creases.contains(edge) == mesh_.creases.contains(before) &&
           sleeve.takes(place(next_corner(edge)));
  };
  for (size_t i = 0; i < loop.size(); ++i) { // rotates the loop so that it starts at the start of a side
    const int32_t before = i == 0 ? loop.back() : loop[i - 1];
    Sleeve sleeve(place(before), mesh_.flat);
    sleeve.takes(place(loop[i]));
    if (goes_on(sleeve, before, loop[i])) continue;
    std::rotate(loop.begin(), loop.begin() + static_cast<ptrdiff_t>(i), loop.end());
    break;
  }
  for (size_t begin = 0, end = 0; begin < loop.size(); begin = end) {
    Sleeve sleeve(place(loop[begin]), mesh_.flat);
    sleeve.takes(place(next_corner(loop[begin])));
    for (end = begin + 1; end < loop.size() && goes_on(sleeve, loop[begin], loop[end]);) ++end;
    add_side(facet, std::span(loop).subspan(begin, end - begin));
  }
}

void Building::add_side(int32_t facet, std::span<const int32_t> half_edges) {
  const int32_t first = half_edges.front(), twin = mesh_.half_edges.twin[first];
  FacetSide side{mesh_.place(first), mesh_.place(next_corner(half_edges.back())), 0, -1, 0, 0, false};
  if (twin >= 0) {
    side.neighbor = all_.of_triangle[twin / 3];
    const dvec3 other =
        side.neighbor >= 0 ? facet_[side.neighbor].normal : steady_normal(mesh_.triangles, mesh_.half_edges, twin / 3);
    side.bend = bend_between(facet_[facet].normal, other, side.end - side.begin);
  }
  side.half_edge = static_cast<int32_t>(outline_.size());
  side.half_edges = static_cast<int32_t>(half_edges.size());
  side.is_crease = mesh_.creases.contains(first);
  for (const int32_t edge : half_edges) all_.side_of[edge] = static_cast<int32_t>(side_.size());
  outline_.insert(outline_.end(), half_edges.begin(), half_edges.end());
  side_.push_back(side);
}

// Tests one boundary loop. Reflex corners within the flatness tolerance are ignored unless there are many.
bool Building::is_convex(const Facet &facet) const {
  double turned = 0;
  for (int32_t s = facet.side_begin; s < facet.side_end; ++s) {
    const FacetSide &side = side_[s], &next = side_[s + 1 < facet.side_end ? s + 1 : facet.side_begin];
    const dvec2 here = facet.axes.of(side.end - side.begin), there = facet.axes.of(next.end - next.begin);
    const double turn = cross(here, there);
    if (turn < -mesh_.flat * std::max(glm::length(here), glm::length(there))) return false;
    turned += std::abs(angle_of(turn, glm::dot(here, there)));
  }
  constexpr double rounding = 1e-3;
  return turned < 2 * pi + rounding;
}

void Building::move_to(int32_t first_facet, int32_t first_side, int32_t first_outline) {
  for (const int32_t triangle : member_) all_.of_triangle[triangle] += first_facet;
  for (const int32_t half_edge : outline_) all_.side_of[half_edge] += first_side;
  for (Facet &facet : facet_) {
    facet.side_begin += first_side;
    facet.side_end += first_side;
  }
  for (FacetSide &side : side_) {
    if (side.neighbor >= 0) side.neighbor += first_facet;
    side.half_edge += first_outline;
  }
  std::ranges::copy(facet_, all_.facet.begin() + first_facet);
  std::ranges::copy(side_, all_.side.begin() + first_side);
  std::ranges::copy(outline_, all_.outline.begin() + first_outline);
}

// The triangles of each block of components, ascending within each component.
struct ComponentBlocks {
  std::vector<int32_t> triangle, begin; // begin: (blocks + 1)
  std::span<const int32_t> of(int block) const {
    return std::span(triangle).subspan(static_cast<size_t>(begin[block]), static_cast<size_t>(begin[block + 1] - begin[block]));
  }
};

ComponentBlocks blocks_of_components(const std::vector<int32_t> &piece_of_triangle) {
  constexpr int32_t least = 4096; // triangles of a block
  int32_t pieces = 0;
  for (const int32_t piece : piece_of_triangle) pieces = std::max(pieces, piece + 1);
  std::vector<int32_t> next(static_cast<size_t>(pieces) + 1, 0);
  for (const int32_t piece : piece_of_triangle)
    if (piece >= 0) ++next[piece + 1];
  ComponentBlocks blocks;
  blocks.begin.push_back(0);
  for (int32_t piece = 0; piece < pieces; ++piece) {
    next[piece + 1] += next[piece];
    if (next[piece + 1] - blocks.begin.back() >= least || piece + 1 == pieces) blocks.begin.push_back(next[piece + 1]);
  }
  blocks.triangle.resize(static_cast<size_t>(next[pieces]));
  for (size_t t = 0; t < piece_of_triangle.size(); ++t)
    if (const int32_t piece = piece_of_triangle[t]; piece >= 0) blocks.triangle[next[piece]++] = static_cast<int32_t>(t);
  return blocks;
}

} // namespace

Facets no_facets(const Triangles &triangles) {
  Facets facets;
  facets.of_triangle.assign(static_cast<size_t>(triangles.triangle_count), -1);
  return facets;
}

Facets find_facets(const Triangles &triangles, const HalfEdges &half_edges, const Normals &normals, const Creases &creases,
                   int threads) {
  Facets facets = no_facets(triangles);
  const Box box = bounding_box(triangles, half_edges);
  const dvec3 largest = glm::max(glm::abs(box.low), glm::abs(box.high));
  const Mesh mesh{triangles, half_edges, normals, creases, flatness * std::max({largest.x, largest.y, largest.z})};
  const ComponentBlocks blocks = blocks_of_components(half_edges.triangle_piece);
  std::vector<Building> building(blocks.begin.size() - 1, Building(mesh, facets));
  const auto count = static_cast<int>(building.size());
  parallel_blocks(count, threads, 1, [&](int i, int) { building[i].grow(blocks.of(i)); });
  const auto total = [&](const auto &number) { // where each begins, and the sum
    std::vector<int32_t> begin{0};
    for (const Building &one : building) begin.push_back(begin.back() + static_cast<int32_t>(number(one)));
    return begin;
  };
  const std::vector<int32_t> first_facet = total([](const Building &one) { return one.facets(); });
  if (first_facet.back() == 0) return facets;
  facets.side_of.assign(half_edges.twin.size(), -1);
  parallel_blocks(count, threads, 1, [&](int i, int) { building[i].trace(); });
  const std::vector<int32_t> first_side = total([](const Building &one) { return one.sides(); }),
                             first_outline = total([](const Building &one) { return one.outlines(); });
  facets.facet.resize(static_cast<size_t>(first_facet.back()));
  facets.side.resize(static_cast<size_t>(first_side.back()));
  facets.outline.resize(static_cast<size_t>(first_outline.back()));
  parallel_blocks(count, threads, 1,
                  [&](int i, int) { Building(std::move(building[i])).move_to(first_facet[i], first_side[i], first_outline[i]); });
  return facets;
}

} // namespace paradesc
