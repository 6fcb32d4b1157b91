// Images set on a mesh, and what is computed with them.
#pragma once

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "bake/shapes.h"
#include "support/run.h"

namespace paradesc::test {

using Descriptors = std::vector<std::string>;

// The images that a test sets on a mesh before it computes.
struct Maps {
  std::vector<float> heights;
  int width = 0, height = 0;
  double midlevel = 0, scale = 1;
  std::vector<float> rgb;
  std::vector<float> tangents;
};

// An image of a function of (u, v) at the centers of pixels.
inline Maps displacement(int width, int height, const std::function<double(double, double)> &value, double midlevel = 0,
                         double scale = 1) {
  Maps maps{{}, width, height, midlevel, scale, {}, {}};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) maps.heights.push_back(static_cast<float>(value((x + 0.5) / width, (y + 0.5) / height)));
  return maps;
}

inline int32_t set_maps(pdesc_mesh *mesh, const Maps &maps, int32_t corner_count) {
  int32_t status = PDESC_OK;
  if (!maps.heights.empty())
    status = pdesc_mesh_set_displacement(mesh, maps.heights.data(), maps.width, maps.height, maps.midlevel, maps.scale);
  if (status == PDESC_OK && !maps.rgb.empty())
    status = pdesc_mesh_set_normal_map(mesh, maps.rgb.data(), maps.width, maps.height, maps.tangents.data(), corner_count);
  return status;
}

class SurfaceMapsTest : public ::testing::Test {
protected:
  void SetUp() override {
    std::string why_not;
    context = open_context(device_backend(), why_not);
    if (!context) GTEST_SKIP() << why_not;
  }

  Results run(const TestMesh &mesh, const Maps &maps, const Settings &settings, const Descriptors &names) {
    const Mesh created = make_mesh(context.get(), mesh);
    EXPECT_EQ(set_maps(created.get(), maps, static_cast<int32_t>(mesh.corner_vertices.size())), PDESC_OK) << pdesc_last_error();
    return run(created.get(), mesh, settings, names);
  }

  Results run(pdesc_mesh *created, const TestMesh &mesh, const Settings &settings, const Descriptors &names) {
    const pdesc_options options = options_of(settings);
    std::vector<const char *> requested;
    for (const std::string &name : names) requested.push_back(name.c_str());
    pdesc_field *field = nullptr;
    EXPECT_EQ(
        pdesc_compute(created, &options, requested.data(), static_cast<int32_t>(requested.size()), nullptr, nullptr, &field),
        PDESC_OK)
        << pdesc_last_error();
    const Field owner(field);
    return read_field(field, mesh.vertex_count, names);
  }

  Context context;
};

inline std::vector<double> constant(size_t count, double value) { return std::vector<double>(count, value); }

} // namespace paradesc::test
