// Triangles → charts (blocks of the domain, made connected) → flat corners → a random similarity of each chart into its cell.
#include "support/layout.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>

#include "support/triangulation.h"

namespace paradesc::test {
namespace {

constexpr double pi = 3.14159265358979323846;
constexpr double same_position = 1e-9; // of the domain: rounding in the two ways to one position

struct Vec2 {
  double x = 0, y = 0;
};
Vec2 operator+(Vec2 a, Vec2 b) { return {a.x + b.x, a.y + b.y}; }
Vec2 operator-(Vec2 a, Vec2 b) { return {a.x - b.x, a.y - b.y}; }
Vec2 operator*(double s, Vec2 a) { return {s * a.x, s * a.y}; }
bool agree(Vec2 a, Vec2 b) { return std::abs(a.x - b.x) < same_position && std::abs(a.y - b.y) < same_position; }

// How one triangle lies in the flat: its chart, and which period of the rectangle or which face of the cube it is seen in.
struct Frame {
  int32_t chart = 0;
  int shift_u = 0, shift_v = 0;
  int face = 0;
};

struct Blocks {
  int u = 1, v = 1;
};

// n blocks, as square as n allows.
Blocks square_blocks(int n, double side_u, double side_v) {
  Blocks best{n, 1};
  double best_skew = std::numeric_limits<double>::infinity();
  for (int u = 1; u <= n; ++u) {
    if (n % u != 0) continue;
    const double skew = std::abs(std::log((side_u / u) / (side_v * u / n)));
    if (skew < best_skew) {
      best_skew = skew;
      best = {u, n / u};
    }
  }
  return best;
}

// ---- Rectangle

double unwrapped(double x, double near, bool periodic) { return periodic ? x - std::round(x - near) : x; }

// Parameters of a triangle's corners, together even where they lie across the period's end.
std::array<Vec2, 3> corner_parameters(const TestMesh &mesh, int32_t t) {
  std::array<Vec2, 3> p;
  for (size_t i = 0; i < 3; ++i) {
    const Vec3 q = mesh.parameters[static_cast<size_t>(mesh.corner_vertices[static_cast<size_t>(3 * t) + i])];
    p[i] = i == 0 ? Vec2{q.x, q.y} : Vec2{unwrapped(q.x, p[0].x, mesh.periodic_u), unwrapped(q.y, p[0].y, mesh.periodic_v)};
  }
  return p;
}

Frame rectangle_frame(const TestMesh &mesh, int32_t t, Blocks blocks, double offset) {
  const std::array<Vec2, 3> p = corner_parameters(mesh, t);
  const Vec2 center = (1.0 / 3) * (p[0] + p[1] + p[2]);
  Frame frame;
  const double u = center.x + offset / blocks.u, v = center.y + offset / blocks.v;
  if (mesh.periodic_u) frame.shift_u = -static_cast<int>(std::floor(u));
  if (mesh.periodic_v) frame.shift_v = -static_cast<int>(std::floor(v));
  const int column = std::clamp(static_cast<int>(std::floor((u + frame.shift_u) * blocks.u)), 0, blocks.u - 1);
  const int row = std::clamp(static_cast<int>(std::floor((v + frame.shift_v) * blocks.v)), 0, blocks.v - 1);
  frame.chart = row * blocks.u + column;
  return frame;
}

// ---- Cube around the sphere

// The face's plane laid flat: where the cube's axes and the face's center go. Net faces share edges.
struct FlatFace {
  Vec2 center;
  std::array<Vec2, 3> axis; // image of each axis; unused for the face's own
};

struct Cube {
  Rotation turn;                // of directions before they meet the cube's faces
  Vec3 half;                    // of its sides
  std::array<FlatFace, 6> face; // 2 * axis + (1: negative side)
};

FlatFace upright(int face) {
  const size_t axis = static_cast<size_t>(face / 2);
  FlatFace flat;
  flat.axis[(axis + 1) % 3] = {face % 2 ? -1.0 : 1.0, 0};
  flat.axis[(axis + 2) % 3] = {0, 1};
  return flat;
}

// The face on the side of direction (an axis and a sign) of an unfolded face, unfolded into the same plane.
FlatFace unfold(const Cube &cube, int from, int to) {
  const FlatFace &near = cube.face[static_cast<size_t>(from)];
  const int from_axis = from / 2, to_axis = to / 2, third = 3 - from_axis - to_axis;
  const Vec2 direction = (to % 2 ? -1.0 : 1.0) * near.axis[static_cast<size_t>(to_axis)];
  FlatFace far;
  far.center = near.center + (cube.half[to_axis] + cube.half[from_axis]) * direction;
  far.axis[static_cast<size_t>(from_axis)] = (from % 2 ? 1.0 : -1.0) * direction; // away from the near face
  far.axis[static_cast<size_t>(third)] = near.axis[static_cast<size_t>(third)];
  return far;
}

Cube cube_around(const TestMesh &mesh, const Layout &layout) {
  Cube cube;
  const bool net = layout.charts == 1;
  if (layout.offset > 0 && !net) cube.turn = rotation_about({1, 2, 3}, layout.offset * pi / 2);
  const auto half = [&](Vec3 row) { return length({row.x * mesh.lengths.x, row.y * mesh.lengths.y, row.z * mesh.lengths.z}); };
  cube.half = {half(cube.turn.x), half(cube.turn.y), half(cube.turn.z)};
  for (int face = 0; face < 6; ++face) cube.face[static_cast<size_t>(face)] = upright(face);
  if (!net) return cube;
  const int root = 2 * static_cast<int>(std::lround(layout.offset * 4)); // another cross, other seams
  const int root_axis = root / 2;
  for (int side = 0; side < 4; ++side) {
    const int face = 2 * ((root_axis + 1 + side / 2) % 3) + side % 2;
    cube.face[static_cast<size_t>(face)] = unfold(cube, root, face);
  }
  const int arm = 2 * ((root_axis + 1) % 3);
  cube.face[static_cast<size_t>(root + 1)] = unfold(cube, arm, root + 1);
  return cube;
}

// The position at which a direction meets the face: within it in [-1, 1] along each side, outside a little beyond.
Vec3 face_angles(const Cube &cube, int face, Vec3 direction) {
  const Vec3 d = cube.turn(direction);
  const double depth = std::abs(d[face / 2]);
  return {4 / pi * std::atan(d.x / depth), 4 / pi * std::atan(d.y / depth), 4 / pi * std::atan(d.z / depth)};
}

int facing(const Cube &cube, Vec3 direction) {
  const Vec3 d = cube.turn(direction);
  int axis = 0;
  for (int i = 1; i < 3; ++i)
    if (std::abs(d[i]) > std::abs(d[axis])) axis = i;
  return 2 * axis + (d[axis] < 0);
}

Frame sphere_frame(const TestMesh &mesh, int32_t t, const Cube &cube, int charts) {
  Vec3 center;
  for (int i = 0; i < 3; ++i)
    center = center + mesh.parameters[static_cast<size_t>(mesh.corner_vertices[static_cast<size_t>(3 * t + i)])];
  Frame frame;
  frame.face = cube.turn.x.x == 1 ? mesh.triangle_patch[static_cast<size_t>(t)] : facing(cube, center);
  if (charts == 1) return frame;
  // The first faces take one block more where 6 does not divide the number of charts.
  const int each = charts / 6, spare = charts % 6, here = each + (frame.face < spare), axis = frame.face / 2;
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  const Blocks blocks = square_blocks(std::max(here, 1), cube.half[u], cube.half[v]);
  const Vec3 angles = face_angles(cube, frame.face, center);
  const int column = std::clamp(static_cast<int>((angles[u] + 1) / 2 * blocks.u), 0, blocks.u - 1);
  const int row = std::clamp(static_cast<int>((angles[v] + 1) / 2 * blocks.v), 0, blocks.v - 1);
  frame.chart = each * frame.face + std::min(frame.face, spare) + row * blocks.u + column;
  return frame;
}

// ---- Flattening

struct Flattening {
  const TestMesh &mesh;
  Cube cube;
  std::vector<Frame> frames; // (triangle_count)

  Vec2 corner(int32_t t, size_t i) const { return corner(t, i, frames[static_cast<size_t>(t)]); }
  Vec2 corner(int32_t t, size_t i, const Frame &frame) const {
    if (mesh.domain == Domain::rectangle) {
      const Vec2 p = corner_parameters(mesh, t)[i];
      return {(p.x + frame.shift_u) * mesh.lengths.x, (p.y + frame.shift_v) * mesh.lengths.y};
    }
    const Vec3 direction = mesh.parameters[static_cast<size_t>(mesh.corner_vertices[static_cast<size_t>(3 * t) + i])];
    const Vec3 angles = face_angles(cube, frame.face, direction);
    const FlatFace &flat = cube.face[static_cast<size_t>(frame.face)];
    Vec2 position = flat.center;
    for (int axis = 0; axis < 3; ++axis)
      if (axis != frame.face / 2) position = position + (cube.half[axis] * angles[axis]) * flat.axis[static_cast<size_t>(axis)];
    return position;
  }
  Vec2 vertex_in(int32_t t, int32_t vertex, const Frame &frame) const {
    for (size_t i = 0; i < 3; ++i)
      if (mesh.corner_vertices[static_cast<size_t>(3 * t) + i] == vertex) return corner(t, i, frame);
    return {};
  }
  bool joined(const MeshEdge &edge, const Frame &a, const Frame &b) const {
    return a.chart == b.chart && agree(vertex_in(edge.triangle_a, edge.low, a), vertex_in(edge.triangle_b, edge.low, b)) &&
           agree(vertex_in(edge.triangle_a, edge.high, a), vertex_in(edge.triangle_b, edge.high, b));
  }
  // The neighbor's frame as seen from triangle t across the edge.
  Frame carried(const MeshEdge &edge, int32_t t, int32_t neighbor) const {
    Frame frame = frames[static_cast<size_t>(neighbor)];
    if (mesh.domain == Domain::sphere) return frame;
    const Vec2 there = vertex_in(neighbor, edge.low, frame);
    frame.shift_u = frame.shift_v = 0;
    const Vec2 here = vertex_in(t, edge.low, frame);
    frame.shift_u = static_cast<int>(std::lround((there.x - here.x) / mesh.lengths.x));
    frame.shift_v = static_cast<int>(std::lround((there.y - here.y) / mesh.lengths.y));
    return frame;
  }
};

int32_t root_of(std::vector<int32_t> &parent, int32_t t) {
  while (parent[static_cast<size_t>(t)] != t) {
    parent[static_cast<size_t>(t)] = parent[static_cast<size_t>(parent[static_cast<size_t>(t)])];
    t = parent[static_cast<size_t>(t)];
  }
  return t;
}

// 1 for triangles that do not hang together with the largest part of their chart.
std::vector<uint8_t> stray_triangles(const Flattening &flat, const std::vector<MeshEdge> &edges) {
  std::vector<int32_t> parent(flat.frames.size()), size(flat.frames.size(), 0);
  for (size_t t = 0; t < parent.size(); ++t) parent[t] = static_cast<int32_t>(t);
  for (const MeshEdge &edge : edges) {
    if (edge.triangle_b < 0) continue;
    if (flat.joined(edge, flat.frames[static_cast<size_t>(edge.triangle_a)], flat.frames[static_cast<size_t>(edge.triangle_b)]))
      parent[static_cast<size_t>(root_of(parent, edge.triangle_a))] = root_of(parent, edge.triangle_b);
  }
  std::map<int32_t, int32_t> largest; // chart → root
  for (size_t t = 0; t < parent.size(); ++t) ++size[static_cast<size_t>(root_of(parent, static_cast<int32_t>(t)))];
  for (size_t t = 0; t < parent.size(); ++t) {
    const auto [found, is_new] = largest.try_emplace(flat.frames[t].chart, static_cast<int32_t>(t));
    if (size[t] > size[static_cast<size_t>(found->second)]) found->second = static_cast<int32_t>(t);
  }
  std::vector<uint8_t> stray(parent.size());
  for (size_t t = 0; t < parent.size(); ++t)
    stray[t] = root_of(parent, static_cast<int32_t>(t)) != root_of(parent, largest[flat.frames[t].chart]);
  return stray;
}

// Block borders cut an irregular triangulation into blocks and a few crumbs: give those to a neighbor.
void adopt_strays(Flattening &flat, const std::vector<MeshEdge> &edges) {
  std::vector<uint8_t> stray = stray_triangles(flat, edges);
  for (bool changed = true; changed;) {
    changed = false;
    for (const MeshEdge &edge : edges) {
      if (edge.triangle_b < 0 || stray[static_cast<size_t>(edge.triangle_a)] == stray[static_cast<size_t>(edge.triangle_b)])
        continue;
      const bool a_strays = stray[static_cast<size_t>(edge.triangle_a)];
      const int32_t t = a_strays ? edge.triangle_a : edge.triangle_b, neighbor = a_strays ? edge.triangle_b : edge.triangle_a;
      flat.frames[static_cast<size_t>(t)] = flat.carried(edge, t, neighbor);
      stray[static_cast<size_t>(t)] = 0;
      changed = true;
    }
  }
}

// ---- Placing

struct Box {
  Vec2 low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  Vec2 high{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  void add(Vec2 p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
};

// Warp, stretch, mirror and turn the corners of one chart, then fit them into the cell.
void lay_out_chart(std::vector<Vec2> &corners, const std::vector<size_t> &members, const Layout &layout, int32_t chart,
                   Box cell) {
  Random random(layout.seed * 7919u + static_cast<uint32_t>(chart));
  const double stretch_angle = random.uniform(0, pi), angle = random.uniform(0, 2 * pi);
  const double phase_x = random.uniform(0, 2 * pi), phase_y = random.uniform(0, 2 * pi);
  const double shrink = random.uniform(layout.smallest_scale, 1);
  Box box;
  for (const size_t c : members) box.add(corners[c]);
  const double wave = 2 * pi / std::max(box.high.x - box.low.x, box.high.y - box.low.y);
  const double cs = std::cos(stretch_angle), ss = std::sin(stretch_angle);
  const double turn = layout.rotate ? angle : 0, ct = std::cos(turn), st = std::sin(turn);
  Box turned;
  for (const size_t c : members) {
    Vec2 p = corners[c] - box.low;
    p = p + (layout.warp / wave) * Vec2{std::sin(wave * p.y + phase_x), std::sin(wave * p.x + phase_y)};
    const double along = (layout.anisotropy - 1) * (cs * p.x + ss * p.y);
    p = p + along * Vec2{cs, ss};
    if (layout.mirror && chart % 3 == 1) p.x = -p.x;
    corners[c] = {ct * p.x - st * p.y, st * p.x + ct * p.y};
    turned.add(corners[c]);
  }
  const Vec2 size = turned.high - turned.low, room = cell.high - cell.low - Vec2{2 * layout.gutter, 2 * layout.gutter};
  const double scale = std::min(room.x / size.x, room.y / size.y) * (layout.charts == 1 ? 1 : shrink);
  const Vec2 middle = 0.5 * (turned.low + turned.high), center = 0.5 * (cell.low + cell.high);
  for (const size_t c : members) corners[c] = center + scale * (corners[c] - middle);
}

} // namespace

void lay_out(TestMesh &mesh, const Layout &layout) {
  Flattening flat{mesh, mesh.domain == Domain::sphere ? cube_around(mesh, layout) : Cube{}, {}};
  const Blocks blocks = square_blocks(layout.charts, mesh.lengths.x, mesh.lengths.y);
  for (int32_t t = 0; t < mesh.triangle_count(); ++t)
    flat.frames.push_back(mesh.domain == Domain::sphere ? sphere_frame(mesh, t, flat.cube, layout.charts)
                                                        : rectangle_frame(mesh, t, blocks, layout.offset));
  adopt_strays(flat, mesh_edges(mesh));

  std::vector<Vec2> corners(mesh.corner_vertices.size());
  std::vector<std::vector<size_t>> members(static_cast<size_t>(layout.charts));
  std::map<std::pair<int32_t, int32_t>, std::vector<Vec2>>
      positions_of; // (chart, vertex): makes corners at one position equal to the bit
  mesh.triangle_chart.clear();
  for (int32_t t = 0; t < mesh.triangle_count(); ++t) {
    const int32_t chart = flat.frames[static_cast<size_t>(t)].chart;
    mesh.triangle_chart.push_back(chart);
    for (size_t i = 0; i < 3; ++i) {
      const size_t c = static_cast<size_t>(3 * t) + i;
      corners[c] = flat.corner(t, i);
      std::vector<Vec2> &known = positions_of[{chart, mesh.corner_vertices[c]}];
      const auto found = std::find_if(known.begin(), known.end(), [&](Vec2 p) { return agree(p, corners[c]); });
      if (found == known.end())
        known.push_back(corners[c]);
      else
        corners[c] = *found;
      members[static_cast<size_t>(chart)].push_back(c);
    }
  }
  const int columns = static_cast<int>(std::ceil(std::sqrt(layout.charts))), rows = (layout.charts + columns - 1) / columns;
  for (int32_t chart = 0; chart < layout.charts; ++chart) {
    const double x = chart % columns, y = chart / columns;
    const Box cell{{x / columns, y / rows}, {(x + 1) / columns, (y + 1) / rows}};
    if (!members[static_cast<size_t>(chart)].empty())
      lay_out_chart(corners, members[static_cast<size_t>(chart)], layout, chart, cell);
  }
  mesh.corner_uvs.clear();
  for (const Vec2 p : corners) {
    mesh.corner_uvs.push_back(static_cast<float>(p.x));
    mesh.corner_uvs.push_back(static_cast<float>(p.y));
  }
}

SplitMesh split_at_seams(const TestMesh &mesh) {
  SplitMesh split;
  split.mesh = mesh;
  std::vector<std::map<std::array<float, 2>, int32_t>> copies(mesh.points.size());
  for (size_t c = 0; c < mesh.corner_vertices.size(); ++c) {
    const int32_t vertex = mesh.corner_vertices[c];
    const auto [found, is_new] = copies[static_cast<size_t>(vertex)].try_emplace(
        {mesh.corner_uvs[2 * c], mesh.corner_uvs[2 * c + 1]}, static_cast<int32_t>(split.origin.size()));
    if (is_new) split.origin.push_back(vertex);
    split.mesh.corner_vertices[c] = found->second;
  }
  const auto spread = [&](auto &values) {
    const auto old = values;
    values.clear();
    for (const int32_t v : split.origin) values.push_back(old[static_cast<size_t>(v)]);
  };
  for (auto *values : {&split.mesh.points, &split.mesh.normals, &split.mesh.parameters}) spread(*values);
  for (auto *values : {&split.mesh.H, &split.mesh.K, &split.mesh.k1, &split.mesh.k2, &split.mesh.boundary_distance})
    spread(*values);
  split.mesh.vertex_count = static_cast<int32_t>(split.origin.size());
  round_to_float(split.mesh);
  return split;
}

std::vector<uint8_t> near_seam(const TestMesh &mesh, double r) {
  std::vector<std::array<float, 2>> first(mesh.points.size(), {-1, -1});
  std::vector<uint8_t> on_seam(mesh.points.size(), 0);
  for (size_t c = 0; c < mesh.corner_vertices.size(); ++c) {
    const size_t v = static_cast<size_t>(mesh.corner_vertices[c]);
    const std::array<float, 2> uv{mesh.corner_uvs[2 * c], mesh.corner_uvs[2 * c + 1]};
    if (first[v][0] == -1)
      first[v] = uv;
    else if (first[v] != uv)
      on_seam[v] = 1;
  }
  std::map<std::array<int, 3>, std::vector<size_t>> grid; // cells of side r
  const auto cell_of = [&](Vec3 p) {
    return std::array{static_cast<int>(std::floor(p.x / r)), static_cast<int>(std::floor(p.y / r)),
                      static_cast<int>(std::floor(p.z / r))};
  };
  for (size_t v = 0; v < on_seam.size(); ++v)
    if (on_seam[v]) grid[cell_of(mesh.points[v])].push_back(v);
  std::vector<uint8_t> near = on_seam;
  for (size_t v = 0; v < near.size(); ++v)
    for (int neighbor = 0; neighbor < 27 && !near[v]; ++neighbor) {
      const std::array<int, 3> c = cell_of(mesh.points[v]);
      const auto found = grid.find({c[0] + neighbor % 3 - 1, c[1] + neighbor / 3 % 3 - 1, c[2] + neighbor / 9 - 1});
      if (found == grid.end()) continue;
      for (const size_t s : found->second) near[v] = near[v] || length(mesh.points[v] - mesh.points[s]) <= r;
    }
  return near;
}

} // namespace paradesc::test
