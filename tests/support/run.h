// A TestMesh through the C interface → values by name. Handles close themselves; outputs start as a sentinel.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "paradesc/paradesc.h"
#include "support/device.h"
#include "support/surfaces.h"

namespace paradesc::test {

struct Destroy {
  void operator()(pdesc_context *context) const { pdesc_context_destroy(context); }
  void operator()(pdesc_mesh *mesh) const { pdesc_mesh_destroy(mesh); }
  void operator()(pdesc_field *field) const { pdesc_field_destroy(field); }
};
using Context = std::unique_ptr<pdesc_context, Destroy>;
using Mesh = std::unique_ptr<pdesc_mesh, Destroy>;
using Field = std::unique_ptr<pdesc_field, Destroy>;

inline constexpr float sentinel = -12345.0f; // no descriptor of a test mesh takes this value
inline constexpr uint8_t mask_sentinel = 0xEE;

// A context of the backend; empty where the machine has no such device, and then why_not says so. Any other failure fails the
// test.
Context open_context(int32_t backend, std::string &why_not);

Mesh make_mesh(pdesc_context *context, const TestMesh &mesh);

struct Settings {
  double radius = 0.02;
  int32_t radius_unit = PDESC_RADIUS_DIAGONAL;
  int32_t samples = 256;
  int32_t buffer_size = 1024;
  int32_t normals = PDESC_NORMALS_FITTED;
  int32_t creases = PDESC_CREASES_AUTO;
  int32_t estimator = PDESC_ESTIMATOR_SHAPE_OPERATOR;
  int32_t variance_reduction = PDESC_VARIANCE_REDUCTION_SHAPE;
  int32_t distance = PDESC_DISTANCE_EUCLIDEAN;
  double adaptive = 0;
  int32_t relocation = PDESC_RELOCATION_CONNECTED;
  int32_t evaluate = PDESC_EVALUATE_VERTEX;
  int32_t texels = 512;
  int32_t precision = PDESC_PRECISION_FULL;
  int32_t max_jumps = 8;
  int32_t pattern = PDESC_PATTERN_GOLDEN_ANGLE;
  int32_t ellipse = PDESC_ELLIPSE_CENTER;
  int32_t geodesic = PDESC_GEODESIC_LOCAL;
  const char *map_descriptor = nullptr;
  double map_sigma = 1;
  double harris_k = 0.04;
};
pdesc_options options_of(const Settings &settings);

struct Results {
  std::map<std::string, std::vector<float>> values; // by descriptor, and "coverage"; (vertex_count, components)
  std::vector<uint8_t> mask;
  pdesc_field_report report;
  const std::vector<float> &operator[](const std::string &name) const { return values.at(name); }
};

// Every value of the field; a value that the library left alone fails the test.
Results read_field(const pdesc_field *field, int32_t vertex_count, std::span<const std::string> descriptors);

// Mesh, compute, read. Failures fail the test and leave the values NaN.
Results compute(pdesc_context *context, const TestMesh &mesh, const Settings &settings, std::span<const std::string> descriptors);

std::vector<std::string> registered_descriptors();
// Those that devices have: texels do not know the noise of positions.
std::vector<std::string> descriptors_of_devices();

// Values a vertex has of a descriptor.
size_t components_of(const std::string &descriptor);

// 0, or the degree of an operator on a map.
int32_t map_degree_of(const std::string &descriptor);

// Tests through the backends that run on any machine: instantiate with PDESC_ON_EACH_BACKEND(suite).
class OnBackend : public ::testing::TestWithParam<int32_t> {
protected:
  void SetUp() override;
  // One descriptor at every vertex.
  std::vector<float> compute_one(const TestMesh &mesh, const std::string &descriptor, const Settings &settings);

  Context context;
  double radius = 0; // as used by the last compute_one, in units of the positions
};

std::string backend_name(const ::testing::TestParamInfo<int32_t> &info);

#define PDESC_ON_EACH_BACKEND(suite)                                                                                             \
  INSTANTIATE_TEST_SUITE_P(                                                                                                      \
      , suite, ::testing::Values(int32_t{PDESC_BACKEND_REFERENCE}, device_backend(), int32_t{PDESC_BACKEND_CPU}), backend_name)

// Every value where subset is 1 (empty: everywhere) within tolerance of the expected one. Reports the worst vertex only.
void expect_near(std::span<const float> values, std::span<const double> expected, double tolerance,
                 std::span<const uint8_t> subset = {});
void expect_near(std::span<const float> values, double expected, double tolerance, std::span<const uint8_t> subset = {});

// The same bits, NaN included.
void expect_same_bits(std::span<const float> a, std::span<const float> b);

bool long_tests(); // PARADESC_LONG_TESTS is set

} // namespace paradesc::test
