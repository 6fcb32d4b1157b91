// Input that is too large is refused by its counts, before a byte of it is read or allocated.
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "compute/compute.h"
#include "compute/memory.h"
#include "context.h"
#include "support/api_fixture.h"
#include "support/free_memory.h"

namespace paradesc::test {
namespace {

Context open_limited(int32_t backend, int64_t limit) {
  pdesc_context_options options;
  pdesc_context_options_init(&options);
  options.backend = backend;
  options.memory_limit = limit;
  pdesc_context *context = nullptr;
  EXPECT_EQ(pdesc_context_create(&options, &context), PDESC_OK) << pdesc_last_error();
  return Context(context);
}

class Memory : public Api {
protected:
  pdesc_memory memory_of(const pdesc_mesh *mesh, int32_t backend) {
    pdesc_memory memory;
    pdesc_memory_init(&memory);
    const char *name = "mean_curvature";
    EXPECT_EQ(pdesc_mesh_memory(mesh, &options, &name, 1, backend, &memory), PDESC_OK) << pdesc_last_error();
    return memory;
  }

  int32_t compute_on(pdesc_mesh *mesh, pdesc_field **field) {
    const char *name = "mean_curvature";
    return pdesc_compute(mesh, &options, &name, 1, nullptr, nullptr, field);
  }
};

// Arrays of that size need not exist: nothing of them is read, which would be a crash.
TEST_F(Memory, sixteen_million_vertices_are_refused_unread_with_both_numbers) {
  context = open_limited(PDESC_BACKEND_REFERENCE, 2'000'000'000);
  input.vertex_count = 16'000'000;
  input.triangle_count = 32'000'000;
  input.corner_count = 96'000'000;
  pdesc_mesh *mesh = never_mesh();
  expect_refused(pdesc_mesh_create(context.get(), &input, &mesh), PDESC_ERROR_OUT_OF_MEMORY,
                 {"32000000 triangles", "16000000 vertices", "11.5 GB", "2.0 GB", "memory limit"});
  EXPECT_EQ(mesh, never_mesh());
}

TEST_F(Memory, counts_at_the_end_of_their_type_do_not_overflow) {
  context = open_limited(PDESC_BACKEND_REFERENCE, std::numeric_limits<int64_t>::max());
  const int32_t largest = std::numeric_limits<int32_t>::max();
  for (const int32_t triangles : {largest, largest / 3 + 1}) {
    input = input_of(ball);
    input.triangle_count = triangles; // three times that is no int32_t
    expect_mesh_refused({std::to_string(triangles).c_str(), "can be counted"});
  }
  input = input_of(ball);
  input.triangle_count = input.vertex_count = input.sharp_edge_count = largest;
  EXPECT_GT(bytes_of_input(input), int64_t{largest} * 300);
  input.triangle_count = input.vertex_count = input.sharp_edge_count = std::numeric_limits<int32_t>::min();
  EXPECT_EQ(bytes_of_input(input), 0) << "what is no count is refused elsewhere";
}

TEST_F(Memory, more_triangles_than_shaders_tell_apart_are_refused_by_name) {
  std::string why_not;
  if (!open_context(device_backend(), why_not)) GTEST_SKIP() << why_not;
  context = open_limited(device_backend(), std::numeric_limits<int64_t>::max());
  input.triangle_count = (1 << 24) + 1;
  pdesc_mesh *mesh = never_mesh();
  expect_refused(pdesc_mesh_create(context.get(), &input, &mesh), PDESC_ERROR_UNSUPPORTED, {"16777217", "16777216", "cpu"});
}

TEST_F(Memory, a_computation_over_the_limit_is_refused_and_the_mesh_stays_usable) {
  for (const int32_t backend : {int32_t{PDESC_BACKEND_REFERENCE}, int32_t{PDESC_BACKEND_CPU}, device_backend()}) {
    std::string why_not;
    if (!open_context(backend, why_not)) continue;
    options.buffer_size = 256;
    options.creases = PDESC_CREASES_NONE; // memory for these is refused only where there are some
    const Context plenty = open_limited(backend, 0);
    const pdesc_memory memory = memory_of(make_mesh(plenty.get(), ball).get(), backend);
    for (const bool enough : {false, true}) {
      // The processor takes the whole of it only for a rough surface.
      const int64_t less = backend == PDESC_BACKEND_CPU ? bytes_of_input(input_of(ball)) : memory.total - 1;
      const Context limited = open_limited(backend, enough ? memory.total : less);
      const Mesh mesh = make_mesh(limited.get(), ball);
      ASSERT_TRUE(mesh);
      pdesc_field *field = never_field();
      const int32_t status = compute_on(mesh.get(), &field);
      if (enough) {
        EXPECT_EQ(status, PDESC_OK) << pdesc_last_error();
        pdesc_field_destroy(field);
        continue;
      }
      expect_refused(status, PDESC_ERROR_OUT_OF_MEMORY, {"768 triangles", "B of memory", "memory limit"});
      EXPECT_EQ(field, never_field());
      EXPECT_EQ(pdesc_context_backend(limited.get()), backend) << "no device has failed";
    }
  }
}

// Counts do not tell how far maps displace a surface, and samples stand for its area.
TEST_F(Memory, samples_of_a_surface_that_is_displaced_far_are_refused_before_they_are_made) {
  std::vector<float> heights(16);
  for (size_t i = 0; i < heights.size(); ++i) heights[i] = static_cast<float>(i * 7 % 16) / 16.0f;
  const auto displaced = [&](const Context &of) {
    Mesh mesh = make_mesh(of.get(), ball);
    EXPECT_EQ(pdesc_mesh_set_displacement(mesh.get(), heights.data(), 4, 4, 0.0, 20.0), PDESC_OK);
    return mesh;
  };
  options.radius_unit = PDESC_RADIUS_ABSOLUTE;
  options.radius = 1.0;
  options.samples = 4096;
  const Context plenty = open_limited(PDESC_BACKEND_CPU, 0);
  const pdesc_memory memory = memory_of(displaced(plenty).get(), PDESC_BACKEND_CPU);
  const Context limited = open_limited(PDESC_BACKEND_CPU, memory.total + 1'000'000); // a little more than was expected
  const Mesh mesh = displaced(limited);
  pdesc_field *field = never_field();
  expect_refused(compute_on(mesh.get(), &field), PDESC_ERROR_OUT_OF_MEMORY, {"samples", "larger radius", "may be used"});
  EXPECT_EQ(field, never_field());
  ASSERT_EQ(pdesc_mesh_set_displacement(mesh.get(), nullptr, 0, 0, 0.0, 1.0), PDESC_OK);
  ASSERT_EQ(compute_on(mesh.get(), &field), PDESC_OK) << pdesc_last_error();
  pdesc_field_destroy(field);
}

// The memory that only rough surfaces take is refused as soon as it is known, and a smooth one of as many triangles is computed.
TEST_F(Memory, a_rough_surface_is_refused_where_a_smooth_one_is_computed) {
  const TestMesh smooth = torus(1.0, 0.4, {.vertices = 200000});
  TestMesh rough = smooth;
  std::mt19937 random(1);
  std::normal_distribution<float> step(0.0f, 0.01f);
  for (float &coordinate : rough.positions) coordinate += step(random);
  options.radius = 0.1;
  const Context plenty = open_limited(PDESC_BACKEND_CPU, 0);
  const pdesc_memory memory = memory_of(make_mesh(plenty.get(), smooth).get(), PDESC_BACKEND_CPU);
  const Context limited = open_limited(PDESC_BACKEND_CPU, memory.mesh + memory.host / 2);
  const Mesh fine = make_mesh(limited.get(), smooth), coarse = make_mesh(limited.get(), rough);
  pdesc_field *field = nullptr;
  ASSERT_EQ(compute_on(fine.get(), &field), PDESC_OK) << pdesc_last_error();
  pdesc_field_destroy(field);
  field = never_field();
  expect_refused(compute_on(coarse.get(), &field), PDESC_ERROR_OUT_OF_MEMORY, {"so rough", "fewer triangles", "may be used"});
  EXPECT_EQ(field, never_field());
}

TEST_F(Memory, a_larger_buffer_map_or_mesh_is_expected_to_take_more) {
  const Mesh mesh = make_mesh(context.get(), ball);
  const pdesc_memory small = memory_of(mesh.get(), PDESC_BACKEND_SOFTWARE);
  options.buffer_size = 8192;
  const pdesc_memory large = memory_of(mesh.get(), PDESC_BACKEND_SOFTWARE);
  EXPECT_GT(large.device, int64_t{8192} * 8192 * 44) << "the geometry buffer alone";
  EXPECT_GT(large.host, small.host);
  EXPECT_EQ(large.mesh, small.mesh);
  EXPECT_GE(large.total, large.mesh + large.host + large.device) << "the device's is the host's on a software rasterizer";
  options.precision = PDESC_PRECISION_HALF;
  EXPECT_LT(memory_of(mesh.get(), PDESC_BACKEND_GPU).device, large.device);
  EXPECT_EQ(memory_of(mesh.get(), PDESC_BACKEND_REFERENCE).device, 0);
  EXPECT_EQ(memory_of(mesh.get(), PDESC_BACKEND_GPU).total,
            memory_of(mesh.get(), PDESC_BACKEND_GPU).mesh + memory_of(mesh.get(), PDESC_BACKEND_GPU).host);
  EXPECT_GT(small.allowed, 0);
}

TEST_F(Memory, a_report_says_what_was_expected_and_which_backend_computed) {
  const Mesh mesh = make_mesh(context.get(), ball);
  pdesc_field *field = nullptr;
  ASSERT_EQ(compute_on(mesh.get(), &field), PDESC_OK) << pdesc_last_error();
  const Field owner(field);
  pdesc_field_report report;
  pdesc_field_report_init(&report);
  ASSERT_EQ(pdesc_field_get_report(field, &report), PDESC_OK);
  EXPECT_EQ(report.backend, PDESC_BACKEND_REFERENCE);
  EXPECT_GT(report.memory_megabytes, 0);
  EXPECT_LT(report.memory_megabytes, 10);
}

TEST_F(Memory, unusable_arguments_are_refused) {
  const Mesh mesh = make_mesh(context.get(), ball);
  pdesc_memory memory;
  pdesc_memory_init(&memory);
  const char *name = "mean_curvature", *unknown = "no_such";
  expect_refused(pdesc_mesh_memory(nullptr, &options, &name, 1, 0, &memory), PDESC_ERROR_INVALID_ARGUMENT, {"NULL"});
  expect_refused(pdesc_mesh_memory(mesh.get(), &options, &unknown, 1, 0, &memory), PDESC_ERROR_INVALID_ARGUMENT, {"no_such"});
  expect_refused(pdesc_mesh_memory(mesh.get(), &options, &name, 1, 9, &memory), PDESC_ERROR_INVALID_ARGUMENT, {"backend"});
  expect_refused(pdesc_mesh_memory(mesh.get(), &options, &name, 1, 0, nullptr), PDESC_ERROR_INVALID_ARGUMENT, {"NULL"});
  pdesc_context_options of_context;
  pdesc_context_options_init(&of_context);
  of_context.memory_limit = -1;
  pdesc_context *never = nullptr;
  expect_refused(pdesc_context_create(&of_context, &never), PDESC_ERROR_INVALID_ARGUMENT, {"memory_limit", "-1"});
}

// ---- What is free

class FreeMemory : public ::testing::Test {
protected:
  void SetUp() override {
    root =
        (std::filesystem::temp_directory_path() / ("paradesc_free_memory_" + std::to_string(std::random_device()()))).string() +
        "/";
#if !defined(__linux__)
    GTEST_SKIP() << "other systems are asked by a call, which knows no folder";
#endif
    write("proc/meminfo", "MemTotal:       8000 kB\nMemFree:        10 kB\nMemAvailable:   4000 kB\n");
  }
  void TearDown() override { std::filesystem::remove_all(root); }
  void write(const std::string &path, const std::string &text) const {
    const std::filesystem::path file = root + path;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file) << text;
  }
  std::string root;
};

TEST_F(FreeMemory, is_what_the_system_calls_available) { EXPECT_EQ(free_memory(root), 4000 * 1024); }

TEST_F(FreeMemory, ends_at_a_control_groups_limit_of_version_2) {
  write("proc/self/cgroup", "0::/user/app\n");
  write("sys/fs/cgroup/user/app/memory.max", "max\n");
  write("sys/fs/cgroup/user/app/memory.current", "700000\n");
  EXPECT_EQ(free_memory(root), 4000 * 1024) << "no limit";
  write("sys/fs/cgroup/user/memory.max", "1000000\n"); // of the group above
  write("sys/fs/cgroup/user/memory.current", "900000\n");
  EXPECT_EQ(free_memory(root), 100000);
  write("sys/fs/cgroup/user/memory.stat", "anon 600000\ninactive_file 200000\n"); // files that can be read again
  EXPECT_EQ(free_memory(root), 300000);
  write("sys/fs/cgroup/user/memory.current", "2000000\n");
  EXPECT_EQ(free_memory(root), 0);
}

TEST_F(FreeMemory, ends_at_a_control_groups_limit_of_version_1_also_where_a_container_hides_the_group) {
  write("proc/self/cgroup", "5:cpu,cpuacct:/\n4:memory:/docker/abc\n");
  write("sys/fs/cgroup/memory/memory.limit_in_bytes", "3000000\n"); // what the container sees of its own
  write("sys/fs/cgroup/memory/memory.usage_in_bytes", "1000000\n");
  EXPECT_EQ(free_memory(root), 2000000);
  write("sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n");
  EXPECT_EQ(free_memory(root), 4000 * 1024);
}

TEST_F(FreeMemory, is_unknown_where_nothing_is_said) { EXPECT_EQ(free_memory(root + "nowhere/"), -1); }

TEST(FreeMemoryHere, is_something) { EXPECT_GT(free_memory(), 0); }

} // namespace
} // namespace paradesc::test
