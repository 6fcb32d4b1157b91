// A triangle list, as split and as non-manifold as in the file → manifold half-edges in flat arrays, connected by OpenMesh.
//
// Edges are paired by vertex and then by position; every fan of paired faces gets a point of its own. If two edges would run
// between the same points, OpenMesh connects the faces over these points, and its half-edges are read back. If none do, OpenMesh
// would produce the pairs that are already known.
#include "mesh/halfedge.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized" // OpenMesh pushes points before it sets them; seen under sanitizers
#endif

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>

#include "mesh/copies.h"
#include "mesh/pairing.h"
#include "mesh/weld.h"
#include "support/angle.h"
#include "support/cancel.h"
#include "support/parallel.h"

namespace paradesc {
namespace {

using Mesh = OpenMesh::TriMesh_ArrayKernelT<>;

// Twice the area relative to the squared longest edge. Positions are floats, so real slivers lie far above this limit; below it
// a triangle is collinear up to the rounding of this very test.
constexpr double no_area = 1e-12;

constexpr double equally_wide = 1e-9; // radians; the angles of a face's front and back differ by the summation order

dvec3 position(const Triangles &triangles, int corner) { return dvec3(triangles.positions[triangles.corner_vertex[corner]]); }

bool is_degenerate(const Triangles &triangles, int triangle) {
  const dvec3 a = position(triangles, 3 * triangle);
  const dvec3 ab = position(triangles, 3 * triangle + 1) - a;
  const dvec3 ac = position(triangles, 3 * triangle + 2) - a;
  const double longest = std::max({glm::dot(ab, ab), glm::dot(ac, ac), glm::dot(ac - ab, ac - ab)});
  return glm::length(glm::cross(ab, ac)) <= no_area * longest; // two corners at one position are degenerate, too
}

// OpenMesh's messages do not help the host's user: refused faces are handled below.
void silence_openmesh() {
  static const bool silent = [] {
    omerr().disable();
    omlog().disable();
    omout().disable();
    return true;
  }();
  static_cast<void>(silent);
}

// Adds the points of all fans and every triangle in use. A face that OpenMesh refuses gets points of its own: it is detached from
// its neighbors, but not lost. corner_vertex receives the OpenMesh vertex of each corner. Returns the triangle of each face.
std::vector<int32_t> add_faces(const Triangles &triangles, const std::vector<uint8_t> &left_out, const Fans &fans, Mesh &mesh,
                               std::vector<int32_t> &corner_vertex) {
  const auto add_vertex = [&](int corner) {
    const vec3 &p = triangles.positions[triangles.corner_vertex[corner]];
    return mesh.add_vertex(Mesh::Point(p.x, p.y, p.z)).idx();
  };
  const auto add_face = [&](int triangle) {
    const int32_t *v = corner_vertex.data() + 3 * triangle;
    return mesh.add_face(mesh.vertex_handle(static_cast<unsigned>(v[0])), mesh.vertex_handle(static_cast<unsigned>(v[1])),
                         mesh.vertex_handle(static_cast<unsigned>(v[2])));
  };
  mesh.reserve(fans.count, fans.corner_fan.size() / 2 + fans.count, left_out.size());
  for (int32_t corner : fans.first) add_vertex(corner);
  corner_vertex = fans.corner_fan; // fan i is vertex i
  std::vector<int32_t> face_triangle;
  face_triangle.reserve(left_out.size());
  for (int triangle = 0; triangle < triangles.triangle_count; ++triangle) {
    if (triangle % 4096 == 0) checkpoint();
    if (left_out[triangle]) continue;
    if (!add_face(triangle).is_valid()) {
      for (int corner = 3 * triangle; corner < 3 * triangle + 3; ++corner) corner_vertex[corner] = add_vertex(corner);
      add_face(triangle);
    }
    face_triangle.push_back(triangle);
  }
  return face_triangle;
}

// OpenMesh's connectivity → twin by corner.
std::vector<int32_t> read_twins(const Mesh &mesh, const std::vector<int32_t> &face_triangle,
                                const std::vector<int32_t> &corner_vertex) {
  std::vector<int32_t> half_edge_corner(mesh.n_halfedges(), -1);
  for (size_t face = 0; face < face_triangle.size(); ++face) {
    checkpoint_at(face);
    auto half_edge = mesh.halfedge_handle(mesh.face_handle(static_cast<unsigned>(face)));
    const int32_t start = mesh.from_vertex_handle(half_edge).idx();
    int corner = 3 * face_triangle[face];
    while (corner_vertex[corner] != start) ++corner; // ends: one of the three corners matches
    for (int i = 0; i < 3; ++i) {
      half_edge_corner[half_edge.idx()] = corner;
      half_edge = mesh.next_halfedge_handle(half_edge);
      corner = next_corner(corner);
    }
  }
  std::vector<int32_t> twin(corner_vertex.size(), -1);
  for (size_t i = 0; i < half_edge_corner.size(); ++i)
    if (half_edge_corner[i] >= 0) twin[half_edge_corner[i]] = half_edge_corner[i ^ 1]; // halves of one edge are neighbors
  return twin;
}

std::vector<int32_t> connect(const Triangles &triangles, const std::vector<uint8_t> &left_out, const Fans &fans) {
  silence_openmesh();
  Mesh mesh;
  std::vector<int32_t> corner_vertex;
  const std::vector<int32_t> face_triangle = add_faces(triangles, left_out, fans, mesh, corner_vertex);
  return read_twins(mesh, face_triangle, corner_vertex);
}

// Returns whether unpaired half-edges run between the same two points: OpenMesh knows only one edge there, and would pair them or
// refuse a face. This can only happen at an edge that was taken apart, at a point of several vertices, or at copies of faces.
bool is_in_doubt(const Triangles &triangles, const std::vector<uint8_t> &left_out, const Pairing &pairing, const Fans &fans) {
  std::vector<int32_t> fan_vertex(fans.count);
  for (size_t fan = 0; fan < fan_vertex.size(); ++fan) fan_vertex[fan] = triangles.corner_vertex[fans.first[fan]];
  std::vector<uint8_t> is_mixed(fans.count, 0);
  for (size_t corner = 0; corner < fans.corner_fan.size(); ++corner) {
    checkpoint_at(corner);
    const int32_t fan = fans.corner_fan[corner];
    if (fan >= 0 && fan_vertex[fan] != triangles.corner_vertex[corner]) is_mixed[fan] = 1;
  }
  std::vector<int32_t> doubtful;
  for (int32_t h = 0; h < 3 * triangles.triangle_count; ++h) {
    checkpoint_at(h);
    if (left_out[h / 3]) continue;
    const int32_t from = fans.corner_fan[h], to = fans.corner_fan[next_corner(h)];
    if (pairing.has_copies || pairing.nonmanifold[h] || is_mixed[from] || is_mixed[to]) doubtful.push_back(h);
  }
  bool found = false;
  if (doubtful.empty()) return found;
  for_each_edge(doubtful, fans.corner_fan, fans.count, [&](std::span<const int32_t> edge) {
    found = found || edge.size() > 2 || (edge.size() == 2 && pairing.twin[edge[0]] != edge[1]);
  });
  return found;
}

void count_edges(const Pairing &pairing, HalfEdges &result) {
  result.nonmanifold_edges = pairing.nonmanifold_edges;
  result.opposed_edges = pairing.opposed_edges;
  for (size_t h = 0; h < result.twin.size(); ++h) {
    checkpoint_at(h);
    if (result.corner_point[h] < 0 || result.twin[h] >= 0) continue;
    const int32_t lost = pairing.twin[h]; // paired by us, but its face was refused
    if (lost > static_cast<int32_t>(h)) ++result.nonmanifold_edges;
    if (lost < 0 && !pairing.nonmanifold[h]) ++result.boundary_edges;
  }
}

void describe_points(const Triangles &triangles, const Fans &fans, HalfEdges &result) {
  result.point_count = fans.count;
  result.corner_point = fans.corner_fan;
  checkpoint();
  result.point_half_edge = fans.first;
  result.point_boundary.resize(fans.count);
  checkpoint();
  for (size_t point = 0; point < fans.first.size(); ++point) // a fan that closes has no edge without a twin
    result.point_boundary[point] = result.twin[fans.first[point]] < 0;
  result.point_vertex.assign(fans.count, triangles.vertex_count);
  for (size_t corner = 0; corner < fans.corner_fan.size(); ++corner) {
    checkpoint_at(corner);
    if (fans.corner_fan[corner] < 0) continue;
    int32_t &vertex = result.point_vertex[fans.corner_fan[corner]];
    vertex = std::min(vertex, triangles.corner_vertex[corner]);
  }
}

// The widest of several points of one vertex answers for it; among equally wide ones, the first.
void choose_widest(const Triangles &triangles, const std::vector<uint8_t> &is_split, HalfEdges &result) {
  std::vector<double> angle(result.point_count, 0.0);
  for (size_t corner = 0; corner < result.corner_point.size(); ++corner) {
    checkpoint_at(corner);
    const int32_t point = result.corner_point[corner];
    if (point >= 0) angle[point] += surface_angle(triangles, static_cast<int>(corner));
  }
  for (size_t corner = 0; corner < result.corner_point.size(); ++corner) {
    const int32_t point = result.corner_point[corner];
    if (point < 0 || !is_split[triangles.corner_vertex[corner]]) continue;
    int32_t &chosen = result.vertex_point[triangles.corner_vertex[corner]];
    const double gain = angle[point] - angle[chosen];
    if (gain > equally_wide || (gain >= -equally_wide && point < chosen)) chosen = point;
  }
}

// Assigns points to vertices whose faces were all left out. Such a vertex gets the point at its place: the point of the face that
// stands in for a copy, else the first point there. stands_in: as leave_out_copies returns it.
void answer_left_out(const Triangles &triangles, const Places &places, const std::vector<int32_t> &stands_in, HalfEdges &result) {
  if (!places.are_shared()) return;
  std::vector<int32_t> place_point(triangles.vertex_count, -1);
  for (int32_t vertex = 0; vertex < triangles.vertex_count; ++vertex) {
    checkpoint_at(vertex);
    int32_t &point = place_point[places.of_vertex[vertex]];
    if (point < 0) point = result.vertex_point[vertex];
  }
  for (int32_t corner = 0; corner < 3 * triangles.triangle_count; ++corner) {
    checkpoint_at(corner);
    int32_t &point = result.vertex_point[triangles.corner_vertex[corner]];
    if (result.corner_point[corner] >= 0 || point >= 0) continue;
    const int32_t place = places.of_corner[corner];
    point = place_point[place];
    if (stands_in.empty() || stands_in[corner / 3] < 0) continue;
    int32_t there = 3 * stands_in[corner / 3];
    while (places.of_corner[there] != place) ++there; // one of its three
    point = result.corner_point[there];
  }
}

void answer_vertices(const Triangles &triangles, const Places &places, const std::vector<int32_t> &stands_in, HalfEdges &result) {
  std::vector<uint8_t> is_split(triangles.vertex_count, 0), is_split_position(triangles.vertex_count, 0);
  result.vertex_point.assign(triangles.vertex_count, -1);
  for (size_t corner = 0; corner < result.corner_point.size(); ++corner) {
    checkpoint_at(corner);
    const int32_t vertex = triangles.corner_vertex[corner];
    const int32_t point = result.corner_point[corner];
    if (point < 0) continue;
    int32_t &first = result.vertex_point[vertex];
    if (first < 0) first = point;
    if (first == point || is_split[vertex]) continue;
    is_split[vertex] = 1;
    result.nonmanifold_vertices += is_split_position[places.of_vertex[vertex]]++ == 0;
  }
  if (result.nonmanifold_vertices > 0) choose_widest(triangles, is_split, result);
  if (result.degenerate_triangles + result.copied_triangles > 0) answer_left_out(triangles, places, stands_in, result);
  std::vector<uint8_t> is_answered(result.point_count, 0);
  for (const int32_t point : result.vertex_point) {
    if (point < 0)
      ++result.loose_vertices;
    else if (is_answered[point])
      ++result.welded_vertices;
    else
      is_answered[point] = 1;
  }
}

// A surface without copies of faces: its places, pairs, and the faces that stand in for those left out.
struct Surface {
  Places places;
  Pairing pairing;
  std::vector<int32_t> stands_in; // as leave_out_copies returns it
};

Surface pair_surface(const Triangles &triangles, std::vector<uint8_t> &left_out) {
  Surface surface;
  surface.places = weld(triangles);
  checkpoint();
  surface.pairing = pair_half_edges(triangles, surface.places, left_out);
  if (weld_rims(triangles, left_out, surface.pairing.open, surface.places))
    surface.pairing = pair_half_edges(triangles, surface.places, left_out);
  if (!surface.pairing.has_copies && !has_copies_of(triangles, surface.places, left_out, surface.pairing.open)) return surface;
  Copies copies = find_copies(triangles, surface.places, left_out);
  if (copies.groups.empty()) return surface;
  surface.pairing = pair_half_edges(triangles, surface.places, left_out, &copies);
  surface.stands_in = leave_out_copies(triangles, copies, surface.pairing.twin, left_out);
  if (surface.stands_in.empty()) return surface;
  copies = find_copies(triangles, surface.places, left_out);
  surface.pairing = pair_half_edges(triangles, surface.places, left_out, &copies);
  return surface;
}

} // namespace

double surface_angle(const Triangles &triangles, int corner) {
  const dvec3 p = position(triangles, corner);
  const dvec3 a = position(triangles, next_corner(corner)) - p;
  const dvec3 b = position(triangles, previous_corner(corner)) - p;
  return angle_of(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

Fans trace_fans(const std::vector<int32_t> &link, const std::vector<uint8_t> &left_out) {
  Fans fans;
  fans.corner_fan.assign(link.size(), -1);
  for (int32_t corner = 0; corner < static_cast<int32_t>(link.size()); ++corner) {
    checkpoint_at(corner);
    if (left_out[corner / 3] || fans.corner_fan[corner] >= 0) continue;
    int32_t first = corner; // clockwise to the end of the fan, or once around
    while (link[first] >= 0) {
      first = next_corner(link[first]);
      if (first == corner) break;
    }
    for (int32_t h = first; h >= 0 && fans.corner_fan[h] < 0; h = link[previous_corner(h)]) fans.corner_fan[h] = fans.count;
    fans.first.push_back(first);
    ++fans.count;
  }
  return fans;
}

Pieces trace_pieces(const std::vector<int32_t> &link, const std::vector<uint8_t> &left_out) {
  Pieces pieces;
  pieces.triangle_piece.assign(left_out.size(), -1);
  std::vector<int32_t> open;
  size_t visited = 0;
  for (int32_t start = 0; start < static_cast<int32_t>(left_out.size()); ++start) {
    if (left_out[start] || pieces.triangle_piece[start] >= 0) continue;
    const int32_t piece = pieces.count++;
    pieces.triangle_piece[start] = piece;
    open.push_back(start);
    while (!open.empty()) {
      checkpoint_at(visited++);
      const int32_t triangle = open.back();
      open.pop_back();
      for (int32_t h = 3 * triangle; h < 3 * triangle + 3; ++h) {
        const int32_t next = link[h] < 0 ? triangle : link[h] / 3;
        if (pieces.triangle_piece[next] >= 0) continue;
        pieces.triangle_piece[next] = piece;
        open.push_back(next);
      }
    }
  }
  return pieces;
}

HalfEdges build_half_edges(const Triangles &triangles, int threads) {
  HalfEdges result;
  std::vector<uint8_t> left_out(triangles.triangle_count);
  for (int triangle = 0; triangle < triangles.triangle_count; ++triangle) {
    checkpoint_at(triangle);
    left_out[triangle] = is_degenerate(triangles, triangle);
    result.degenerate_triangles += left_out[triangle];
  }
  Surface surface = pair_surface(triangles, left_out);
  const Pairing &pairing = surface.pairing;
  for (const int32_t other : surface.stands_in) result.copied_triangles += other >= 0;
  checkpoint();
  Fans fans = trace_fans(pairing.twin, left_out);
  checkpoint();
  if (is_in_doubt(triangles, left_out, pairing, fans)) {
    result.twin = connect(triangles, left_out, fans);
    fans = trace_fans(result.twin, left_out); // again: a refused face may have split a fan
  } else {
    result.twin = pairing.twin;
  }
  checkpoint();
  parallel_blocks(2, threads, 1, [&](int part, int) {
    if (part == 0) {
      Pieces pieces = trace_pieces(result.twin, left_out);
      result.components = pieces.count;
      result.triangle_piece = std::move(pieces.triangle_piece);
      return;
    }
    describe_points(triangles, fans, result);
    count_edges(pairing, result);
    answer_vertices(triangles, surface.places, surface.stands_in, result);
  });
  return result;
}

Box bounding_box(const Triangles &triangles, const HalfEdges &half_edges, int threads) {
  constexpr int block = 65536;
  if (half_edges.point_vertex.empty()) return {};
  const auto count = static_cast<int>(half_edges.point_vertex.size());
  std::vector<Bounds<vec3>> parts(static_cast<size_t>(Blocks{count, block}.number()));
  parallel_blocks(count, threads, block, [&](int begin, int end) {
    Bounds<vec3> &part = parts[begin / block];
    for (int i = begin; i < end; ++i) part.add(triangles.positions[half_edges.point_vertex[i]]);
  });
  Bounds<vec3> whole;
  for (const Bounds<vec3> &part : parts) whole.add(part);
  return {dvec3(whole.low), dvec3(whole.high)};
}

// Sums in blocks of a fixed size, so that the sum does not depend on the number of threads.
double mean_edge(const Triangles &triangles, const HalfEdges &mesh, int threads) {
  constexpr int block = 65536;
  const int half_edges = 3 * triangles.triangle_count;
  std::vector<std::pair<double, int>> parts(static_cast<size_t>(Blocks{half_edges, block}.number())); // sum and count
  parallel_blocks(half_edges, threads, block, [&](int begin, int end) {
    auto &[sum, count] = parts[begin / block];
    for (int h = begin; h < end; ++h) {
      // Counts each edge once: a pair by its lower half-edge.
      const int32_t twin = mesh.twin[h];
      if (mesh.corner_point[h] < 0 || (twin >= 0 && twin < h)) continue;
      sum += length(dvec3(triangles.position(next_corner(h))) - dvec3(triangles.position(h)));
      ++count;
    }
  });
  double sum = 0.0;
  int count = 0;
  for (const auto &[part, edges] : parts) {
    sum += part;
    count += edges;
  }
  return count ? sum / count : 0.0;
}

} // namespace paradesc
