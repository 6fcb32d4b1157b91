// The same neighborhoods by the device and by C++: one text, the same values for every row of the registry.
#include "engine/kernels/recorded.h"

#include <bit>

#include <gtest/gtest.h>

#include "engine/paper/buffer.h"
#include "engine/paper/compose.h"
#include "support/likeness.h"
#include "support/on_device.h"

namespace paradesc::test {
namespace {

// A stage that reads its neighbors from a list, and nothing else.
const char *const stage = R"(#version 450 core
#include "variant.glsl"
#include "paper/evaluate/params.glsl"
#include "kernel/sums.glsl"
#include "descriptors.glsl"
layout(local_size_x = 1) in;
layout(std430, binding = 0) readonly restrict buffer Centers { vec4 centers[]; }; // position, map; normal, hits_boundary; first neighbor, past the last
layout(std430, binding = 1) readonly restrict buffer Neighbors { vec4 neighbors[]; };   // position, area; normal, near; face, geodesic; map
layout(std430, binding = 2) writeonly restrict buffer Results { uint results[]; };
void main() {
  int index = int(gl_GlobalInvocationID.x);
  Sums sums;
  sums_init(sums, centers[3 * index].xyz, centers[3 * index + 1].xyz, centers[3 * index].w);
  sums.moments.hits_boundary = centers[3 * index + 1].w;
  for (int i = int(centers[3 * index + 2].x); i < int(centers[3 * index + 2].y); ++i) {
    vec4 position = neighbors[4 * i], normal = neighbors[4 * i + 1], face = neighbors[4 * i + 2];
    add_neighbor(sums, position.xyz, normal.xyz, face.xyz, position.w, normal.w > 0.0, face.w,
                 neighbors[4 * i + 3]);
  }
  Neighborhood neighborhood = finish_neighborhood(sums, 1.0);
  STORE_DESCRIPTORS
}
)";

struct Variant {
  bool integral, extrapolated, geodesic_ball, faces;
};

class KernelsOnDevice : public OnDevice {
protected:
  // [neighborhood][value]
  std::vector<std::vector<float>> compute(const std::vector<Recorded> &all, const Variant &variant) const {
    std::vector<vec4> centers, neighbors;
    for (const Recorded &one : all) {
      centers.insert(centers.end(), {vec4(one.position, one.value), vec4(one.normal, one.hits_boundary)});
      const size_t first = neighbors.size() / 4;
      for (const RecordedNeighbor &neighbor : one.neighbors)
        neighbors.insert(neighbors.end(),
                         {vec4(neighbor.position, neighbor.area), vec4(neighbor.normal, neighbor.near ? 1.0f : 0.0f),
                          vec4(neighbor.face, neighbor.geodesic), neighbor.map});
      centers.emplace_back(first, neighbors.size() / 4, 0, 0);
    }
    std::vector<int> rows;
    for (int row = 0; row <= gradient_row(); ++row) rows.push_back(row);
    const size_t width = usual_values().size();
    std::vector<float> raw(width * all.size(), 0.0f);
    auto define = [](const char *name, bool value) { return std::string("#define ") + name + (value ? " 1\n" : " 0\n"); };
    const std::string choices = define("INTEGRAL", variant.integral) + define("EXTRAPOLATED", variant.extrapolated) +
                                define("GEODESIC_BALL", variant.geodesic_ball) + define("FACES", variant.faces) +
                                define("MAP", true);
    thread->run([&](const Gl &gl, ProgramCache &programs) {
      gl.UseProgram(programs.get(gl, "kernels " + choices, {{GL_COMPUTE_SHADER, "stage.comp.glsl"}},
                                 {{"stage.comp.glsl", stage},
                                  {"variant.glsl", choices},
                                  {"terms.glsl", compose_terms(rows, variant.integral)},
                                  {"descriptors.glsl", compose_descriptors(rows)}}));
      EvaluateParams params = recorded_params();
      params.total = static_cast<int>(all.size());
      Buffer uniforms, inputs, listed, results;
      uniforms.fill(gl, &params, sizeof params, GL_STREAM_DRAW);
      inputs.upload(gl, centers);
      listed.upload(gl, neighbors);
      results.upload(gl, nullptr, (raw.size() + ROW_DESCRIPTORS * all.size()) * sizeof(float), GL_STREAM_READ);
      gl.BindBufferBase(GL_UNIFORM_BUFFER, BLOCK_EVALUATE, uniforms.id());
      const Buffer *buffers[] = {&inputs, &listed, &results};
      for (GLuint i = 0; i < 3; ++i) gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, i, buffers[i]->id());
      gl.DispatchCompute(static_cast<GLuint>(all.size()), 1, 1);
      gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
      gl.GetNamedBufferSubData(results.id(), static_cast<GLintptr>(ROW_DESCRIPTORS * all.size() * sizeof(float)),
                               static_cast<GLsizeiptr>(raw.size() * sizeof(float)), raw.data());
      check_gl(gl, "kernels");
    });
    std::vector<std::vector<float>> values(all.size());
    for (size_t i = 0; i < all.size(); ++i)
      for (size_t k = 0; k < width; ++k) values[i].push_back(raw[k * all.size() + i]);
    return values;
  }

  // part: of what is usual; the device rounds square roots and exponentials, and orders products, in a way of its own.
  template <template <class, class> class Kernel> void expect_the_same(const Variant &variant, double part) const {
    const std::vector<Recorded> all = recorded_neighborhoods();
    const std::vector<std::vector<float>> device = compute(all, variant);
    int existing = 0;
    for (size_t i = 0; i < all.size(); ++i) {
      SCOPED_TRACE(all[i].name);
      existing += expect_like(one_at_a_time<Kernel>(all[i]), device[i], usual_values(), part);
      expect_like(eight_at_a_time<Kernel>(all[i]), device[i], usual_values(), part);
    }
    EXPECT_GT(existing, 200) << "values that exist";
  }
};

TEST_F(KernelsOnDevice, are_those_of_cpp_by_the_shape_operator) {
  expect_the_same<kernels::ShapeOperatorKernel>({.integral = false, .extrapolated = false, .geodesic_ball = false, .faces = true},
                                                1e-5);
}
TEST_F(KernelsOnDevice, are_those_of_cpp_by_the_integrals_in_a_ball_along_the_surface) {
  expect_the_same<kernels::IntegralKernel>({.integral = true, .extrapolated = false, .geodesic_ball = true, .faces = true}, 5e-5);
}
TEST_F(KernelsOnDevice, are_those_of_cpp_by_two_windows_without_faces) {
  expect_the_same<kernels::ExtrapolatedKernel>({.integral = false, .extrapolated = true, .geodesic_ball = false, .faces = false},
                                               1e-4);
}

} // namespace
} // namespace paradesc::test
