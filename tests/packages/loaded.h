/* The functions of a libparadesc that was loaded as a host does, on any system; all are looked up before the first is used. */
#ifndef PARADESC_TESTS_LOADED_H
#define PARADESC_TESTS_LOADED_H

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "paradesc/paradesc.h"

#if defined(_WIN32)
#include <windows.h>
typedef HMODULE library_t;
static library_t open_library(const char *path) { return LoadLibraryA(path); }
#define FIND(library, name) GetProcAddress(library, name)
#else
#include <dlfcn.h>
typedef void *library_t;
static library_t open_library(const char *path) { return dlopen(path, RTLD_NOW | RTLD_LOCAL); }
#define FIND(library, name) dlsym(library, name)
#endif

/* call(name) is the library's function of that name. */
#define FUNCTIONS(F)                                                                                                             \
  F(pdesc_version)                                                                                                               \
  F(pdesc_last_error)                                                                                                            \
  F(pdesc_context_options_init)                                                                                                  \
  F(pdesc_context_create)                                                                                                        \
  F(pdesc_context_destroy)                                                                                                       \
  F(pdesc_context_device)                                                                                                        \
  F(pdesc_mesh_input_init)                                                                                                       \
  F(pdesc_mesh_create) F(pdesc_mesh_set_positions) F(pdesc_mesh_destroy) F(pdesc_options_init) F(pdesc_compute)                  \
      F(pdesc_field_values) F(pdesc_field_destroy) F(pdesc_descriptor_count) F(pdesc_descriptor_get)                             \
          F(pdesc_descriptor_info_init)
#define DECLARE(name) static __typeof__(&name) call_##name;
FUNCTIONS(DECLARE)
#define call(name) call_##name

static int find_functions(library_t library) {
#define LOOK_UP(name)                                                                                                            \
  {                                                                                                                              \
    void (*found)(void);                                                                                                         \
    *(void **)&found = (void *)FIND(library, #name);                                                                             \
    if (!found) return fprintf(stderr, "no %s\n", #name), 0;                                                                     \
    memcpy(&call_##name, &found, sizeof found);                                                                                  \
  }
  FUNCTIONS(LOOK_UP)
  return 1;
}

static int fail(const char *what) {
  fprintf(stderr, "%s: %s\n", what, call(pdesc_last_error)());
  return 1;
}

/* A context of the backend; of all cores with 0 threads. NULL, once it has said why. */
static inline pdesc_context *open_backend(const char *library_path, int32_t backend, int32_t threads) {
  const library_t library = library_path ? open_library(library_path) : NULL;
  if (!library || !find_functions(library)) return fprintf(stderr, "cannot load the library\n"), NULL;
  pdesc_context_options options;
  pdesc_context *context = NULL;
  call(pdesc_context_options_init)(&options);
  options.backend = backend;
  options.threads = threads;
  if (call(pdesc_context_create)(&options, &context)) fail("context");
  return context;
}

/* The arrays of a mesh; corners follow each other, three for each triangle. */
typedef struct {
  int vertices, triangles;
  const float *positions, *corner_uvs; /* corner_uvs: or NULL */
  const int32_t *corner_vertices, *triangle_corners;
} triangles_t;

/* NULL, once it has said why. */
static pdesc_mesh *make_mesh(pdesc_context *context, triangles_t of) {
  pdesc_mesh_input input;
  pdesc_mesh *mesh = NULL;
  call(pdesc_mesh_input_init)(&input);
  input.vertex_count = of.vertices;
  input.corner_count = 3 * of.triangles;
  input.triangle_count = of.triangles;
  input.positions = of.positions;
  input.corner_vertices = of.corner_vertices;
  input.triangle_corners = of.triangle_corners;
  input.corner_uvs = of.corner_uvs;
  if (call(pdesc_mesh_create)(context, &input, &mesh)) fail("mesh");
  return mesh;
}

#endif
