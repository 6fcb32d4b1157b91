/* Loads libparadesc as a host does and prints descriptors at the vertices of a sphere of radius 2, by the processor:
 *   sphere_curvature LIBRARY
 * Built for two systems, it has to print the same numbers on both. */
#include <math.h>

#include "loaded.h"

enum { RINGS = 16, SEGMENTS = 24, VERTICES = (RINGS + 1) * SEGMENTS, TRIANGLES = 2 * RINGS * SEGMENTS };
static float positions[3 * VERTICES], values[VERTICES];
static int32_t corner_vertices[3 * TRIANGLES], triangle_corners[3 * TRIANGLES];

/* A sphere open at its poles, of two triangles a cell. */
static void make_sphere(void) {
  const double pi = 3.14159265358979323846;
  int32_t *corner = corner_vertices;
  for (int ring = 0; ring <= RINGS; ++ring)
    for (int segment = 0; segment < SEGMENTS; ++segment) {
      const double polar = 0.15 + (pi - 0.3) * ring / RINGS, turn = 2.0 * pi * segment / SEGMENTS;
      float *position = positions + 3 * (ring * SEGMENTS + segment);
      position[0] = (float)(2.0 * sin(polar) * cos(turn));
      position[1] = (float)(2.0 * sin(polar) * sin(turn));
      position[2] = (float)(2.0 * cos(polar));
    }
  for (int ring = 0; ring < RINGS; ++ring)
    for (int segment = 0; segment < SEGMENTS; ++segment) {
      const int32_t a = ring * SEGMENTS + segment, b = ring * SEGMENTS + (segment + 1) % SEGMENTS;
      const int32_t cell[6] = {a, a + SEGMENTS, b, b, a + SEGMENTS, b + SEGMENTS};
      for (int i = 0; i < 6; ++i) *corner++ = cell[i];
    }
  for (int i = 0; i < 3 * TRIANGLES; ++i) triangle_corners[i] = i;
}

int main(int argc, char **argv) {
  static const char *const names[] = {"mean_curvature", "gaussian_curvature", "sphere_volume"};
  const library_t library = argc == 2 ? open_library(argv[1]) : NULL;
  if (!library || !find_functions(library)) return fprintf(stderr, "cannot load the library\n"), 1;

  pdesc_context_options context_options;
  pdesc_context *context = NULL;
  call(pdesc_context_options_init)(&context_options); /* auto: the processor, with or without a device */
#if !defined(_WIN32)
  context_options.backend = PDESC_BACKEND_CPU;
#endif
  if (call(pdesc_context_create)(&context_options, &context)) return fail("context");

  make_sphere();
  pdesc_mesh *mesh = make_mesh(context, (triangles_t){VERTICES, TRIANGLES, positions, NULL, corner_vertices, triangle_corners});
  if (!mesh) return 1;

  pdesc_options options;
  pdesc_field *field = NULL;
  call(pdesc_options_init)(&options);
  options.radius = 0.2;
  if (call(pdesc_compute)(mesh, &options, names, 3, NULL, NULL, &field)) return fail("compute");
  printf("version %s\ndevice %s\n", call(pdesc_version)(), call(pdesc_context_device)(context));
  for (int i = 0; i < 3; ++i) {
    if (call(pdesc_field_values)(field, names[i], values, VERTICES)) return fail(names[i]);
    printf("%s", names[i]);
    for (int v = 0; v < VERTICES; ++v) printf(" %.9g", (double)values[v]);
    printf("\n");
  }
  call(pdesc_field_destroy)(field);
  call(pdesc_mesh_destroy)(mesh);
  call(pdesc_context_destroy)(context);
  return 0;
}
