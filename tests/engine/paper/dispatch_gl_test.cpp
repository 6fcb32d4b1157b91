// Dispatches that follow a device's pace: what is slow gets less at once, and everything is computed exactly once.
#include "engine/paper/dispatch.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <string>
#include <thread>
#include <type_traits>
#include <vector>

#include <gtest/gtest.h>

#include "engine/paper/buffer.h"
#include "engine/paper/faults.h"
#include "engine/paper/gl_thread.h"
#include "shared.h"
#include "support/error.h"
#include "support/on_device.h"

namespace paradesc {
namespace {

TEST(NextTile, is_smaller_for_a_slow_device_and_larger_for_a_fast_one) {
  EXPECT_EQ(next_tile(6400, 0.03, 64, 64), 6400);
  EXPECT_EQ(next_tile(6400, 0.06, 64, 64), 3200);
  EXPECT_EQ(next_tile(6400, 0.015, 64, 64), 12800);
  EXPECT_EQ(next_tile(6400, 100.0, 64, 64), 1600) << "a program is compiled in the first dispatch: no more than to a quarter";
  EXPECT_EQ(next_tile(6400, 0.0, 64, 64), 25600);
}

TEST(NextTile, has_whole_groups_within_what_a_count_holds) {
  EXPECT_EQ(next_tile(100, 0.03, 64, 64), 64);
  EXPECT_EQ(next_tile(64, 10.0, 64, 64), 64);
  EXPECT_EQ(next_tile(128, 10.0, 128, 16), 128);
  EXPECT_LE(next_tile(std::numeric_limits<int>::max(), 0.0, 64, 64), 1000000000);
}

std::vector<int> tiles_of(int count, TileSizes sizes, double seconds) {
  sizes.seconds = seconds;
  std::vector<int> tiles;
  int end = 0;
  in_tiles(
      0, count, sizes,
      [&](int first, int last) {
        EXPECT_EQ(first, end);
        tiles.push_back(last - first);
        end = last;
      },
      [&](int last) { EXPECT_EQ(last, end); });
  EXPECT_EQ(end, count);
  return tiles;
}

TEST(InTiles, grow_while_they_take_no_time_up_to_the_largest) {
  EXPECT_EQ(tiles_of(20000, {128, 128, 4096, 64}, 0.0), (std::vector<int>{128, 512, 2048, 4096, 4096, 4096, 4096, 928}));
  EXPECT_EQ(tiles_of(5000, {8192, 128, 4096, 64}, 0.0), (std::vector<int>{4096, 904}));
}

// ---- A driver that is slow at first. Functions of C have no state of their own.

std::vector<GLuint> dispatched; // work groups, along x times y
PFNGLDISPATCHCOMPUTEPROC real_dispatch = nullptr;
void APIENTRY noted_dispatch(GLuint x, GLuint y, GLuint z) {
  dispatched.push_back(x * y);
  real_dispatch(x, y, z);
}
// More than twice what a tile may take, after the first two. How long the others take is not known.
void APIENTRY slow_finish() {
  if (dispatched.size() <= 2) std::this_thread::sleep_for(std::chrono::milliseconds(70));
}

class SlowDevice : public test::OnDevice {
protected:
  void SetUp() override {
    OnDevice::SetUp();
    if (!thread) return;
    dispatched.clear();
    const test::FailingDriver driver =
        test::FailingDriver().put("glDispatchCompute", noted_dispatch).put("glFinish", slow_finish);
    thread = std::make_unique<GlThread>(!test::on_card(), -1, [put = DriverSubstitute(driver)](const char *name, void *found) {
      if (std::string(name) == "glDispatchCompute") real_dispatch = reinterpret_cast<PFNGLDISPATCHCOMPUTEPROC>(found);
      return put(name, found);
    });
  }

  // How often each of `count` places was computed by a program of this text.
  std::vector<uint32_t> computed(size_t count, const std::string &text, const std::function<void(const Gl &)> &start) {
    std::vector<uint32_t> times(count, 0);
    thread->run([&](const Gl &gl, ProgramCache &programs) {
      Buffer buffer;
      buffer.upload(gl, times);
      gl.UseProgram(programs.get(gl, "count", {{GL_COMPUTE_SHADER, "count.comp.glsl"}}, {{"count.comp.glsl", text}}));
      gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_RESULTS, buffer.id());
      start(gl);
      gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
      gl.GetNamedBufferSubData(buffer.id(), 0, static_cast<GLsizeiptr>(count * sizeof(uint32_t)), times.data());
      check_gl(gl, "test");
    });
    return times;
  }
};

constexpr const char *results = "layout(std430, binding = BINDING_RESULTS) buffer Results { uint results[]; };\n"
                                "layout(location = LOCATION_FIRST) uniform int first;\n";

TEST_F(SlowDevice, gets_fewer_texels_at_once_and_computes_each_once) {
  constexpr int size = 2000; // not whole groups
  const std::string text =
      std::string("#version 450 core\n#include \"shared.h\"\nlayout(local_size_x = 8, local_size_y = 8) in;\n") + results +
      "void main() {\n  ivec2 texel = ivec2(gl_GlobalInvocationID.x, first + int(gl_GlobalInvocationID.y));\n"
      "  if (all(lessThan(texel, ivec2(2000)))) ++results[texel.y * 2000 + texel.x];\n}\n";
  const auto times = computed(size_t{size} * size, text, [&](const Gl &gl) { dispatch_texels(gl, size); });
  EXPECT_EQ(std::ranges::count(times, 1u), size * size);
  ASSERT_GE(dispatched.size(), 3u);
  EXPECT_LT(2 * dispatched[1], dispatched[0] + 1);
}

} // namespace
} // namespace paradesc
