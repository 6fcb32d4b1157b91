// A mesh's file → what a frame in texture space asks of the processor, whatever the device does, as one line of JSON.
//
//   paradesc_frame_host MESH RADIUS [software|gpu] [FRAMES]
//
// RADIUS is a part of the diagonal. A frame is what a mesh costs that has moved: from new positions to mean curvature at every
// vertex, with default options. Host time is the processor time of the library's threads outside OpenGL's calls: a software
// device works within them, and in threads of its own. What it takes to look at the clock around each call, which is measured
// first, is not counted. A device is waited for where results are read back, or where a call
// returns when it has finished. The median of all frames counts.
#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <ctime>
#include <exception>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include <unistd.h>

#include "bench/mesh_file.h"
#include "compute/compute.h"
#include "context.h"
#include "descriptor/registry.h"
#include "engine/opengl/gl.h"
#include "engine/opengl/gl_thread.h"
#include "support/parallel.h"

namespace paradesc::bench {
namespace {

double seconds_of(clockid_t clock) {
  timespec now{};
  return clock_gettime(clock, &now) == 0 ? static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec) : 0.0;
}

// ---- Processor time

// The library's threads: those that are there before a device is opened, and the one that calls it. All others are the driver's.
std::set<int> own_threads;
std::vector<int> driver_threads; // once a frame has been computed
std::atomic<int> calling_thread = 0;

std::set<int> threads_now() {
  std::set<int> numbers;
  for (const auto &task : std::filesystem::directory_iterator("/proc/self/task"))
    numbers.insert(std::stoi(task.path().filename().string()));
  return numbers;
}

// Workers are started before the device is opened.
void start_workers() {
  parallel_blocks(1 << 16, 0, 1, [](int, int) {});
  own_threads = threads_now();
}

void find_driver_threads() {
  driver_threads.clear();
  for (const int number : threads_now())
    if (!own_threads.contains(number) && number != calling_thread) driver_threads.push_back(number);
}

double seconds_of_driver_threads() {
  constexpr clockid_t of_thread = 6; // as pthread_getcpuclockid makes it, of a thread's number
  double seconds = 0.0;
  for (const int number : driver_threads) seconds += seconds_of(~number * 8 | of_thread);
  return seconds;
}

// ---- OpenGL's calls, which one thread makes

struct Calls {
  int count = 0;
  double seconds = 0.0; // of that thread
};
std::map<std::string, Calls> calls; // by the entry point's name

// Adds a call, and what it takes until the end of the scope.
struct Stopwatch {
  Calls &calls;
  double start = seconds_of(CLOCK_THREAD_CPUTIME_ID);
  ~Stopwatch() {
    calls.seconds += seconds_of(CLOCK_THREAD_CPUTIME_ID) - start;
    ++calls.count;
  }
};

// What a stopwatch takes besides what it counts.
double seconds_of_stopwatch() {
  static const double once = [] {
    Calls none;
    const double start = seconds_of(CLOCK_THREAD_CPUTIME_ID);
    for (int i = 0; i < 100000; ++i) const Stopwatch stopwatch{none};
    return (seconds_of(CLOCK_THREAD_CPUTIME_ID) - start - none.seconds) / none.count;
  }();
  return once;
}

// Entry points are functions of C, and have no state of their own: each has a type.
template <class Function, class Name> struct Entry;
template <class Result, class... Arguments, class Name> struct Entry<Result(APIENTRY *)(Arguments...), Name> {
  static inline Result(APIENTRY *real)(Arguments...) = nullptr;
  static inline Calls *found = nullptr;
  static Result APIENTRY call(Arguments... arguments) {
    if (calling_thread == 0) calling_thread = gettid();
    const Stopwatch stopwatch{*found};
    return real(arguments...);
  }
  static void *timed(const std::string &name, void *driver) {
    real = reinterpret_cast<Result(APIENTRY *)(Arguments...)>(driver);
    found = &calls[name];
    return reinterpret_cast<void *>(&call);
  }
};

void *timed(const char *name, void *driver) {
  const std::string wanted = name;
  if (!driver) return driver;
#define PARADESC_TIMED(type, member)                                                                                             \
  struct Name##member;                                                                                                           \
  if (wanted == "gl" #member) return Entry<type, Name##member>::timed(wanted, driver);
  PARADESC_GL_FUNCTIONS(PARADESC_TIMED)
#undef PARADESC_TIMED
  return driver;
}

bool reads_back(const std::string &name) {
  constexpr std::array kinds = {"glGetNamedBufferSubData", "glGetTextureImage", "glReadPixels", "glMapNamedBuffer"};
  return std::ranges::any_of(kinds, [&](const char *kind) { return name.starts_with(kind); });
}

bool waits(const std::string &name) {
  return reads_back(name) || name == "glFinish" || name == "glClientWaitSync" || name.starts_with("glGetQueryObject");
}

// ---- Frames

// Seconds at a moment between frames, or from one to another.
struct Taken {
  double wall, processor, driver_threads, in_calls, watching;
  double host() const { return processor - driver_threads - in_calls - watching; }
};

Taken now() {
  double in_calls = 0.0;
  int stopped = 0;
  for (const auto &[name, made] : calls) {
    in_calls += made.seconds;
    stopped += made.count;
  }
  return {seconds_of(CLOCK_MONOTONIC), seconds_of(CLOCK_PROCESS_CPUTIME_ID), seconds_of_driver_threads(), in_calls,
          stopped * seconds_of_stopwatch()};
}

struct Frame {
  Taken taken;
  std::map<std::string, Calls> made;

  template <class Kind> int count(const Kind &kind) const {
    int all = 0;
    for (const auto &[name, one] : made)
      if (kind(name)) all += one.count;
    return all;
  }
};

class Moving {
public:
  Moving(const std::string &path, double radius, int32_t backend) : mesh_(read_mesh(path)) {
    pdesc_context_options requested;
    pdesc_context_options_init(&requested);
    requested.backend = backend;
    pdesc_options_init(&options_);
    options_.radius = radius;
    options_.radius_unit = PDESC_RADIUS_DIAGONAL;
    start_workers();
    context_ = make_context(requested, timed);
    native_ = make_mesh(context_, test::input_of(mesh_));
    moved_ = mesh_.positions;
    for (float &coordinate : moved_) coordinate *= 1.0f + 1e-5f;
  }

  const char *device() const { return context_->device.load(); }

  Frame run(int turn) {
    const std::array rows = {find_descriptor("mean_curvature")};
    calls_before_ = calls;
    const Taken before = now();
    move_mesh(*native_, turn % 2 ? moved_.data() : mesh_.positions.data(), mesh_.vertex_count);
    const Field field = compute(*native_, options_, rows, [](const char *, double) { return true; });
    const Taken after = now();
    Frame frame{{after.wall - before.wall, after.processor - before.processor, after.driver_threads - before.driver_threads,
                 after.in_calls - before.in_calls, after.watching - before.watching},
                {}};
    for (const auto &[name, made] : calls)
      if (const Calls &old = calls_before_[name]; made.count > old.count)
        frame.made[name] = {made.count - old.count, made.seconds - old.seconds};
    return frame;
  }

private:
  test::TestMesh mesh_;
  std::vector<float> moved_;
  pdesc_options options_;
  Workers workers_;
  Workers::Scope helped_{workers_};
  std::shared_ptr<Context> context_;
  std::unique_ptr<Mesh> native_;
  std::map<std::string, Calls> calls_before_;
};

// The driver's own words.
std::string driver_of(bool gpu) {
  std::string version;
  GlThread(!gpu, -1).run(
      [&](const Gl &gl, ProgramCache &) { version = reinterpret_cast<const char *>(gl.GetString(GL_VERSION)); });
  return version;
}

void print(const char *device, const std::string &driver, const std::vector<Frame> &frames) {
  const Frame &one = frames[frames.size() / 2];
  std::printf("{\"device\": \"%s\", \"driver\": \"%s\", \"frames\": %zu, \"host_ms\": %.3f, \"least_host_ms\": %.3f, "
              "\"in_calls_ms\": %.3f, "
              "\"driver_threads_ms\": %.3f, \"wall_ms\": %.3f, \"read_backs\": %d, \"waits\": %d, \"calls\": {",
              device, driver.c_str(), frames.size(), 1e3 * one.taken.host(), 1e3 * frames[0].taken.host(),
              1e3 * one.taken.in_calls, 1e3 * one.taken.driver_threads, 1e3 * one.taken.wall, one.count(reads_back),
              one.count(waits));
  const char *comma = "";
  for (const auto &[name, made] : one.made) {
    std::printf("%s\"%s\": [%d, %.3f]", comma, name.c_str(), made.count, 1e3 * made.seconds);
    comma = ", ";
  }
  std::printf("}}\n");
}

void run(int count, char **words) {
  if (count < 3) throw std::runtime_error("Give a mesh's file and a radius as a part of the diagonal.");
  const bool gpu = count > 3 && std::string(words[3]) == "gpu";
  const int wanted = count > 4 ? std::max(1, std::stoi(words[4])) : 5;
  Moving moving(words[1], std::stod(words[2]), gpu ? PDESC_BACKEND_GPU : PDESC_BACKEND_SOFTWARE);
  for (const int turn : {0, 1}) moving.run(turn); // what is made once, and what only a mesh that moves keeps
  find_driver_threads();
  std::vector<Frame> frames;
  for (int turn = 0; turn < wanted; ++turn) frames.push_back(moving.run(turn));
  std::ranges::sort(frames, {}, [](const Frame &frame) { return frame.taken.host(); });
  print(moving.device(), driver_of(gpu), frames);
}

} // namespace
} // namespace paradesc::bench

int main(int count, char **words) {
  try {
    paradesc::bench::run(count, words);
    return 0;
  } catch (const std::exception &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
