// The texture fetches of an evaluation and nothing else: how fast any evaluation of so many samples could be on this device.
//
// PARADESC_BENCH_MESH names the mesh (mesh_file.h) at whose vertices' (u, v) is fetched; PARADESC_BENCH_TEXELS says what the
// radius is in texels, PARADESC_BENCH_SIZE and PARADESC_BENCH_SAMPLES the buffer's size and the samples. Position and normal are
// fetched at each sample, RGBA32F, from buffers of noise. gpu_ms is the device's own timer, where the driver has one.
#include <cstdlib>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>

#include <EGL/egl.h>
#include <benchmark/benchmark.h>
#include <dlfcn.h>

#include "bench/mesh_file.h"
#include "engine/opengl/buffer.h"
#include "engine/opengl/gl_thread.h"
#include "sample/pattern.h"

namespace paradesc::bench {
namespace {

constexpr int group_size = 16;

double setting(const char *name, double otherwise) {
  const char *text = std::getenv(name);
  return text ? std::stod(text) : otherwise;
}

// GL_TIME_ELAPSED around a dispatch; the library itself has no need of it.
class Timer {
public:
  explicit Timer(const Gl &gl) {
    void *egl = dlopen("libEGL.so.1", RTLD_NOW | RTLD_NOLOAD);
    auto address = reinterpret_cast<decltype(&eglGetProcAddress)>(egl ? dlsym(egl, "eglGetProcAddress") : nullptr);
    if (!address) return;
    create_ = reinterpret_cast<PFNGLCREATEQUERIESPROC>(address("glCreateQueries"));
    begin_ = reinterpret_cast<PFNGLBEGINQUERYPROC>(address("glBeginQuery"));
    end_ = reinterpret_cast<PFNGLENDQUERYPROC>(address("glEndQuery"));
    result_ = reinterpret_cast<PFNGLGETQUERYOBJECTUI64VPROC>(address("glGetQueryObjectui64v"));
    if (create_ && begin_ && end_ && result_) create_(GL_TIME_ELAPSED, 1, &query_);
    check_gl(gl, "timer query");
  }
  void begin() const {
    if (query_) begin_(GL_TIME_ELAPSED, query_);
  }
  // Milliseconds; waits for the device.
  double end() const {
    if (!query_) return 0.0;
    end_(GL_TIME_ELAPSED);
    GLuint64 nanoseconds = 0;
    result_(query_, GL_QUERY_RESULT, &nanoseconds);
    return 1e-6 * static_cast<double>(nanoseconds);
  }

private:
  PFNGLCREATEQUERIESPROC create_ = nullptr;
  PFNGLBEGINQUERYPROC begin_ = nullptr;
  PFNGLENDQUERYPROC end_ = nullptr;
  PFNGLGETQUERYOBJECTUI64VPROC result_ = nullptr;
  GLuint query_ = 0;
};

std::string shader(const std::string &fetch) {
  return "#version 450\n"
         "layout(local_size_x = " +
         std::to_string(group_size) +
         ") in;\n"
         "layout(binding = 1) uniform sampler2D position;\n"
         "layout(binding = 2) uniform sampler2D normal;\n"
         "layout(std430, binding = 0) readonly restrict buffer Centers { vec2 centers[]; };\n"
         "layout(std430, binding = 1) readonly restrict buffer Pattern { vec2 pattern[]; };\n"
         "layout(std430, binding = 2) writeonly restrict buffer Results { vec4 results[]; };\n"
         "layout(location = 0) uniform int count;\n"
         "layout(location = 1) uniform int samples;\n"
         "layout(location = 2) uniform int size;\n"
         "layout(location = 3) uniform float radius;\n"
         "void main() {\n"
         "  int index = int(gl_GlobalInvocationID.x);\n"
         "  if (index >= count) return;\n"
         "  vec2 center = centers[index] * float(size);\n"
         "  vec4 sum = vec4(0.0);\n"
         "  for (int i = 0; i < samples; ++i) {\n"
         "    vec2 spot = center + radius * pattern[i];\n" +
         fetch +
         "  }\n"
         "  results[index] = sum;\n"
         "}\n";
}

constexpr const char *texel_fetch = "    ivec2 texel = ivec2(spot) & (size - 1);\n"
                                    "    sum += texelFetch(position, texel, 0) + texelFetch(normal, texel, 0);\n";
constexpr const char *texture_lod = "    vec2 uv = spot / float(size);\n"
                                    "    sum += textureLod(position, uv, 0.0) + textureLod(normal, uv, 0.0);\n";

GLuint compile(const Gl &gl, const std::string &text) {
  const GLuint made = gl.CreateShader(GL_COMPUTE_SHADER), program = gl.CreateProgram();
  const char *source = text.c_str();
  gl.ShaderSource(made, 1, &source, nullptr);
  gl.CompileShader(made);
  gl.AttachShader(program, made);
  gl.LinkProgram(program);
  gl.DeleteShader(made);
  GLint linked = 0;
  gl.GetProgramiv(program, GL_LINK_STATUS, &linked);
  if (!linked) throw std::runtime_error("The gather's program does not link.");
  return program;
}

// Everything on the device, made once; left to the process's end, as the thread is.
struct Device {
  GlThread thread{std::getenv("PARADESC_BENCH_GPU") == nullptr, -1};
  std::unique_ptr<Timer> timer;
  Texture position, normal;
  Buffer centers, pattern, results;
  int size = 0, count = 0, samples = 0;
  float radius = 0.0f;
};

Texture noise(const Gl &gl, int size) {
  Texture texture(gl, size, size, GL_RGBA32F);
  std::mt19937 engine(1);
  std::vector<float> values(4 * static_cast<size_t>(size) * static_cast<size_t>(size));
  for (float &value : values) value = static_cast<float>(engine()) / 4294967296.0f;
  gl.TextureSubImage2D(texture.id(), 0, 0, 0, size, size, GL_RGBA, GL_FLOAT, values.data());
  return texture;
}

// (u, v) of one wedge of each vertex.
std::vector<vec2> uvs_of(const test::TestMesh &mesh) {
  std::vector<vec2> uvs(static_cast<size_t>(mesh.vertex_count), vec2(0.5f));
  for (size_t c = 0; c < mesh.corner_vertices.size(); ++c)
    uvs[static_cast<size_t>(mesh.corner_vertices[c])] = {mesh.corner_uvs[2 * c], mesh.corner_uvs[2 * c + 1]};
  return uvs;
}

Device &device() {
  static Device *once = [] {
    const char *path = std::getenv("PARADESC_BENCH_MESH");
    if (!path) throw std::runtime_error("PARADESC_BENCH_MESH names no mesh.");
    const std::vector<vec2> uvs = uvs_of(read_mesh(path));
    auto *made = new Device;
    made->size = static_cast<int>(setting("PARADESC_BENCH_SIZE", 1024));
    made->samples = static_cast<int>(setting("PARADESC_BENCH_SAMPLES", 256));
    made->radius = static_cast<float>(setting("PARADESC_BENCH_TEXELS", 12));
    made->count = static_cast<int>(uvs.size());
    made->thread.run([&](const Gl &gl, ProgramCache &) {
      made->timer = std::make_unique<Timer>(gl);
      made->position = noise(gl, made->size);
      made->normal = noise(gl, made->size);
      made->centers.upload(gl, uvs);
      made->pattern.upload(gl, golden_angle_pattern(made->samples));
      made->results.upload(gl, nullptr, 16 * uvs.size());
    });
    return made;
  }();
  return *once;
}

double dispatch(const Gl &gl, const Device &on, GLuint program) {
  gl.UseProgram(program);
  gl.BindTextureUnit(1, on.position.id());
  gl.BindTextureUnit(2, on.normal.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, on.centers.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, on.pattern.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, on.results.id());
  gl.Uniform1i(0, on.count);
  gl.Uniform1i(1, on.samples);
  gl.Uniform1i(2, on.size);
  gl.Uniform1f(3, on.radius);
  on.timer->begin();
  gl.DispatchCompute(static_cast<GLuint>((on.count + group_size - 1) / group_size), 1, 1);
  const double milliseconds = on.timer->end();
  gl.Finish();
  check_gl(gl, "gather");
  return milliseconds;
}

void measure(benchmark::State &state, const char *fetch) {
  try {
    Device &on = device();
    GLuint program = 0;
    on.thread.run([&](const Gl &gl, ProgramCache &) { dispatch(gl, on, program = compile(gl, shader(fetch))); });
    double shortest = 1e30;
    for (auto _ : state)
      on.thread.run([&](const Gl &gl, ProgramCache &) { shortest = std::min(shortest, dispatch(gl, on, program)); });
    if (shortest > 1e-3) state.counters["gpu_ms"] = shortest; // llvmpipe's timer sees rasterizing only
    state.counters["fetches"] =
        benchmark::Counter(static_cast<double>(on.count) * on.samples, benchmark::Counter::kIsIterationInvariantRate);
  } catch (const std::exception &error) {
    state.SkipWithError(error.what());
  }
}

void gather_by_texel_fetch(benchmark::State &state) { measure(state, texel_fetch); }
void gather_by_texture_lod(benchmark::State &state) { measure(state, texture_lod); }
BENCHMARK(gather_by_texel_fetch)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();
BENCHMARK(gather_by_texture_lod)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();

} // namespace
} // namespace paradesc::bench

BENCHMARK_MAIN();
