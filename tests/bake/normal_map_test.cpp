// A coarse mesh with the normals of a fine surface as a normal map.
#include <algorithm>

#include "bake/mapped.h"
#include "support/layout.h"
#include "support/percent_ae.h"

namespace paradesc::test {
namespace {

// ---- Normal maps

// Tangents that turn smoothly over each chart, every other one with the other sign: a normal map is whatever its tangent space
// makes of it.
std::vector<float> smooth_tangents(const TestMesh &mesh) {
  std::vector<float> tangents;
  for (size_t corner = 0; corner < mesh.corner_vertices.size(); ++corner) {
    const Vec3 n =
        normalized({mesh.corner_normals[3 * corner], mesh.corner_normals[3 * corner + 1], mesh.corner_normals[3 * corner + 2]});
    const int32_t chart = mesh.triangle_chart[corner / 3];
    const int32_t face = mesh.triangle_patch[corner / 3]; // of the cube: its normal is one of the axes
    const Vec3 axis = face / 2 == 0 ? Vec3{0, 1, 0.3} : face / 2 == 1 ? Vec3{0.3, 0, 1} : Vec3{1, 0.3, 0};
    const Vec3 t = normalized(axis - dot(axis, n) * n);
    for (int i = 0; i < 3; ++i) tangents.push_back(static_cast<float>(t[i]));
    tangents.push_back(chart % 2 ? -1.0f : 1.0f);
  }
  return tangents;
}

// Calls visit(pixel, triangle, a, b) for every pixel whose center lies in a triangle's UVs, or a pixel and a half beside it.
void each_pixel(const TestMesh &mesh, int size, const std::function<void(size_t, size_t, double, double)> &visit) {
  for (size_t triangle = 0; triangle < at(mesh.triangle_count()); ++triangle) {
    dvec2 uv[3];
    for (size_t i = 0; i < 3; ++i)
      uv[i] = dvec2(mesh.corner_uvs[6 * triangle + 2 * i], mesh.corner_uvs[6 * triangle + 2 * i + 1]) * static_cast<double>(size);
    const double area = paradesc::cross(uv[1] - uv[0], uv[2] - uv[0]);
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x) {
        const dvec2 p(x + 0.5, y + 0.5);
        double inside = 1e9, part[3];
        for (size_t i = 0; i < 3; ++i) {
          const dvec2 from = uv[(i + 1) % 3], to = uv[(i + 2) % 3];
          part[i] = paradesc::cross(to - from, p - from) / area;
          inside = std::min(inside, part[i] * std::abs(area) / glm::length(to - from));
        }
        if (inside > -1.5) visit(at(y * size + x), triangle, part[1], part[2]);
      }
  }
}

Vec3 mean(const std::vector<float> &list, size_t first, size_t step, double a, double b) {
  auto corner = [&](size_t i) { return Vec3{list[first + i * step], list[first + i * step + 1], list[first + i * step + 2]}; };
  return (1 - a - b) * corner(0) + a * corner(1) + b * corner(2);
}

// The color of a normal in the tangent space at a position on a triangle: normal = x t + y b + z n, up to its length.
Vec3 color_of(Vec3 normal, const TestMesh &mesh, const std::vector<float> &tangents, size_t triangle, double a, double b) {
  const Vec3 n = mean(mesh.corner_normals, 9 * triangle, 3, a, b), t = mean(tangents, 12 * triangle, 4, a, b);
  const Vec3 c = tangents[12 * triangle + 3] * cross(n, t);
  const double side = dot(cross(t, c), n) < 0 ? -1 : 1;
  return side * normalized({dot(cross(c, n), normal), dot(cross(n, t), normal), dot(cross(t, c), normal)});
}

// The normals of a fine surface, by a point of the coarse one.
Maps normals_of(const TestMesh &mesh, int size, const std::function<Vec3(Vec3)> &normal_at) {
  Maps maps{{}, size, size, 0, 1, std::vector<float>(at(3 * size * size), 0.5f), smooth_tangents(mesh)};
  std::vector<double> nearest(at(size * size), -1e9); // to the inside of a triangle
  each_pixel(mesh, size, [&](size_t pixel, size_t triangle, double a, double b) {
    const double inside = std::min({a, b, 1 - a - b});
    if (inside < nearest[pixel]) return;
    nearest[pixel] = inside;
    auto corner = [&](size_t i) { return mesh.points[at(mesh.corner_vertices[3 * triangle + i])]; };
    const Vec3 p = (1 - a - b) * corner(0) + a * corner(1) + b * corner(2);
    const Vec3 color = color_of(normalized(normal_at(p)), mesh, maps.tangents, triangle, a, b);
    for (int i = 0; i < 3; ++i) maps.rgb[3 * pixel + at(i)] = static_cast<float>(0.5 + 0.5 * color[i]);
  });
  return maps;
}

// Corner normals off by several degrees each way, as those of a mesh that was cut down are; the map is made in their tangent
// space.
void disturb_normals(TestMesh &mesh) {
  Random random(3);
  std::vector<Vec3> turned;
  for (const Vec3 &normal : mesh.normals)
    turned.push_back(normalized(normal + 0.1 * Vec3{random.normal(), random.normal(), random.normal()}));
  for (size_t corner = 0; corner < mesh.corner_vertices.size(); ++corner)
    for (int i = 0; i < 3; ++i)
      mesh.corner_normals[3 * corner + at(i)] = static_cast<float>(turned[at(mesh.corner_vertices[corner])][i]);
}

const Descriptors measured{"mean_curvature", "local_bending_energy"};

TEST_F(SurfaceMapsTest, a_normal_mapped_coarse_sphere_is_nearer_to_the_fine_one) {
  TestMesh mesh = sphere(1, {.vertices = 150});
  lay_out(mesh, {.charts = 6, .gutter = 8.0 / 1024});
  disturb_normals(mesh);
  const Settings settings{.radius = 0.2, .radius_unit = PDESC_RADIUS_ABSOLUTE, .normals = PDESC_NORMALS_MESH};
  const Results without = run(mesh, {}, settings, measured);
  const Results with = run(mesh, normals_of(mesh, 512, [](Vec3 p) { return p; }), settings, measured);
  for (const std::string &name : measured) {
    const std::vector<double> fine = constant(mesh.points.size(), 1.0);
    const PercentAe before = percent_ae(without[name], fine), after = percent_ae(with[name], fine);
    std::cout << name << ": mean error without " << before.mean << " %, with " << after.mean << " %\n";
    EXPECT_LT(after.mean, before.mean / 5) << name;
    // Facets stay where they are, and 150 vertices leave them 1.5 % of the radius inside.
    EXPECT_LT(after.mean, 2) << name;
  }
}

// For the engines that sum surfaces over triangles.
class FollowedNormalMaps : public SurfaceMapsTest, public ::testing::WithParamInterface<int32_t> {
protected:
  void SetUp() override {
    std::string why_not;
    context = open_context(GetParam(), why_not);
    ASSERT_TRUE(context) << why_not;
  }
};
INSTANTIATE_TEST_SUITE_P(, FollowedNormalMaps, ::testing::Values(int32_t{PDESC_BACKEND_REFERENCE}, int32_t{PDESC_BACKEND_CPU}),
                         backend_name);

TEST_P(FollowedNormalMaps, make_a_coarse_sphere_as_near_to_the_fine_one) {
  TestMesh mesh = sphere(1, {.vertices = 150});
  lay_out(mesh, {.charts = 6, .gutter = 8.0 / 1024});
  disturb_normals(mesh);
  const Settings settings{.radius = 0.2, .radius_unit = PDESC_RADIUS_ABSOLUTE, .normals = PDESC_NORMALS_MESH};
  const Results without = run(mesh, {}, settings, measured);
  const Results with = run(mesh, normals_of(mesh, 256, [](Vec3 p) { return p; }), settings, measured);
  for (const std::string &name : measured) {
    const std::vector<double> fine = constant(mesh.points.size(), 1.0);
    const PercentAe before = percent_ae(without[name], fine), after = percent_ae(with[name], fine);
    std::cout << name << ": mean error without " << before.mean << " %, with " << after.mean << " %\n";
    EXPECT_LT(after.mean, before.mean / 5) << name;
    EXPECT_LT(after.mean, 2) << name; // as in texture space: facets stay where they are
  }
}

TEST_F(SurfaceMapsTest, a_normal_mapped_coarse_ellipsoid_is_nearer_to_the_fine_one) {
  TestMesh mesh = ellipsoid(1, 0.75, 0.5, {.vertices = 150});
  lay_out(mesh, {.charts = 6, .gutter = 8.0 / 1024});
  const Settings settings{.radius = 0.1, .radius_unit = PDESC_RADIUS_ABSOLUTE}; // fitted normals
  const Maps maps = normals_of(mesh, 512, [](Vec3 p) { return Vec3{p.x, p.y / 0.5625, p.z / 0.25}; });
  const Results without = run(mesh, {}, settings, measured), with = run(mesh, maps, settings, measured);
  for (const std::string &name : measured) {
    std::vector<double> fine = mesh.H;
    if (name == "local_bending_energy")
      for (size_t v = 0; v < fine.size(); ++v) fine[v] = 0.5 * (mesh.k1[v] * mesh.k1[v] + mesh.k2[v] * mesh.k2[v]);
    const PercentAe before = percent_ae(without[name], fine), after = percent_ae(with[name], fine);
    std::cout << name << ": mean error without " << before.mean << " %, with " << after.mean << " %\n";
    EXPECT_LT(after.mean, before.mean / 2) << name;
  }
}

} // namespace
} // namespace paradesc::test
