// Artists' and scanners' meshes, vertex by vertex: texture space (software) against object space (reference). Means hide what
// goes wrong at few vertices, so the largest errors are held too, where the surface within the ball is like a disk, is ambiguous
// (folded or thin), or hits a boundary.
#include <algorithm>
#include <cmath>
#include <iostream>
#include <numbers>
#include <numeric>

#include <gtest/gtest.h>

#include "support/oracle.h"
#include "support/percent_ae.h"
#include "support/real_mesh.h"
#include "support/run.h"

namespace paradesc::test {
namespace {

// Families of descriptors with errors alike: curvatures come from normals, volumes from heights, the area from the rim. Bending
// energy and the area along the surface see the angle at a crease over its distance, which no sample has as it is.
enum Family { curvature, volume, area, crease, families };
enum Kind { disk_like, ambiguous, at_boundary, kinds };
constexpr const char *family_names[] = {"curvature", "volume", "area", "crease"},
                     *kind_names[] = {"disk-like", "ambiguous", "at boundary"};

Family family_of(const std::string &name) {
  if (name.starts_with("sphere_volume") || name == "ambient_openness") return volume;
  if (name == "euclidean_area") return area;
  return name == "geodesic_area" || name == "local_bending_energy" ? crease : curvature;
}

// Largest over a family: % of the descriptor's range over the vertices, of areas % of the disk's.
struct Errors {
  double mean = 0, p99 = 0, max = 0;
};

// Errors that are allowed: about 1.5 times those of llvmpipe of Mesa 22.3 on 2026-11-22. Where normals are the mean of faces by
// their areas, at edges that nobody has marked, they turn more from vertex to vertex than Max's: the largest of pirate and beast
// are those of 2026-11-26.
struct Case {
  const char *mesh;
  double radius;
  size_t vertices;   // of the oracle
  size_t undefined;  // of these, on one side only
  size_t boundaries; // seen by one only
  Errors allowed[kinds][families];
};

void PrintTo(const Case &one, std::ostream *out) { *out << one.mesh << " at " << one.radius; }

std::string case_name(const ::testing::TestParamInfo<Case> &one) {
  std::string name = one.param.mesh;
  std::ranges::replace(name, '-', '_');
  return name + "_at_" + std::to_string(std::lround(100 * one.param.radius)) + "_percent";
}

class RealMeshes : public ::testing::TestWithParam<Case> {
protected:
  void SetUp() override {
    std::string why_not;
    software = open_context(device_backend(), why_not);
    if (!software) GTEST_SKIP() << why_not;
    names = descriptors_of_devices();
    std::erase_if(names, [](const std::string &name) { return components_of(name) != 1 || map_degree_of(name) > 0; });
  }

  // The vertices of one kind, decided by the oracle alone, where both have all values. A disk's area is pi r^2; folds and thin
  // parts have another.
  static std::vector<uint8_t> where(const Oracle &oracle, const std::vector<uint8_t> &compared, double disk, Kind wanted) {
    std::vector<uint8_t> subset;
    for (size_t i = 0; i < oracle.boundary.size(); ++i) {
      const double share = oracle["euclidean_area"][i] / disk;
      const Kind kind = oracle.boundary[i] ? at_boundary : share > 1.15 || share < 0.85 ? ambiguous : disk_like;
      subset.push_back(compared[i] && kind == wanted);
    }
    return subset;
  }

  Context software;
  std::vector<std::string> names;
};

TEST_P(RealMeshes, agree_with_the_oracle_at_every_vertex) {
  const Case &test_case = GetParam();
  PDESC_REAL_MESH(mesh, test_case.mesh);
  const Settings settings{.radius = test_case.radius, .creases = PDESC_CREASES_NONE}; // the oracle knows smooth surfaces alone
  const Results fast = compute(software.get(), mesh, settings, names);
  std::vector<int32_t> vertices(static_cast<size_t>(mesh.vertex_count));
  std::iota(vertices.begin(), vertices.end(), 0);
  vertices = some_of(vertices, test_case.vertices);
  const Oracle oracle = ask_oracle(mesh, fast.report.radius, settings, vertices, names);
  const double disk = std::numbers::pi * fast.report.radius * fast.report.radius;
  std::vector<uint8_t> compared(vertices.size(), 1);
  for (const std::string &name : names)
    for (size_t i = 0; i < vertices.size(); ++i)
      if (std::isnan(fast[name][static_cast<size_t>(vertices[i])]) != std::isnan(oracle[name][i])) compared[i] = 0;
  EXPECT_LE(static_cast<size_t>(std::ranges::count(compared, 0)), test_case.undefined);
  for (const Kind kind : {disk_like, ambiguous, at_boundary}) {
    const std::vector<uint8_t> subset = where(oracle, compared, disk, kind);
    Errors worst[families];
    for (const std::string &name : names) {
      const Family family = family_of(name);
      const PercentAe error = percent_ae(pick(fast[name], vertices), oracle[name], subset);
      const double unit = name.ends_with("_area") ? error.range / disk : 1;
      Errors &largest = worst[family];
      largest = {std::max(largest.mean, unit * error.mean), std::max(largest.p99, unit * error.p99),
                 std::max(largest.max, unit * error.max)};
    }
    std::cout << kind_names[kind] << ", " << std::ranges::count(subset, 1) << " vertices:";
    for (int family = 0; family < families; ++family) {
      const Errors &found = worst[family], &allowed = test_case.allowed[kind][family];
      std::cout << "  " << family_names[family] << " {" << found.mean << ", " << found.p99 << ", " << found.max << "}";
      EXPECT_LE(found.mean, allowed.mean) << kind_names[kind] << ", " << family_names[family];
      EXPECT_LE(found.p99, allowed.p99) << kind_names[kind] << ", " << family_names[family];
      EXPECT_LE(found.max, allowed.max) << kind_names[kind] << ", " << family_names[family];
    }
    std::cout << "\n";
  }
  // Both say that a boundary is near, but for a sample's distance; and of the centers of a real map none is missing.
  size_t other = 0;
  for (size_t i = 0; i < vertices.size(); ++i)
    other += ((fast.mask[static_cast<size_t>(vertices[i])] & PDESC_MASK_BOUNDARY) != 0) != (oracle.boundary[i] != 0);
  std::cout << std::ranges::count(compared, 0) << " defined and " << other << " boundaries seen on one side only\n";
  EXPECT_LE(other, test_case.boundaries);
  EXPECT_GT(fast.report.coverage_mean, 0.999);
  EXPECT_LE(fast.report.low_coverage_vertices,
            2); // the two corners of a flap of the beast, which is doubled and smaller than a texel
  EXPECT_LE(fast.report.undefined_vertices, 2);
}

const Case cases[] = {
    {"pirate",
     0.02,
     3000,
     0,
     4,
     {{{0.21, 2.1, 15}, {0.43, 2.2, 3.4}, {0.7, 3.8, 6.6}, {0.79, 13, 28}},
      {{0.46, 5.1, 22}, {0.58, 3.4, 7.9}, {1, 5.6, 9.2}, {1.6, 14, 31}},
      {{0.18, 2.1, 19}, {0.16, 0.88, 2.4}, {0.27, 1.5, 8.6}, {2, 52, 120}}}},
    {"human",
     0.02,
     12000,
     0,
     254,
     {{{0.16, 1.9, 29}, {0.25, 1.8, 5.3}, {0.38, 3, 11}, {0.58, 5.3, 64}},
      {{0.43, 4.5, 22}, {0.37, 3.1, 8.1}, {0.83, 6, 8.9}, {1.4, 12, 250}},
      {{1.2, 7.4, 17}, {0.49, 1.8, 3.6}, {1.1, 5.7, 8.9}, {7, 110, 190}}}},
    {"stanford-bunny",
     0.02,
     2000,
     0,
     0,
     {{{0.13, 1.1, 10}, {0.26, 3.2, 5}, {0.24, 1.7, 5.8}, {0.25, 2.7, 15}},
      {{0.61, 1.9, 2}, {2.3, 7.3, 8.1}, {2.4, 5, 5}, {4, 17, 17}},
      {{0.13, 1.1, 1.2}, {0.072, 0.35, 0.49}, {0.18, 0.7, 0.81}, {0.18, 1.3, 2.2}}}},
    {"beast",
     0.02,
     2000,
     0,
     0,
     {{{0.22, 3.4, 28}, {0.41, 2.3, 4.1}, {0.56, 4, 13}, {0.63, 4.6, 67}},
      {{1.1, 24, 54}, {0.55, 4.1, 9.2}, {2, 18, 21}, {4.9, 77, 310}},
      {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}}}},
    {"beast",
     0.05,
     1000,
     0,
     0,
     {{{0.49, 5.8, 29}, {0.54, 3.1, 3.7}, {1.1, 4.9, 8.9}, {1.6, 30, 110}},
      {{0.55, 8.7, 38}, {0.62, 4.6, 7.7}, {1.3, 6.8, 12}, {3.4, 57, 130}},
      {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}}}},
};
INSTANTIATE_TEST_SUITE_P(, RealMeshes, ::testing::ValuesIn(cases), case_name);

} // namespace
} // namespace paradesc::test
