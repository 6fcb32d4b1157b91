/* Loads libparadesc as a host does and times frames of mean curvature on a torus of 70,000 triangles, by the processor: new
 * positions, 2 % of the diagonal, the defaults, values at vertices.
 *   frame_times LIBRARY [THREADS]
 * Prints the milliseconds of the fastest frame. */
#include <time.h>

#include "loaded.h"
#include "torus.h"

enum { AROUND = 250, ACROSS = 140, VERTICES = AROUND * ACROSS, TRIANGLES = 2 * VERTICES, FRAMES = 12 };
static float positions[3 * VERTICES], values[VERTICES];
static int32_t corner_vertices[3 * TRIANGLES], triangle_corners[3 * TRIANGLES];

static double milliseconds(void) {
#if defined(_WIN32)
  LARGE_INTEGER now, frequency;
  QueryPerformanceCounter(&now);
  QueryPerformanceFrequency(&frequency);
  return 1e3 * (double)now.QuadPart / (double)frequency.QuadPart;
#else
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return 1e3 * (double)now.tv_sec + 1e-6 * (double)now.tv_nsec;
#endif
}

static void make_torus(void) {
  for (int i = 0; i < AROUND; ++i)
    for (int j = 0; j < ACROSS; ++j) {
      const int at = i * ACROSS + j, next = (i + 1) % AROUND * ACROSS, up = (j + 1) % ACROSS;
      const int32_t cell[6] = {at, next + j, i * ACROSS + up, i * ACROSS + up, next + j, next + up};
      on_torus(i, AROUND, j, ACROSS, positions + 3 * at);
      memcpy(corner_vertices + 6 * at, cell, sizeof cell);
    }
  for (int32_t i = 0; i < 3 * TRIANGLES; ++i) triangle_corners[i] = i;
}

/* Returns its milliseconds, or a number below 0. */
static double time_frame(pdesc_mesh *mesh, const pdesc_options *options) {
  static const char *const names[] = {"mean_curvature"};
  pdesc_field *field = NULL;
  const double start = milliseconds();
  if (call(pdesc_mesh_set_positions)(mesh, positions, VERTICES)) return -1.0;
  if (call(pdesc_compute)(mesh, options, names, 1, NULL, NULL, &field)) return -1.0;
  if (call(pdesc_field_values)(field, names[0], values, VERTICES)) return -1.0;
  const double taken = milliseconds() - start;
  call(pdesc_field_destroy)(field);
  return taken;
}

int main(int argc, char **argv) {
  pdesc_context *const context = open_backend(argc > 1 ? argv[1] : NULL, PDESC_BACKEND_CPU, argc > 2 ? atoi(argv[2]) : 0);
  if (!context) return 1;
  pdesc_options options;
  make_torus();
  pdesc_mesh *mesh = make_mesh(context, (triangles_t){VERTICES, TRIANGLES, positions, NULL, corner_vertices, triangle_corners});
  if (!mesh) return 1;
  call(pdesc_options_init)(&options);
  double fastest = 1e300;
  for (int frame = 0; frame < FRAMES; ++frame) {
    positions[0] += 1e-6f; /* a mesh that stays keeps what belongs to its positions */
    const double taken = time_frame(mesh, &options);
    if (taken < 0.0) return fail("frame");
    if (taken < fastest) fastest = taken;
  }
  printf("%.2f\n", fastest);
  call(pdesc_mesh_destroy)(mesh);
  call(pdesc_context_destroy)(context);
  return 0;
}
