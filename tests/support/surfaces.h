// An analytic surface and a triangulation of its parameter domain → a mesh with exact normals and curvatures at its vertices.
//
//   TestMesh mesh = torus(1.0, 0.4, {.vertices = 20000});    // surfaces.h
//   lay_out(mesh, {.charts = 15});                           // layout.h: its UV map
//   pdesc_mesh_input input = input_of(mesh);                 // a view: the mesh must outlive it
//
// The same seed gives the same mesh on every machine and with every standard library.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <span>
#include <vector>

#include "paradesc/paradesc.h"

namespace paradesc::test {

struct Vec3 {
  double x = 0, y = 0, z = 0;
  double operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
};
inline Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator*(double s, Vec3 a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 cross(Vec3 a, Vec3 b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
inline double length(Vec3 a) { return std::sqrt(dot(a, a)); }
inline Vec3 normalized(Vec3 a) { return (1 / length(a)) * a; }

// Rows of a rotation.
struct Rotation {
  Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  Vec3 operator()(Vec3 a) const { return {dot(x, a), dot(y, a), dot(z, a)}; }
};
Rotation rotation_about(Vec3 axis, double angle);

// std::uniform_real_distribution and std::normal_distribution differ between standard libraries; these do not.
class Random {
public:
  explicit Random(uint32_t seed) : engine(seed) {}
  double uniform() { return static_cast<double>(engine()) / 4294967296.0; } // [0, 1)
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  double normal(); // mean 0, deviation 1

private:
  std::mt19937 engine;
};

// The meaning of the vertices' parameters.
enum class Domain {
  rectangle, // (u, v) in [0, 1]², periodic where TestMesh says so
  sphere     // a unit direction; triangle_patch is the face of the cube that the triangle was made on
};

struct TestMesh {
  int32_t vertex_count = 0;
  std::vector<float> positions;          // (vertex_count, 3)
  std::vector<int32_t> corner_vertices;  // (3 * triangle_count): each triangle has its own corners
  std::vector<int32_t> triangle_corners; // (triangle_count, 3) = 0, 1, 2, …
  std::vector<float> corner_uvs;         // (3 * triangle_count, 2), empty until lay_out
  std::vector<float> corner_normals;     // (3 * triangle_count, 3) exact

  std::vector<Vec3> points, normals;     // (vertex_count) before rounding to float; outward
  std::vector<double> H, K, k1, k2;      // (vertex_count) exact, positive where convex
  std::vector<double> boundary_distance; // (vertex_count) to the nearest boundary edge, infinite on a closed surface

  Domain domain = Domain::rectangle;
  bool periodic_u = false, periodic_v = false;
  Vec3 lengths{1, 1, 1};               // of the rectangle's sides on the surface, or of the cube's axes
  std::vector<Vec3> parameters;        // (vertex_count)
  std::vector<int32_t> triangle_patch; // (triangle_count)
  std::vector<int32_t> triangle_chart; // (triangle_count), empty until lay_out

  int32_t triangle_count() const { return static_cast<int32_t>(corner_vertices.size() / 3); }
  double diagonal() const; // of the bounding box
};

struct Triangulation {
  int vertices = 20000;  // about as many
  bool irregular = true; // jittered in the parameter domain, random diagonals turned towards Delaunay; else a regular grid
  uint32_t seed = 1;
  double jitter = 0.35; // of a grid cell; below 0.5 no triangle folds over
};

TestMesh sphere(double radius, const Triangulation &triangulation = {});
TestMesh ellipsoid(double a, double b, double c, const Triangulation &triangulation = {});
TestMesh torus(double major, double minor, const Triangulation &triangulation = {});
// A cube from -half to half whose edges and corners are rounded by cylinders and spheres of radius fillet < half. Curvatures are
// those of the piece that a vertex lies on.
TestMesh rounded_cube(double half, double fillet, const Triangulation &triangulation = {});
// x⁴ + y⁴ + z⁴ + b (x² + y² + z²) = 1, b >= 0: Goursat's rounded cube.
TestMesh goursat(double b, const Triangulation &triangulation = {});
// Open surfaces.
TestMesh plane(double width, double depth, const Triangulation &triangulation = {});
TestMesh cylinder(double radius, double height, const Triangulation &triangulation = {});
TestMesh saddle(double half_width, const Triangulation &triangulation = {});                 // z = xy over a square
TestMesh catenoid(double neck, double half_height, const Triangulation &triangulation = {}); // H = 0

// A view of the mesh; UVs and normals are left out where the mesh has none.
pdesc_mesh_input input_of(const TestMesh &mesh);

// 1 where no boundary lies within r.
std::vector<uint8_t> interior(const TestMesh &mesh, double r);

double longest_edge(const TestMesh &mesh);

// The same mesh elsewhere: exact values follow.
void rotate(TestMesh &mesh, const Rotation &rotation);
void scale(TestMesh &mesh, double factor);
// Wound the other way: normals and signs follow. Before lay_out.
void turn_inside_out(TestMesh &mesh);
// Gaussian noise in every coordinate, deviation = fraction * diagonal; exact values stay those of the smooth surface.
void add_noise(TestMesh &mesh, double fraction, uint32_t seed);

// Positions and normals as float from points and normals. Call it after changing those.
void round_to_float(TestMesh &mesh);

} // namespace paradesc::test
