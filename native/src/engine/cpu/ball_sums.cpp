// The sums for one instruction set. This file is compiled once for each, with LANE_WIDTH lanes and under the name KERNEL_TARGET.
#include "engine/cpu/ball_sums.h"

#include <algorithm>

#include "engine/cpu/refit_patch.h"
#include "engine/cpu/rim_sums.h"
#include "support/targets.h"

namespace paradesc::kernels {
inline namespace KERNEL_TARGET {

// ---- Nearby patches

// Returns which of sixteen spheres are within `reach` of a place.
inline uint32_t spheres_near(const SphereList &spheres, int32_t first, const Vector<3, Lanes> &place, float reach) {
  uint32_t bits = 0;
  for (int lane = 0; lane < group_lanes; lane += lane_count) {
    const int32_t i = first + lane;
    const Vector<3, Lanes> middle(load(spheres.middle[0] + i), load(spheres.middle[1] + i), load(spheres.middle[2] + i));
    const Lanes beyond = load(spheres.reach + i) + reach;
    bits |= bits_of(square_of(middle - place) < beyond * beyond) << lane;
  }
  return bits;
}

template <class Use> inline void for_each_bit(uint32_t bits, const Use &use) {
  for (; bits != 0; bits &= bits - 1) use(__builtin_ctz(bits));
}

int32_t find(const PatchArrays &surface, const CenterLanes &centers, NearPatch *patches) {
  const Vector<3, Lanes> place = all(centers.middle);
  const float reach = 1.00001f * (centers.radius + centers.spread);
  const SphereList(&levels)[3] = surface.levels;
  int32_t count = 0;
  for (int32_t top = 0; top < levels[2].count; top += group_lanes)
    for_each_bit(spheres_near(levels[2], top, place, reach), [&](int32_t k) {
      const int32_t middle = group_lanes * (top + k);
      for_each_bit(spheres_near(levels[1], middle, place, reach), [&](int32_t j) {
        const int32_t low = group_lanes * (middle + j);
        for_each_bit(spheres_near(levels[0], low, place, reach), [&](int32_t i) { patches[count++].patch = low + i; });
      });
    });
  return count;
}

// Returns the set of centers whose squared distance from a place is below `square`.
inline uint32_t centers_near(const CenterLanes &centers, const Vector<3, Lanes> &place, float square) {
  uint32_t bits = 0;
  for (int first = 0; first < group_lanes; first += lane_count)
    bits |= bits_of(square_of(load3(centers.position, first) - place) < square) << first;
  return bits;
}

inline Vector<3, Lanes> place_of(const float *const (&position)[3], int32_t i) {
  return {position[0][i], position[1][i], position[2][i]};
}

// Compares a patch with the balls. Returns false if no ball meets its triangles, including their corners in other patches.
inline bool compare(const PatchArrays &surface, const CenterLanes &centers, NearPatch &near) {
  const int32_t patch = near.patch;
  const Vector<3, Lanes> middle = place_of({surface.sphere[0], surface.sphere[1], surface.sphere[2]}, patch);
  const float reach = surface.sphere[3][patch], far = centers.radius + reach, beyond = centers.radius + surface.own_reach[patch],
              room = std::max(centers.radius - reach, 0.0f);
  Lanes squares[group_lanes / lane_count];
  const auto within = [&](float square) {
    uint32_t bits = 0;
    for (int first = 0; first < group_lanes; first += lane_count) bits |= bits_of(squares[first / lane_count] < square) << first;
    return bits;
  };
  for (int first = 0; first < group_lanes; first += lane_count)
    squares[first / lane_count] = square_of(load3(centers.position, first) - middle);
  if (within(far * far) == 0) return false;
  near.has_points = within(beyond * beyond) != 0;
  near.within = static_cast<uint16_t>(within(room * room));
  return true;
}

void look(const PatchArrays &surface, const CenterLanes &centers, NearPatches &near) {
  const float square = centers.radius * centers.radius;
  const int32_t candidates = near.patches;
  int32_t patches = 0, nodes = 0;
  for (int32_t i = 0; i < candidates; ++i) {
    NearPatch patch = near.patch[i];
    if (!compare(surface, centers, patch)) continue;
    near.patch[patches++] = patch;
    if (!patch.has_points) continue;
    for (int32_t node = surface.patch_begin[patch.patch]; node < surface.patch_begin[patch.patch + 1]; ++node) {
      const uint32_t in =
          patch.within == centers.all() ? centers.all() : centers_near(centers, place_of(surface.position, node), square);
      near.in[node] = static_cast<uint16_t>(in);
      near.node[nodes] = node;
      nodes += in != 0;
    }
  }
  near.patches = patches;
  near.nodes = nodes;
}

SphereSets sphere(const CenterLanes &centers, const float *middle, float reach) {
  const Vector<3, Lanes> place = all(middle);
  const float room = std::max(centers.radius - reach, 0.0f), beyond = centers.radius + reach;
  SphereSets sets{};
  for (int first = 0; first < group_lanes; first += lane_count) {
    const Lanes square = square_of(load3(centers.position, first) - place);
    sets.within |= bits_of(square < room * room) << first;
    sets.touched |= bits_of(square < beyond * beyond) << first;
  }
  return sets;
}

int32_t dips(const PatchArrays &surface, const CenterLanes &centers, OpenEdge *edges, int32_t count) {
  const float square = centers.radius * centers.radius;
  int32_t found = 0;
  for (int32_t i = 0; i < count; ++i) {
    OpenEdge edge = edges[i];
    const Vector<3, Lanes> a = place_of(surface.position, edge.from), way = place_of(surface.position, edge.to) - a;
    const Lanes length = square_of(way);
    uint32_t bits = 0;
    for (int first = 0; first < group_lanes; first += lane_count) {
      const Vector<3, Lanes> offset = a - load3(centers.position, first);
      const Lanes beyond = square_of(offset) - square, along = -1.0f * dot(offset, way);
      bits |= bits_of(along > 0.0f && along < length && beyond * length < along * along) << first;
    }
    edge.centers &= bits;
    edges[found] = edge;
    found += edge.centers != 0;
  }
  return found;
}

// ---- Lists

// `lists` is emptied.
void list_by_center(CenterLists &lists, int32_t centers, int32_t (&counts)[group_lanes]) {
  std::fill_n(counts, group_lanes, 0);
  for (int32_t i = lists.count; i % lane_count != 0; ++i) lists.centers[i] = 0;
  for (int32_t first = 0; first < lists.count; first += lane_count) {
    Choices::Bits items, sets;
    __builtin_memcpy(&items, lists.item + first, sizeof items);
    __builtin_memcpy(&sets, lists.centers + first, sizeof sets);
    for (int i = 0; i < centers; ++i)
      counts[i] = append(bits_of(Choices{(sets & (1 << i)) != 0}), items, lists.of_center[i], counts[i]);
  }
  lists.count = 0;
}

inline void append(const Choices::Bits &sets, const Choices::Bits &items, CenterLists &lists) {
  const uint32_t bits = bits_of(Choices{sets != 0});
  append(bits, sets, lists.centers, lists.count);
  lists.count = append(bits, items, lists.item, lists.count);
}

// Lists the triangles of a patch that have a corner in a ball, with the sets of all three corners. within: balls that contain the
// whole patch, whose triangles are not needed one by one. Entries are written one by one, and read as whole vectors only when a
// whole run of patches is complete. Loading a vector right after storing its parts would stall.
inline void list_touched(const PatchArrays &surface, int32_t patch, int32_t within, const uint16_t *reached,
                         TouchedTriangles &touched) {
  int32_t count = touched.count;
  const int32_t *corner = surface.corner + 3 * static_cast<ptrdiff_t>(surface.triangle_begin[patch]);
  for (int32_t t = surface.triangle_begin[patch]; t < surface.triangle_begin[patch + 1]; ++t, corner += 3) {
    const int32_t a = reached[corner[0]] & ~within, b = reached[corner[1]] & ~within, c = reached[corner[2]] & ~within;
    touched.triangle[count] = t;
    touched.corner[0][count] = a;
    touched.corner[1][count] = b;
    touched.corner[2][count] = c;
    touched.turning[count] = surface.turning[t];
    count += (a | b | c) != 0;
  }
  touched.count = count;
}

// A triangle with at least two corners in a ball counts as a whole there. A triangle with one or two is cut. A corner is alone on
// its side if both others differ from it. This code avoids branches, which would be unpredictable. Corners are processed in turn
// for every sixteen triangles, whatever the width.
inline void sort_triangles(GroupLists &lists) {
  constexpr int32_t row = sizeof(RimTriangle) / sizeof(float);
  TouchedTriangles &touched = lists.touched;
  for (int i = 0; i < group_lanes; ++i)
    for (int32_t *const sets : touched.corner) sets[touched.count + i] = 0;
  const auto bits = [](const int32_t *from) {
    Choices::Bits loaded;
    __builtin_memcpy(&loaded, from, sizeof loaded);
    return loaded;
  };
  for (int32_t block = 0; block < touched.count; block += group_lanes)
    for (int corner = 0; corner < 3; ++corner)
      for (int32_t first = block; first < block + group_lanes; first += lane_count) {
        const auto set = [&](int k) { return bits(touched.corner[(corner + k) % 3] + first); };
        const Choices::Bits a = set(0), b = set(1), c = set(2), triangle = bits(touched.triangle + first);
        if (corner == 0) append((a & b) | (c & (a | b)), triangle, lists.wholes);
        const Choices::Bits alone = (a ^ b) & (a ^ c), turning = bits(touched.turning + first),
                            item = row * triangle + 3 * corner;
        append(alone & ~turning, item, lists.corners);
        append(alone & turning, item, lists.turning_corners);
      }
  touched.count = 0;
}

// ---- Whole triangles

// Transposes rows of moments, four at a time.
template <size_t... k> inline void turn_rows(const MomentRow *const *rows, Lanes (&to)[moment_row], std::index_sequence<k...>) {
  const auto turn = [&](const Vector<4, Lanes> &four, size_t first) {
    to[first] = four.x;
    to[first + 1] = four.y;
    to[first + 2] = four.z;
    to[first + 3] = four.w;
  };
  (turn(gather<4 * sizeof(float) * k>(rows), 4 * k), ...);
}

// Moments about the centers: area, xx to yz, xn to yz + zy as in Moment, facets, noise.
constexpr int total_area = 0, total_xx = 1, total_xn = 7, total_facet = 13, total_noise = 14, totals = 15;
struct alignas(64) Totals {
  float sum[totals][group_lanes];
};

// Shifts moments from an origin, at d relative to the centers, to the centers, and adds them.
inline void add_moved(const Lanes (&m)[moment_row], const Vector<3, Lanes> &d, int first, Totals &to) {
  const auto add = [&](int total, const Lanes &value) { store(to.sum[total] + first, load(to.sum[total] + first) + value); };
  const Lanes &area = m[moment_area], &x = m[moment_x], &y = m[moment_x + 1], &z = m[moment_x + 2];
  const Lanes &nx = m[moment_n], &ny = m[moment_n + 1], &nz = m[moment_n + 2];
  const Lanes far_x = x + area * d.x, far_y = y + area * d.y, far_z = z + area * d.z;
  const Lanes xx[6] = {(x + far_x) * d.x,     (y + far_y) * d.y,     (z + far_z) * d.z,
                       x * d.y + far_y * d.x, x * d.z + far_z * d.x, y * d.z + far_z * d.y};
  const Lanes xn[6] = {d.x * nx, d.y * ny, d.z * nz, d.x * ny + d.y * nx, d.x * nz + d.z * nx, d.y * nz + d.z * ny};
  add(total_area, area);
  for (int k = 0; k < 6; ++k) {
    add(total_xx + k, m[moment_xx + k] + xx[k]);
    add(total_xn + k, m[moment_xn + k] + xn[k]);
  }
  add(total_facet, m[moment_facet]);
  add(total_noise, m[moment_noise]);
}

// The sum of rows, in three parts of eight floats.
struct RowSum {
  EightFloats a{}, b{}, c{};
  static EightFloats eight(const float *from) {
    EightFloats floats;
    __builtin_memcpy(&floats, from, sizeof floats);
    return floats;
  }
  void add(const MomentRow &row) {
    a += eight(row.of);
    b += eight(row.of + 8);
    c += eight(row.of + 16);
  }
};

// Adds rows to two alternating sums, so that each addition need not wait for the previous one.
inline void add_rows(const MomentRow *rows, int32_t *list, int32_t count, int32_t nothing, MomentRow &to) {
  static_assert(moment_row == 24);
  RowSum even, odd;
  list[count] = nothing;
  for (int32_t i = 0; i < count; i += 2) {
    even.add(rows[list[i]]);
    odd.add(rows[list[i + 1]]);
  }
  const EightFloats sums[] = {even.a + odd.a, even.b + odd.b, even.c + odd.c};
  __builtin_memcpy(to.of, sums, sizeof to.of);
}

// Adds the listed rows, which share one origin.
inline void add_wholes(const PatchArrays &surface, const CenterLanes &centers, int32_t patch, CenterLists &wholes, Totals &to) {
  if (wholes.count == 0) return;
  int32_t counts[group_lanes];
  list_by_center(wholes, centers.count, counts);
  MomentRow sums[group_lanes] = {};
  for (int i = 0; i < centers.count; ++i) add_rows(surface.moment, wholes.of_center[i], counts[i], surface.triangles, sums[i]);
  const Vector<3, Lanes> origin = place_of({surface.origin[0], surface.origin[1], surface.origin[2]}, patch);
  const MomentRow *rows[group_lanes];
  for (int i = 0; i < group_lanes; ++i) rows[i] = &sums[i];
  for (int first = 0; first < group_lanes; first += lane_count) {
    Lanes of_moment[moment_row];
    turn_rows(rows + first, of_moment, std::make_index_sequence<moment_row / 4>());
    add_moved(of_moment, origin - load3(centers.position, first), first, to);
  }
}

inline void add_patches(const PatchArrays &surface, const CenterLanes &centers, const NearPatches &near, GroupLists &lists,
                        Totals &to) {
  for (int32_t i = 0; i < near.patches; ++i) {
    const auto [patch, within, has_points] = near.patch[i];
    if (within != 0) { // A patch is connected, so it is reached if one of its points is.
      CenterLists &wholes = lists.wholes;
      wholes.item[wholes.count] = surface.row_of_patch(patch);
      wholes.centers[wholes.count++] = within & near.reached[surface.patch_begin[patch]];
    }
    if (within != centers.all()) {
      list_touched(surface, patch, within, near.reached, lists.touched);
      for (int32_t k = surface.cluster_begin[patch]; k < surface.cluster_begin[patch + 1]; ++k) {
        lists.wholes.item[lists.wholes.count] = surface.row_of_cluster(k);
        lists.wholes.centers[lists.wholes.count++] = near.whole[k] & ~within;
      }
    }
    const int32_t batch = patch / group_lanes;
    const bool last = i + 1 == near.patches || near.patch[i + 1].patch / group_lanes != batch || surface.apart[batch] != 0;
    if (!last) continue;
    sort_triangles(lists);
    add_wholes(surface, centers, patch, lists.wholes, to);
  }
}

// ---- Combination

struct alignas(64) Tangents {
  float t[2][3][group_lanes];
};

// The tangents are those of sums_init().
inline Tangents tangents_of(const CenterLanes &centers) {
  Tangents to;
  for (int first = 0; first < group_lanes; first += lane_count) {
    const Vector<3, Lanes> n = load3(centers.normal, first);
    const Lanes s = mix(-1.0f, 1.0f, n.z >= 0.0f), a = -1.0f / (s + n.z), b = n.x * n.y * a;
    const Lanes t[2][3] = {{1.0f + s * n.x * n.x * a, s * b, -1.0f * s * n.x}, {b, s + n.y * n.y * a, -1.0f * n.y}};
    for (int i = 0; i < 2; ++i)
      for (int axis = 0; axis < 3; ++axis) store(to.t[i][axis] + first, t[i][axis]);
  }
  return to;
}

// Projects the moments of wholes to sums in the tangent planes.
inline void project(const Totals &from, const Tangents &tangents, int first, Lanes (&sums)[ball_sums]) {
  const Vector<3, Lanes> t1 = load3(tangents.t[0], first), t2 = load3(tangents.t[1], first);
  const auto form = [&](int total, const Vector<3, Lanes> &a, const Vector<3, Lanes> &b, float mixed) {
    const auto m = [&](int k) { return load(from.sum[total + k] + first); };
    return a.x * b.x * m(0) + a.y * b.y * m(1) + a.z * b.z * m(2) +
           mixed * ((a.x * b.y + a.y * b.x) * m(3) + (a.x * b.z + a.z * b.x) * m(4) + (a.y * b.z + a.z * b.y) * m(5));
  };
  sums[0] = load(from.sum[total_area] + first);
  sums[1] = form(total_xx, t1, t1, 1.0f);
  sums[2] = form(total_xx, t1, t2, 1.0f);
  sums[3] = form(total_xx, t2, t2, 1.0f);
  sums[4] = form(total_xn, t1, t1, 0.5f);
  sums[5] = 2.0f * form(total_xn, t1, t2, 0.5f);
  sums[6] = form(total_xn, t2, t2, 0.5f);
  sums[7] = load(from.sum[total_facet] + first);
  sums[8] = load(from.sum[total_noise] + first);
}

template <bool turning>
inline void add_rims(const PatchArrays &surface, const CenterLanes &centers, const Tangents &tangents, bool with_noise,
                     CenterLists &corners, BallSums &sums) {
  int32_t counts[group_lanes];
  list_by_center(corners, centers.count, counts);
  for (int i = 0; i < centers.count; ++i) {
    if (counts[i] == 0) continue;
    const auto lane = [i](const float(&v)[3][group_lanes]) { return Vector<3, Lanes>(v[0][i], v[1][i], v[2][i]); };
    const RimCenter center{lane(centers.position), lane(tangents.t[0]), lane(tangents.t[1]), centers.radius * centers.radius};
    float of_center[ball_sums];
    (with_noise ? add_rim<turning, true> : add_rim<turning, false>)(surface, center, corners.of_center[i], counts[i], of_center);
    for (int k = 0; k < ball_sums; ++k) sums[k][i] += of_center[k];
  }
}

void add(const PatchArrays &surface, const CenterLanes &centers, const NearPatches &near, bool with_noise, GroupLists &lists,
         BallSums &sums) {
  Totals wholes = {};
  lists.touched.count = lists.wholes.count = lists.corners.count = lists.turning_corners.count = 0;
  add_patches(surface, centers, near, lists, wholes);
  const Tangents tangents = tangents_of(centers);
  alignas(64) BallSums rim = {};
  add_rims<false>(surface, centers, tangents, with_noise, lists.corners, rim);
  add_rims<true>(surface, centers, tangents, with_noise, lists.turning_corners, rim);
  const float per_radius = 1.0f / centers.radius, per_square = per_radius * per_radius;
  const float units[ball_sums] = {1.0f, per_square, per_square, per_square, per_radius, per_radius, per_radius, 1.0f, per_square};
  for (int first = 0; first < group_lanes; first += lane_count) {
    Lanes of_wholes[ball_sums];
    project(wholes, tangents, first, of_wholes);
    for (int k = 0; k < ball_sums; ++k) store(sums[k] + first, (of_wholes[k] + load(rim[k] + first)) * units[k]);
  }
}

constexpr BallTarget functions{PARADESC_TARGET_NAME, refit_spheres, refit, find, look, sphere, dips, list_by_center, add};

} // namespace KERNEL_TARGET
} // namespace paradesc::kernels

namespace paradesc {

PARADESC_TARGET(BallTarget, ball_sums_of) = kernels::functions;

} // namespace paradesc
