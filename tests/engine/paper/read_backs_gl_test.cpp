// How often a computation waits for the device: it reads its results back once, and a tile may be several dispatches.
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "compute/compute.h"
#include "context.h"
#include "descriptor/registry.h"
#include "engine/paper/evaluator.h"
#include "engine/paper/faults.h"
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

int finished = 0;
PFNGLFINISHPROC real_finish = nullptr;
void APIENTRY noted_finish() {
  ++finished;
  real_finish();
}

// A device whose read-backs and ends are counted; driver: what else of it is another.
std::shared_ptr<paradesc::Context> open_counted(const DriverSubstitute &driver = {}) {
  return open_device([driver](const char *name, void *found) {
    if (std::string(name) == "glFinish") {
      real_finish = reinterpret_cast<PFNGLFINISHPROC>(found);
      return reinterpret_cast<void *>(&noted_finish);
    }
    if (std::string(name) != "glGetNamedBufferSubData") return driver ? driver(name, found) : found;
    real_read = reinterpret_cast<PFNGLGETNAMEDBUFFERSUBDATAPROC>(found);
    return reinterpret_cast<void *>(&noted_read);
  });
}

class ReadBacks : public OnDevice {
protected:
  static std::vector<float> values_of(paradesc::Mesh &mesh, const Settings &settings) {
    const int row = find_descriptor("mean_curvature");
    read_backs = finished = 0;
    return compute(mesh, options_of(settings), std::span(&row, 1), [](const char *, double) { return true; }).values[0];
  }
};

TEST_F(ReadBacks, of_a_frame_is_one) {
  TestMesh mesh = torus(1.0, 0.4, {.vertices = 2000});
  lay_out(mesh, {.charts = 4});
  const auto native = paradesc::make_mesh(open_counted(), input_of(mesh));
  const Settings settings{.radius = 0.1, .samples = 64, .buffer_size = 256};
  values_of(*native, settings);
  EXPECT_EQ(read_backs, 1);
  for (float &coordinate : mesh.positions) coordinate *= 1.0f + 1e-5f;
  move_mesh(*native, mesh.positions.data(), mesh.vertex_count);
  values_of(*native, settings);
  EXPECT_EQ(read_backs, 1);
}

// Centers keep so much between their dispatches that a tile of many is several of them; that changes no bit.
TEST_F(ReadBacks, of_a_tile_of_several_dispatches_are_those_of_small_tiles) {
  TestMesh mesh = saddle(1, {.vertices = most_centers_of_paper + 2000});
  lay_out(mesh, {.charts = 1});
  const Settings settings{
      .radius = 0.005, .samples = 8, .buffer_size = 256, .relocation = PDESC_RELOCATION_PAPER, .max_jumps = 1};
  const auto values_in_tiles = [&](int smallest) {
    const auto context = open_counted();
    context->smallest_tile = smallest;
    return values_of(*paradesc::make_mesh(context, input_of(mesh)), settings);
  };
  const std::vector<float> at_once = values_in_tiles(1 << 20);
  EXPECT_EQ(finished, 1);
  expect_same_bits(at_once, values_in_tiles(4096));
  EXPECT_GT(finished, 1);
}

} // namespace
} // namespace paradesc::test
