// How often a computation waits to read what the device has: lists find their lengths in a few turns, and a frame reads its
// results.
#include <span>
#include <string>

#include <gtest/gtest.h>

#include "compute/compute.h"
#include "context.h"
#include "descriptor/registry.h"
#include "engine/opengl/faults.h"
#include "support/layout.h"
#include "support/on_device.h"
#include "support/run.h"
#include "support/surfaces.h"

namespace paradesc::test {
namespace {

// Functions of C have no state of their own.
int read_backs = 0;
PFNGLGETNAMEDBUFFERSUBDATAPROC real_read = nullptr;
void APIENTRY noted_read(GLuint buffer, GLintptr offset, GLsizeiptr size, void *data) {
  ++read_backs;
  real_read(buffer, offset, size, data);
}

class ReadBacks : public OnDevice {
protected:
  void SetUp() override {
    OnDevice::SetUp();
    if (!thread) return;
    pdesc_context_options requested;
    pdesc_context_options_init(&requested);
    requested.backend = device_backend();
    context_ = make_context(requested, [](const char *name, void *driver) {
      if (std::string(name) != "glGetNamedBufferSubData") return driver;
      real_read = reinterpret_cast<PFNGLGETNAMEDBUFFERSUBDATAPROC>(driver);
      return reinterpret_cast<void *>(&noted_read);
    });
  }

  int read_backs_of_compute(paradesc::Mesh &mesh, double radius) {
    const int row = find_descriptor("mean_curvature");
    read_backs = 0;
    compute(mesh, options_of({.radius = radius, .samples = 64, .buffer_size = 256}), std::span(&row, 1),
            [](const char *, double) { return true; });
    return read_backs;
  }

  std::shared_ptr<paradesc::Context> context_;
};

// The owners of texels, then cells, their neighbors and samples: each is known when those before it have room.
TEST_F(ReadBacks, of_a_first_frame_are_few_however_long_lists_become) {
  for (const int charts : {1, 60}) {
    TestMesh mesh = torus(1.0, 0.4, {.vertices = 4000});
    lay_out(mesh, {.charts = charts});
    const auto native = paradesc::make_mesh(context_, input_of(mesh));
    for (const double radius : {0.1, 0.3})
      EXPECT_LE(read_backs_of_compute(*native, radius), 6) << charts << " charts, " << radius;
  }
}

TEST_F(ReadBacks, of_a_frame_that_has_moved_is_one) {
  TestMesh mesh = torus(1.0, 0.4, {.vertices = 4000});
  lay_out(mesh, {.charts = 4});
  const auto native = paradesc::make_mesh(context_, input_of(mesh));
  std::vector<float> moved = mesh.positions;
  for (float &coordinate : moved) coordinate *= 1.0f + 1e-5f;
  for (const bool first : {true, false}) {
    move_mesh(*native, moved.data(), mesh.vertex_count);
    read_backs_of_compute(*native, 0.1);
    move_mesh(*native, mesh.positions.data(), mesh.vertex_count);
    const int found = read_backs_of_compute(*native, 0.1);
    EXPECT_TRUE(first || found == 1) << found;
  }
}

} // namespace
} // namespace paradesc::test
