// A triangle list, as split and as non-manifold as files are → manifold half-edges in flat arrays, connected by OpenMesh.
//
// Pair edges, by vertex and then by position; give every fan of paired faces a point of its own. Where two edges would run
// between the same points, let OpenMesh connect faces over points and read its half-edges back; where none do, what it would
// make of the faces is what was paired.
#include "mesh/halfedge.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <span>

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized" // OpenMesh pushes points before it sets them; seen under sanitizers
#endif

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>

#include "support/angle.h"
#include "support/cancel.h"
#include "support/parallel.h"

namespace paradesc {
namespace {

using Mesh = OpenMesh::TriMesh_ArrayKernelT<>;

// Twice the area against the square of the longest edge. Positions are floats, so real slivers lie far above this; what lies
// below is collinear but for the rounding of this very test.
constexpr double no_area = 1e-12;

dvec3 position(const Triangles &triangles, int corner) { return dvec3(triangles.positions[triangles.corner_vertex[corner]]); }

bool is_degenerate(const Triangles &triangles, int triangle) {
  const dvec3 a = position(triangles, 3 * triangle);
  const dvec3 ab = position(triangles, 3 * triangle + 1) - a;
  const dvec3 ac = position(triangles, 3 * triangle + 2) - a;
  const double longest = std::max({glm::dot(ab, ab), glm::dot(ac, ac), glm::dot(ac - ab, ac - ab)});
  return glm::length(glm::cross(ab, ac)) <= no_area * longest; // two corners at one position are degenerate, too
}

uint64_t hash(const vec3 &p) {
  uint64_t h = 0;
  for (int i = 0; i < 3; ++i) {
    h = (h ^ std::bit_cast<uint32_t>(p[i] + 0.0f)) * 0x9e3779b97f4a7c15u; // adding zero makes -0 and 0 one
    h ^= h >> 29;
  }
  return h;
}

// Each vertex → the first vertex at exactly the same position.
std::vector<int32_t> weld(const std::vector<vec3> &positions) {
  const size_t slots = std::bit_ceil(2 * positions.size());
  std::vector<int32_t> table(slots, -1);
  std::vector<int32_t> welded(positions.size());
  for (size_t vertex = 0; vertex < positions.size(); ++vertex) {
    checkpoint_at(vertex);
    size_t slot = hash(positions[vertex]) & (slots - 1);
    while (table[slot] >= 0 && positions[table[slot]] != positions[vertex]) slot = (slot + 1) & (slots - 1);
    if (table[slot] < 0) table[slot] = static_cast<int32_t>(vertex);
    welded[vertex] = table[slot];
  }
  return welded;
}

struct Pairing {
  std::vector<int32_t> twin;        // (3 * triangle_count)
  std::vector<uint8_t> nonmanifold; // (3 * triangle_count) 1: a side of an edge that was taken apart
  int nonmanifold_edges = 0;
};

// Calls visit(span of half-edges) once for each edge of the half-edges given, ids[corner] being the ends.
template <class Visit>
void for_each_edge(std::span<const int32_t> half_edges, const std::vector<int32_t> &ids, int id_count, const Visit &visit) {
  struct Side {
    int32_t high;
    int32_t half_edge;
  };
  const auto ends = [&](int32_t h) { return std::minmax(ids[h], ids[next_corner(h)]); };
  std::vector<int32_t> begin(size_t{2} + id_count, 0);
  for (int32_t h : half_edges) ++begin[size_t{2} + ends(h).first];
  checkpoint();
  for (size_t i = 2; i < begin.size(); ++i) begin[i] += begin[i - 1];
  std::vector<Side> sides(half_edges.size());
  checkpoint();
  for (size_t i = 0; i < half_edges.size(); ++i) {
    checkpoint_at(i);
    const auto [low, high] = ends(half_edges[i]);
    sides[begin[size_t{1} + low]++] = {high, half_edges[i]};
  }
  std::vector<int32_t> edge;
  for (int32_t low = 0; low < id_count; ++low) {
    checkpoint_at(low);
    const std::span<Side> bucket(sides.begin() + begin[low], sides.begin() + begin[low + 1]);
    std::ranges::sort(bucket, [](Side a, Side b) { return a.high != b.high ? a.high < b.high : a.half_edge < b.half_edge; });
    for (size_t i = 0; i < bucket.size();) {
      const int32_t high = bucket[i].high;
      for (edge.clear(); i < bucket.size() && bucket[i].high == high; ++i) edge.push_back(bucket[i].half_edge);
      visit(std::span<const int32_t>(edge));
    }
  }
}

// Pairs what can be paired without doubt and returns the half-edges that are alone on their edge.
std::vector<int32_t> pair_edges(std::span<const int32_t> half_edges, const std::vector<int32_t> &ids, int id_count,
                                Pairing &pairing) {
  std::vector<int32_t> alone;
  for_each_edge(half_edges, ids, id_count, [&](std::span<const int32_t> edge) {
    if (edge.size() == 1) {
      alone.push_back(edge[0]);
    } else if (edge.size() == 2 && ids[edge[0]] != ids[edge[1]]) { // they start at different ends
      pairing.twin[edge[0]] = edge[1];
      pairing.twin[edge[1]] = edge[0];
    } else {
      ++pairing.nonmanifold_edges;
      for (int32_t h : edge) pairing.nonmanifold[h] = 1;
    }
  });
  return alone;
}

Pairing pair_half_edges(const Triangles &triangles, const std::vector<int32_t> &welded, const std::vector<uint8_t> &left_out) {
  const int32_t count = 3 * triangles.triangle_count;
  Pairing pairing;
  pairing.twin.assign(count, -1);
  pairing.nonmanifold.assign(count, 0);
  checkpoint();
  std::vector<int32_t> used;
  used.reserve(count);
  for (int32_t h = 0; h < count; ++h) {
    checkpoint_at(h);
    if (!left_out[h / 3]) used.push_back(h);
  }
  const std::vector<int32_t> alone = pair_edges(used, triangles.corner_vertex, triangles.vertex_count, pairing);
  if (alone.empty()) return pairing;
  std::vector<int32_t> corner_position(count);
  for (size_t i = 0; i < corner_position.size(); ++i) corner_position[i] = welded[triangles.corner_vertex[i]];
  pair_edges(alone, corner_position, triangles.vertex_count, pairing);
  return pairing;
}

// A host that prints what OpenMesh thinks of its meshes helps nobody: refused faces are dealt with below.
void silence_openmesh() {
  static const bool silent = [] {
    omerr().disable();
    omlog().disable();
    omout().disable();
    return true;
  }();
  static_cast<void>(silent);
}

// Adds the points of all fans and every triangle in use. A face that OpenMesh refuses gets points of its own: it comes off its
// neighbors, but it is not lost. corner_vertex receives the OpenMesh vertex of each corner; returns the triangle of each face.
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
    while (corner_vertex[corner] != start) ++corner; // it is one of the three
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

// Whether half-edges that were not paired run between the same two points: OpenMesh knows one edge there, and would pair them or
// refuse a face. Only an edge that was taken apart, or a point of several vertices, can cause that.
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
    if (pairing.nonmanifold[h] || is_mixed[from] || is_mixed[to]) doubtful.push_back(h);
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

// Among several points of one vertex the widest answers for it.
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
    if (gain > 0 || (gain == 0 && point < chosen)) chosen = point;
  }
}

void answer_vertices(const Triangles &triangles, const std::vector<int32_t> &welded, HalfEdges &result) {
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
    result.nonmanifold_vertices += is_split_position[welded[vertex]]++ == 0;
  }
  if (result.nonmanifold_vertices > 0) choose_widest(triangles, is_split, result);
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
  const std::vector<int32_t> welded = weld(triangles.positions);
  checkpoint();
  const Pairing pairing = pair_half_edges(triangles, welded, left_out);
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
    answer_vertices(triangles, welded, result);
  });
  return result;
}

Box bounding_box(const Triangles &triangles, const HalfEdges &half_edges, int threads) {
  constexpr int block = 65536;
  if (half_edges.point_vertex.empty()) return {};
  const vec3 first = triangles.positions[half_edges.point_vertex.front()];
  const auto count = static_cast<int>(half_edges.point_vertex.size());
  std::vector<std::pair<vec3, vec3>> parts(static_cast<size_t>(Blocks{count, block}.number()), {first, first});
  parallel_blocks(count, threads, block, [&](int begin, int end) {
    auto &[low, high] = parts[begin / block];
    for (int i = begin; i < end; ++i) {
      const vec3 position = triangles.positions[half_edges.point_vertex[i]];
      low = glm::min(low, position);
      high = glm::max(high, position);
    }
  });
  vec3 lowest = first, highest = first;
  for (const auto &[low, high] : parts) {
    lowest = glm::min(lowest, low);
    highest = glm::max(highest, high);
  }
  return {dvec3(lowest), dvec3(highest)};
}

} // namespace paradesc
