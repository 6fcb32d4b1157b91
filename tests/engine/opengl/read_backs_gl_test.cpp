// How often a computation waits for the device: lists find their lengths in a few turns, a frame reads its results, and what it
// computes at once is as much as the frame before has found right.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

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

// Lays a sheet in folds of a width, whose sides are that steep.
void fold(TestMesh &sheet, double width, double slope) {
  for (Vec3 &point : sheet.points) {
    const double turns = point.x / width, part = turns - std::floor(turns);
    point.z = slope * width * (part < 0.5 ? part : 1 - part);
  }
  round_to_float(sheet);
}

class ReadBacks : public OnDevice {
protected:
  void SetUp() override {
    OnDevice::SetUp();
    if (thread) context_ = open_counted();
  }

  static std::vector<float> values_of(paradesc::Mesh &mesh, double radius, int32_t unit = PDESC_RADIUS_DIAGONAL) {
    const int row = find_descriptor("mean_curvature");
    read_backs = 0;
    return compute(mesh, options_of({.radius = radius, .radius_unit = unit, .samples = 64, .buffer_size = 256}),
                   std::span(&row, 1), [](const char *, double) { return true; })
        .values[0];
  }
  static int read_backs_of_compute(paradesc::Mesh &mesh, double radius) {
    values_of(mesh, radius);
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

// The first tile of a first frame has 128 centers, and the next ones four times as many if they took no time: three tiles for
// these, and one for the check of what is connected.
TEST_F(ReadBacks, come_after_a_single_tile_where_the_frame_before_was_fast) {
  TestMesh mesh = plane(1, 1, {.vertices = 900});
  lay_out(mesh, {.charts = 1});
  context_->tile_seconds = 0.0;
  const auto native = paradesc::make_mesh(context_, input_of(mesh));
  const auto finished_in_a_frame = [&] {
    move_mesh(*native, mesh.positions.data(), mesh.vertex_count);
    finished = 0;
    values_of(*native, 0.1, PDESC_RADIUS_ABSOLUTE);
    return finished;
  };
  finished_in_a_frame();
  ASSERT_EQ(finished_in_a_frame(), 2);
  // In folds more lies near each center than lists have room for. All is done again, in small tiles: that nothing was found took
  // no time, and says nothing of how long it takes.
  fold(mesh, 0.05, 1.5);
  EXPECT_GE(finished_in_a_frame(), 2 + 4);
  EXPECT_EQ(read_backs, 3) << "of results, twice, and of how long lists are";
}

// A sheet in folds, where nearly every ball holds several pieces: a first frame checks 4096 ambiguous centers, of which it then
// reads that there are more, and the next frame checks all of them. With shorter lists, a tile and a round are several
// dispatches.
TEST_F(ReadBacks, go_on_until_all_ambiguous_centers_are_checked) {
  TestMesh mesh = plane(1, 1, {.vertices = 6000});
  lay_out(mesh, {.charts = 1});
  fold(mesh, 0.05, 3);
  const auto short_of_room = open_counted(with_short_lists(1 << 19));
  short_of_room->smallest_tile = 1 << 20; // of several dispatches
  const auto all_at_once = paradesc::make_mesh(context_, input_of(mesh)),
             in_rounds = paradesc::make_mesh(short_of_room, input_of(mesh));
  values_of(*all_at_once, 0.1);
  const std::vector<float> expected = values_of(*all_at_once, 0.1);
  for (const bool again : {false, true}) {
    const std::vector<float> found = values_of(*in_rounds, 0.1);
    EXPECT_TRUE(again ? read_backs == 1 : read_backs > 4) << read_backs;
    ASSERT_EQ(found.size(), expected.size());
    for (size_t i = 0; i < found.size(); ++i)
      ASSERT_EQ(std::bit_cast<uint32_t>(found[i]), std::bit_cast<uint32_t>(expected[i])) << i;
  }
}

} // namespace
} // namespace paradesc::test
