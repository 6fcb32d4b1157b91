// A mesh's file → mean curvature in object space at some of its vertices, and what it took: by the baseline (times), or by the
// reference (errors).
//
//   paradesc_object_space baseline|reference|both MESH RADIUS [seconds S] [points N] [normals fitted|max] [threads N]
//                         [baseline_values FILE] [reference_values FILE]
//
// RADIUS is in units of the positions. The baseline does as many vertices as it can in `seconds`, twice, and the faster run
// counts; the reference about `points`, drawn at random; all without these words. A FILE gets int32 n, n int32 vertices, n float
// values. Each method prints a line of JSON.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <exception>
#include <map>
#include <numeric>
#include <random>
#include <string>

#include "bench/baseline.h"
#include "bench/mesh_file.h"
#include "descriptor/registry.h"
#include "engine/reference/reference.h"
#include "support/parallel.h"

namespace paradesc::bench {
namespace {

using Words = std::map<std::string, std::string>;

double number(const Words &words, const char *name, double otherwise) {
  const auto found = words.find(name);
  return found == words.end() ? otherwise : std::stod(found->second);
}

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

struct Surface {
  Triangles triangles;
  HalfEdges half_edges;
  Normals normals;
};

Surface read_surface(const std::string &path, int32_t normals, int threads) {
  const test::TestMesh mesh = read_mesh(path);
  Surface surface;
  surface.triangles = read_triangles(test::input_of(mesh));
  surface.half_edges = build_half_edges(surface.triangles);
  const NormalRings rings = build_normal_rings(surface.triangles, surface.half_edges, threads);
  surface.normals = compute_normals(surface.triangles, surface.half_edges, rings, normals, threads);
  return surface;
}

void write_if_asked(const Words &words, const char *name, const std::vector<int32_t> &vertices,
                    const std::vector<float> &values) {
  const auto found = words.find(name);
  if (found != words.end()) write_values(found->second, vertices, values);
}

// Seconds are those of all points; of the baseline extrapolated from those that were timed.
void print(const char *method, int64_t points, size_t done, const BaselineRun &run, int threads, double setup) {
  const double count = static_cast<double>(std::max<size_t>(done, 1));
  const double all = static_cast<double>(points) / count, neighbors = static_cast<double>(run.neighbors);
  std::printf("{\"method\": \"%s\", \"points\": %lld, \"points_timed\": %zu, \"seconds_timed\": %.6f, \"seconds\": %.6f, "
              "\"cpu_seconds\": %.6f, \"neighbors_per_point\": %.1f, \"neighbors_per_second_and_core\": %.0f, "
              "\"neighbors_per_cpu_second\": %.0f, \"threads\": %d, \"seconds_setup\": %.3f}\n",
              method, static_cast<long long>(points), done, run.seconds, run.seconds * all, run.cpu_seconds * all,
              neighbors / count, neighbors / run.seconds / threads, neighbors / run.cpu_seconds, threads, setup);
}

void baseline(const Words &words, const Surface &surface, double radius, int threads, double start) {
  constexpr int pilot = 2048;
  const BaselineSurface made = build_baseline(surface.triangles, surface.half_edges, surface.normals.point);
  const double setup = now() - start;
  std::vector<int32_t> requested = choose_points(made, pilot, 1);
  std::vector<float> values(requested.size());
  run_baseline(made, radius, requested, threads, values); // brings threads and memory up
  const BaselineRun first = run_baseline(made, radius, requested, threads, values);
  const double limit = number(words, "seconds", 0.0);
  const double wanted = limit > 0.0 ? limit / first.seconds * static_cast<double>(requested.size()) : 0.0;
  requested = choose_points(made, static_cast<int>(std::min(wanted, 2e9)), 2);
  values.resize(requested.size());
  const BaselineRun once = run_baseline(made, radius, requested, threads, values);
  const BaselineRun again = run_baseline(made, radius, requested, threads, values);
  const BaselineRun &run = again.seconds < once.seconds ? again : once;
  print("baseline", surface.half_edges.point_count, requested.size(), run, threads, setup);
  std::vector<int32_t> vertices;
  for (const int32_t point : requested)
    vertices.push_back(surface.half_edges.point_vertex[static_cast<size_t>(made.origin[static_cast<size_t>(point)])]);
  write_if_asked(words, "baseline_values", vertices, values);
}

void reference(const Words &words, const Surface &surface, double radius, int threads, double start) {
  std::vector<int32_t> points(static_cast<size_t>(surface.half_edges.point_count));
  std::iota(points.begin(), points.end(), 0);
  std::mt19937 engine(3);
  for (size_t i = points.size(); i > 1; --i) std::swap(points[i - 1], points[engine() % i]);
  const auto wanted = static_cast<size_t>(number(words, "points", 0.0));
  if (wanted > 0 && wanted < points.size()) points.resize(wanted);
  const int row = find_descriptor("mean_curvature");
  ReferenceSettings settings{radius};
  settings.points = points;
  const double setup = now() - start;
  const std::clock_t cpu_start = std::clock();
  const ReferenceField field = compute_reference(surface.triangles, surface.half_edges, surface.normals, settings,
                                                 std::span(&row, 1), threads, [](double) { return true; });
  const BaselineRun run{0, now() - start - setup, static_cast<double>(std::clock() - cpu_start) / CLOCKS_PER_SEC};
  print("reference", surface.half_edges.point_count, points.size(), run, threads, setup);
  std::vector<int32_t> vertices;
  std::vector<float> values;
  for (const int32_t point : points) {
    vertices.push_back(surface.half_edges.point_vertex[static_cast<size_t>(point)]);
    values.push_back(field.values[0][static_cast<size_t>(point)]);
  }
  write_if_asked(words, "reference_values", vertices, values);
}

int run(int count, char **arguments) {
  if (count < 4 || count % 2 != 0)
    throw std::runtime_error("Give baseline, reference or both, a mesh's file, the radius, and pairs of words.");
  const std::string method = arguments[1];
  Words words;
  for (int i = 4; i < count; i += 2) words[arguments[i]] = arguments[i + 1];
  const int threads = thread_count(static_cast<int>(number(words, "threads", 0.0)));
  const bool fitted = !words.contains("normals") || words.at("normals") == "fitted";
  const double start = now();
  const Surface surface = read_surface(arguments[2], fitted ? PDESC_NORMALS_FITTED : PDESC_NORMALS_MAX, threads);
  const double radius = std::stod(arguments[3]);
  if (method != "reference") baseline(words, surface, radius, threads, start);
  if (method != "baseline") reference(words, surface, radius, threads, now());
  return 0;
}

} // namespace
} // namespace paradesc::bench

int main(int count, char **arguments) {
  try {
    return paradesc::bench::run(count, arguments);
  } catch (const std::exception &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
