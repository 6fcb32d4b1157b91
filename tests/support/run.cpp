#include "support/run.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <iomanip>
#include <iostream>
#include <limits>

namespace paradesc::test {

Context open_context(int32_t backend, std::string &why_not) {
  pdesc_context_options options;
  pdesc_context_options_init(&options);
  options.backend = backend;
  pdesc_context *context = nullptr;
  const int32_t status = pdesc_context_create(&options, &context);
  why_not.clear();
  if (status == PDESC_ERROR_UNSUPPORTED)
    why_not = pdesc_last_error();
  else
    EXPECT_EQ(status, PDESC_OK) << pdesc_last_error();
  return Context(status == PDESC_OK ? context : nullptr);
}

Mesh make_mesh(pdesc_context *context, const TestMesh &mesh) {
  const pdesc_mesh_input input = input_of(mesh);
  pdesc_mesh *created = nullptr;
  const int32_t status = pdesc_mesh_create(context, &input, &created);
  EXPECT_EQ(status, PDESC_OK) << pdesc_last_error();
  return Mesh(status == PDESC_OK ? created : nullptr);
}

pdesc_options options_of(const Settings &settings) {
  pdesc_options options;
  pdesc_options_init(&options);
  options.radius = settings.radius;
  options.radius_unit = settings.radius_unit;
  options.samples = settings.samples;
  options.buffer_size = settings.buffer_size;
  options.normals = settings.normals;
  options.creases = settings.creases;
  options.estimator = settings.estimator;
  options.variance_reduction = settings.variance_reduction;
  options.distance = settings.distance;
  options.adaptive = settings.adaptive;
  options.relocation = settings.relocation;
  options.evaluate = settings.evaluate;
  options.texels = settings.texels;
  options.precision = settings.precision;
  options.max_jumps = settings.max_jumps;
  options.pattern = settings.pattern;
  options.ellipse = settings.ellipse;
  options.geodesic = settings.geodesic;
  options.map_descriptor = settings.map_descriptor;
  options.map_sigma = settings.map_sigma;
  options.harris_k = settings.harris_k;
  return options;
}

Results read_field(const pdesc_field *field, int32_t vertex_count, std::span<const std::string> descriptors) {
  Results results;
  const size_t count = static_cast<size_t>(vertex_count);
  std::vector<std::string> names(descriptors.begin(), descriptors.end());
  names.push_back("coverage");
  for (const std::string &name : names) {
    std::vector<float> &values = results.values[name];
    values.assign(count * components_of(name), sentinel);
    EXPECT_EQ(pdesc_field_values(field, name.c_str(), values.data(), vertex_count), PDESC_OK) << pdesc_last_error();
    EXPECT_EQ(std::count(values.begin(), values.end(), sentinel), 0) << name << " was not written everywhere";
  }
  results.mask.assign(count, mask_sentinel);
  EXPECT_EQ(pdesc_field_mask(field, results.mask.data(), vertex_count), PDESC_OK) << pdesc_last_error();
  EXPECT_EQ(std::count(results.mask.begin(), results.mask.end(), mask_sentinel), 0);
  pdesc_field_report_init(&results.report);
  EXPECT_EQ(pdesc_field_get_report(field, &results.report), PDESC_OK) << pdesc_last_error();
  return results;
}

Results compute(pdesc_context *context, const TestMesh &mesh, const Settings &settings,
                std::span<const std::string> descriptors) {
  const Mesh created = make_mesh(context, mesh);
  const pdesc_options options = options_of(settings);
  std::vector<const char *> names;
  for (const std::string &name : descriptors) names.push_back(name.c_str());
  pdesc_field *field = nullptr;
  int32_t status = PDESC_ERROR_INVALID_ARGUMENT;
  if (created)
    status = pdesc_compute(created.get(), &options, names.data(), static_cast<int32_t>(names.size()), nullptr, nullptr, &field);
  EXPECT_EQ(status, PDESC_OK) << pdesc_last_error();
  const Field owner(status == PDESC_OK ? field : nullptr);
  if (owner) return read_field(owner.get(), mesh.vertex_count, descriptors);
  Results failed{};
  failed.mask.assign(static_cast<size_t>(mesh.vertex_count), mask_sentinel);
  for (const std::string &name : descriptors)
    failed.values[name] = std::vector<float>(static_cast<size_t>(mesh.vertex_count), std::numeric_limits<float>::quiet_NaN());
  failed.values["coverage"] = std::vector<float>(static_cast<size_t>(mesh.vertex_count), 0.0f);
  return failed;
}

std::vector<std::string> registered_descriptors() {
  std::vector<std::string> names;
  for (int32_t i = 0; i < pdesc_descriptor_count(); ++i) {
    pdesc_descriptor_info info;
    pdesc_descriptor_info_init(&info);
    EXPECT_EQ(pdesc_descriptor_get(i, &info), PDESC_OK) << pdesc_last_error();
    if (info.name) names.emplace_back(info.name);
  }
  return names;
}

std::vector<std::string> descriptors_of_devices() {
  std::vector<std::string> names = registered_descriptors();
  std::erase(names, "standard_error");
  return names;
}

static pdesc_descriptor_info info_of(const std::string &descriptor) {
  pdesc_descriptor_info info;
  pdesc_descriptor_info_init(&info);
  for (int32_t i = 0; i < pdesc_descriptor_count(); ++i)
    if (pdesc_descriptor_get(i, &info) == PDESC_OK && descriptor == info.name) return info;
  pdesc_descriptor_info_init(&info);
  info.components = 1; // "coverage"
  return info;
}

size_t components_of(const std::string &descriptor) { return static_cast<size_t>(info_of(descriptor).components); }

int32_t map_degree_of(const std::string &descriptor) { return info_of(descriptor).map_degree; }

void OnBackend::SetUp() {
  std::string why_not;
  context = open_context(GetParam(), why_not);
  if (!context && !why_not.empty()) GTEST_SKIP() << why_not;
  ASSERT_TRUE(context);
}

std::vector<float> OnBackend::compute_one(const TestMesh &mesh, const std::string &descriptor, const Settings &settings) {
  const Results results = compute(context.get(), mesh, settings, std::span(&descriptor, 1));
  radius = results.report.radius;
  return results[descriptor];
}

std::string backend_name(const ::testing::TestParamInfo<int32_t> &info) {
  constexpr const char *names[] = {"auto", "gpu", "software", "reference", "cpu"};
  return names[info.param];
}

void expect_near(std::span<const float> values, std::span<const double> expected, double tolerance,
                 std::span<const uint8_t> subset) {
  size_t worst = values.size();
  double largest = -1;
  int compared = 0, undefined = 0;
  for (size_t v = 0; v < values.size(); ++v) {
    if (!subset.empty() && !subset[v]) continue;
    ++compared;
    const double difference = std::abs(static_cast<double>(values[v]) - expected[v]);
    if (!std::isfinite(difference))
      ++undefined;
    else if (difference > largest) {
      largest = difference;
      worst = v;
    }
  }
  EXPECT_GT(compared, 0) << "nothing was compared";
  EXPECT_EQ(undefined, 0) << "values are undefined, of " << compared;
  if (worst == values.size()) return;
  EXPECT_LE(largest, tolerance) << "vertex " << worst << " has " << values[worst] << " instead of " << expected[worst];
  std::cout << "worst error " << largest << " of " << tolerance << " allowed, over " << compared << " vertices\n";
}

void expect_near(std::span<const float> values, double expected, double tolerance, std::span<const uint8_t> subset) {
  expect_near(values, std::vector<double>(values.size(), expected), tolerance, subset);
}

void expect_same_bits(std::span<const float> a, std::span<const float> b) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i)
    ASSERT_EQ(std::bit_cast<uint32_t>(a[i]), std::bit_cast<uint32_t>(b[i])) << "vertex " << i << ": " << a[i] << " and " << b[i];
}

bool long_tests() { return std::getenv("PARADESC_LONG_TESTS") != nullptr; }

} // namespace paradesc::test
