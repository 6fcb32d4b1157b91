/* Loads libparadesc as a host does and prints a hash of the bits of every descriptor on generated meshes, by the engine on the
 * CPU with every estimator, distance and kind of normals, and at texels of a map whose charts lie upon each other:
 *   bits LIBRARY [THREADS]
 *   bits LIBRARY software      by OpenGL without a card instead, with what texture space alone has: the shapes that have a map
 * Every system, processor, compiler and number of threads has to print the same lines; every system with one software device,
 * too. The meshes are made of sums, products, quotients and square roots alone, which IEEE 754 determines; a NaN is one whatever
 * its bits are. */
#include <math.h>

#include "loaded.h"
#include "torus.h"

enum { SIDE = 8, ACROSS = 12, AROUND = 24, CELLS = 6 * SIDE * SIDE > ACROSS *AROUND ? 6 * SIDE *SIDE : ACROSS *AROUND };
enum { MOST_VERTICES = 6 * (SIDE + 1) * (SIDE + 1), MOST_DESCRIPTORS = 64 };

typedef struct {
  int vertices, triangles;
  float positions[3 * MOST_VERTICES], uvs[2 * MOST_VERTICES], corner_uvs[2 * 6 * CELLS];
  int32_t corner_vertices[6 * CELLS], triangle_corners[6 * CELLS];
} grid;

static grid made;
static float values[3 * MOST_VERTICES];

static void add_cell(int32_t a, int32_t b, int32_t c, int32_t d) {
  const int32_t cell[6] = {a, b, c, c, b, d};
  for (int i = 0; i < 6; ++i) {
    const int corner = 3 * made.triangles + i;
    made.corner_vertices[corner] = cell[i];
    made.triangle_corners[corner] = corner;
  }
  made.triangles += 2;
}

static void add_vertex(double x, double y, double z) {
  float *position = made.positions + 3 * made.vertices++;
  position[0] = (float)x;
  position[1] = (float)y;
  position[2] = (float)z;
}

static void make_torus(void) {
  made.vertices = made.triangles = 0;
  for (int i = 0; i < AROUND; ++i)
    for (int j = 0; j < ACROSS; ++j) {
      on_torus(i, AROUND, j, ACROSS, made.positions + 3 * made.vertices++);
      const int next = (i + 1) % AROUND * ACROSS, up = (j + 1) % ACROSS;
      add_cell(i * ACROSS + j, next + j, i * ACROSS + up, next + up);
    }
}

/* Six faces of a cube, welded by their positions; on an ellipsoid if they are rounded. Each has the same place in the map. */
static void make_block(int rounded) {
  static const int axes[6][2] = {{1, 2}, {2, 1}, {2, 0}, {0, 2}, {0, 1}, {1, 0}};
  made.vertices = made.triangles = 0;
  for (int face = 0; face < 6; ++face) {
    const int first = made.vertices, u = axes[face][0], v = axes[face][1];
    for (int i = 0; i <= SIDE; ++i)
      for (int j = 0; j <= SIDE; ++j) {
        double p[3];
        p[3 - u - v] = face % 2 ? -1.0 : 1.0;
        p[u] = 2.0 * i / SIDE - 1.0;
        p[v] = 2.0 * j / SIDE - 1.0;
        const double length = rounded ? sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) : 1.0;
        add_vertex(p[0] / length, (rounded ? 0.75 : 1.0) * p[1] / length, (rounded ? 0.5 : 1.0) * p[2] / length);
        const int32_t at = first + i * (SIDE + 1) + j;
        made.uvs[2 * at] = (float)i / SIDE;
        made.uvs[2 * at + 1] = (float)j / SIDE;
        if (i < SIDE && j < SIDE) add_cell(at, at + SIDE + 1, at + 1, at + SIDE + 2);
      }
  }
}

static uint64_t hash(const float *bits, int count) {
  uint64_t state = 14695981039346656037u; /* FNV-1a */
  for (int i = 0; i < count; ++i) {
    uint32_t word = 0x7fc00000u;
    if (bits[i] == bits[i]) memcpy(&word, bits + i, sizeof word);
    for (int byte = 0; byte < 4; ++byte) state = (state ^ (word >> 8 * byte & 255u)) * 1099511628211u;
  }
  return state;
}

static int print_bits(pdesc_mesh *mesh, const char *shape, const pdesc_options *options) {
  static const char *names[MOST_DESCRIPTORS];
  int32_t widths[MOST_DESCRIPTORS];
  const int32_t count = call(pdesc_descriptor_count)();
  for (int32_t i = 0; i < count && i < MOST_DESCRIPTORS; ++i) {
    pdesc_descriptor_info info;
    call(pdesc_descriptor_info_init)(&info);
    if (call(pdesc_descriptor_get)(i, &info)) return fail("descriptor");
    names[i] = info.name;
    widths[i] = info.components;
  }
  pdesc_field *field = NULL;
  if (call(pdesc_compute)(mesh, options, names, count, NULL, NULL, &field)) return fail("compute");
  for (int32_t i = 0; i < count; ++i) {
    if (call(pdesc_field_values)(field, names[i], values, made.vertices)) return fail(names[i]);
    printf("%s estimator %d distance %d normals %d evaluate %d relocation %d precision %d %s %016llx\n", shape,
           options->estimator, options->distance, options->normals, options->evaluate, options->relocation, options->precision,
           names[i], (unsigned long long)hash(values, widths[i] * made.vertices));
  }
  call(pdesc_field_destroy)(field);
  return 0;
}

enum { SETTINGS = 7, DEVICE_SETTINGS = 5 };

static void set_for_processor(pdesc_options *options, int choice) {
  options->estimator = choice < SETTINGS ? choice % 3 : 0;
  options->distance = choice < SETTINGS ? choice / 3 % 2 : 0;
  options->normals = choice == 6 ? PDESC_NORMALS_MAX : PDESC_NORMALS_FITTED;
  options->evaluate = choice < SETTINGS ? PDESC_EVALUATE_VERTEX : PDESC_EVALUATE_TEXEL;
  options->texels = 48;
}

static void set_for_device(pdesc_options *options, int choice) {
  options->relocation = choice < 3 ? choice : PDESC_RELOCATION_CONNECTED;
  options->precision = choice == 3 ? PDESC_PRECISION_HALF : PDESC_PRECISION_FULL;
  options->estimator = choice == 4 ? PDESC_ESTIMATOR_INTEGRAL : PDESC_ESTIMATOR_SHAPE_OPERATOR;
  options->buffer_size = 128;
}

static int print_shape(pdesc_context *context, const char *shape, double radius, int has_map, int on_device) {
  if (on_device && !has_map) return 0;
  for (int i = 0; i < 6 * made.triangles; ++i) made.corner_uvs[i] = made.uvs[2 * made.corner_vertices[i / 2] + i % 2];
  pdesc_mesh *mesh =
      make_mesh(context, (triangles_t){made.vertices, made.triangles, made.positions, has_map ? made.corner_uvs : NULL,
                                       made.corner_vertices, made.triangle_corners});
  if (!mesh) return 1;
  const int settings = on_device ? DEVICE_SETTINGS : SETTINGS + has_map;
  for (int choice = 0; choice < settings; ++choice) {
    pdesc_options options;
    call(pdesc_options_init)(&options);
    options.radius = radius;
    options.samples = 64; /* emulators are slow */
    (on_device ? set_for_device : set_for_processor)(&options, choice);
    if (print_bits(mesh, shape, &options)) return 1;
  }
  call(pdesc_mesh_destroy)(mesh);
  return 0;
}

int main(int argc, char **argv) {
  const int on_device = argc > 2 && strcmp(argv[2], "software") == 0;
  pdesc_context *const context = open_backend(argc > 1 ? argv[1] : NULL, on_device ? PDESC_BACKEND_SOFTWARE : PDESC_BACKEND_CPU,
                                              argc > 2 ? atoi(argv[2]) : 0);
  if (!context) return 1;
  make_torus();
  if (print_shape(context, "torus", 0.08, 0, on_device)) return 1;
  make_block(1);
  if (print_shape(context, "ellipsoid", 0.06, 1, on_device)) return 1;
  make_block(0);
  if (print_shape(context, "cube", 0.05, 1, on_device)) return 1;
  call(pdesc_context_destroy)(context);
  return 0;
}
