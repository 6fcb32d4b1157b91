// Walks over the rings of fans, ring after ring.
#include "mesh/normal_rings.h"

#include <algorithm>
#include <span>
#include <utility>

#include "mesh/jets.h"
#include "support/parallel.h"

namespace paradesc {
namespace {

constexpr int enough_neighbors = 14; // a jet of order 3 has nine coefficients; two whole rings have 18 on average
constexpr int max_rings = 3;
constexpr int run_length = 8192; // of fans
constexpr int max_corners = 32;  // of one fan that are visited, so that fans of thousands of faces do not cost quadratic time

// Walks the rings of one fan after another. Stamps mark what a walk has met, and are kept as long as the walker.
class RingWalker {
public:
  RingWalker(const HalfEdges &half_edges, const NormalRings &rings, const FanCorners &fans)
      : half_edges_(half_edges), rings_(rings), fans_(fans), fan_stamp_(static_cast<size_t>(rings.fan_count), -1),
        point_stamp_(static_cast<size_t>(half_edges.point_count), -1), face_stamp_(rings.corner_fan->size() / 3, -1) {}

  // Appends the fan's neighbors and faces to these arrays.
  void walk(int fan, std::vector<int32_t> &vertices, std::vector<int32_t> &faces) {
    const size_t begin = vertices.size();
    fan_ = fan;
    fan_stamp_[fan] = fan;
    point_stamp_[rings_.fan_point[fan]] = fan;
    for (const int corner : corners(fan)) take_face(corner / 3, faces);
    front_.assign(1, fan);
    for (int ring = 0; ring < max_rings && !front_.empty(); ++ring) {
      const size_t found = vertices.size() - begin;
      if ((ring >= 2 && found >= enough_neighbors) || found >= max_neighbors) break;
      next_front_.clear();
      for (const int member : front_) take_fan(member, vertices, faces);
      std::swap(front_, next_front_);
    }
    if (vertices.size() - begin > max_neighbors) vertices.resize(begin + max_neighbors);
  }

private:
  std::span<const int32_t> corners(int fan) const {
    const auto begin = static_cast<size_t>(fans_.begin[fan]);
    const auto end = static_cast<size_t>(fans_.begin[fan + 1]);
    return {fans_.corner.data() + begin, end - begin};
  }

  void take_fan(int member, std::vector<int32_t> &vertices, std::vector<int32_t> &faces) {
    const auto all = corners(member);
    const size_t step = (all.size() + max_corners - 1) / max_corners;
    for (size_t i = 0; i < all.size(); i += step) {
      take_face(all[i] / 3, faces);
      take_corner(next_corner(all[i]), vertices);
      take_corner(previous_corner(all[i]), vertices);
    }
  }

  void take_face(int face, std::vector<int32_t> &faces) {
    if (std::exchange(face_stamp_[face], fan_) != fan_) faces.push_back(face);
  }

  void take_corner(int corner, std::vector<int32_t> &vertices) {
    const int other = (*rings_.corner_fan)[corner];
    if (std::exchange(fan_stamp_[other], fan_) == fan_) return;
    next_front_.push_back(other);
    const auto point = static_cast<size_t>(half_edges_.corner_point[corner]);
    if (std::exchange(point_stamp_[point], fan_) != fan_) vertices.push_back(half_edges_.point_vertex[point]);
  }

  const HalfEdges &half_edges_;
  const NormalRings &rings_;
  const FanCorners &fans_;
  int fan_ = -1;
  std::vector<int32_t> fan_stamp_, point_stamp_, face_stamp_, front_, next_front_;
};

RingRun walk_run(RingWalker &walker, int begin, int end) {
  RingRun run;
  run.first_fan = begin;
  for (int fan = begin; fan < end; ++fan) {
    const size_t vertices = run.vertices.size(), faces = run.faces.size();
    walker.walk(fan, run.vertices, run.faces);
    run.ring_size.push_back(static_cast<int32_t>(run.vertices.size() - vertices));
    run.face_size.push_back(static_cast<int32_t>(run.faces.size() - faces));
  }
  return run;
}

void append(const std::vector<int32_t> &from, std::vector<int32_t> &to) { to.insert(to.end(), from.begin(), from.end()); }

// Frees each run as soon as it is copied, because rings take more memory than the mesh.
void join_runs(std::vector<RingRun> &runs, NormalRings &rings) {
  size_t vertices = 0, faces = 0;
  for (const RingRun &run : runs) {
    vertices += run.vertices.size();
    faces += run.faces.size();
  }
  rings.ring_vertex.reserve(vertices);
  rings.face.reserve(faces);
  for (auto *begins : {&rings.ring_begin, &rings.face_begin}) {
    begins->reserve(static_cast<size_t>(rings.fan_count) + 1);
    begins->push_back(0);
  }
  for (RingRun &run : runs) {
    checkpoint();
    append_begins(run.ring_size, rings.ring_begin);
    append_begins(run.face_size, rings.face_begin);
    append(run.vertices, rings.ring_vertex);
    append(run.faces, rings.face);
    run = {};
  }
}

} // namespace

void append_begins(const std::vector<int32_t> &sizes, std::vector<int64_t> &begins) {
  for (const int32_t size : sizes) begins.push_back(begins.back() + size);
}

FanCorners find_fans(const Triangles &triangles, const HalfEdges &half_edges, const Creases &creases, NormalRings &rings) {
  const auto vertex = [&](int32_t corner) { return triangles.corner_vertex[corner]; };
  std::vector<int32_t> link = half_edges.twin;
  std::vector<uint8_t> left_out(static_cast<size_t>(triangles.triangle_count));
  for (size_t h = 0; h < link.size(); ++h) {
    checkpoint_at(h);
    if (half_edges.corner_point[h] < 0) left_out[h / 3] = 1;
    if (creases.contains(static_cast<int32_t>(h))) link[h] = -1;
  }
  Fans traced = trace_fans(link, left_out);
  FanCorners fans;
  fans.begin.reserve(traced.first.size() + 1);
  fans.begin.push_back(0);
  fans.corner.reserve(link.size());
  rings.fan_point.reserve(traced.first.size());
  rings.fan_begin = {0};
  rings.fan_begin.reserve(traced.first.size() + 1);
  rings.fan_vertex.reserve(link.size() + 2 * traced.first.size());
  for (const int32_t first : traced.first) {
    checkpoint_at(rings.fan_point.size());
    rings.fan_vertex.push_back(vertex(first));
    rings.fan_vertex.push_back(vertex(next_corner(first)));
    for (int32_t corner = first; corner >= 0;) {
      fans.corner.push_back(corner);
      rings.fan_vertex.push_back(vertex(previous_corner(corner)));
      corner = link[previous_corner(corner)];
      if (corner == first) break;
    }
    fans.begin.push_back(static_cast<int32_t>(fans.corner.size()));
    rings.fan_begin.push_back(static_cast<int64_t>(rings.fan_vertex.size()));
    rings.fan_point.push_back(half_edges.corner_point[first]);
  }
  rings.fan_count = traced.count;
  rings.corner_fan = std::make_shared<const std::vector<int32_t>>(std::move(traced.corner_fan));
  constexpr int32_t none = -2, several = -1;
  rings.point_fan.assign(static_cast<size_t>(half_edges.point_count), none);
  for (int32_t fan = 0; fan < rings.fan_count; ++fan) {
    checkpoint_at(fan);
    int32_t &only = rings.point_fan[rings.fan_point[fan]];
    only = only == none ? fan : several;
  }
  return fans;
}

void walk_rings(const HalfEdges &half_edges, const NormalRings &rings, const FanCorners &fans, int threads,
                const std::function<void(RingRun)> &use) {
  const Blocks runs{rings.fan_count, run_length};
  // Makes one share per thread, because each walker has stamps of its own.
  const int shares = std::min(thread_count(threads), std::max(runs.number(), 1));
  parallel_blocks(shares, threads, 1, [&](int share, int) {
    const auto first_of = [&](int i) { return static_cast<int>(int64_t{runs.number()} * i / shares); };
    RingWalker walker(half_edges, rings, fans);
    for (int run = first_of(share); run < first_of(share + 1); ++run) {
      checkpoint();
      use(walk_run(walker, runs.begin(run), runs.end(run)));
    }
  });
}

NormalRings build_normal_rings(const Triangles &triangles, const HalfEdges &half_edges, int threads) {
  return build_normal_rings(triangles, half_edges, marked_creases(triangles, half_edges), threads);
}

NormalRings build_normal_rings(const Triangles &triangles, const HalfEdges &half_edges, const Creases &creases, int threads) {
  NormalRings rings;
  const FanCorners fans = find_fans(triangles, half_edges, creases, rings);
  checkpoint();
  std::vector<RingRun> runs(static_cast<size_t>(Blocks{rings.fan_count, run_length}.number()));
  walk_rings(half_edges, rings, fans, threads, [&](RingRun run) {
    run.vertices.shrink_to_fit();
    run.faces.shrink_to_fit();
    runs[run.first_fan / run_length] = std::move(run);
  });
  join_runs(runs, rings);
  return rings;
}

} // namespace paradesc
