/* images.h - what belongs to images over a UV map, and needs neither a context nor a device. C99; part of paradesc.h, whose conventions
 * hold here too. The same input gives the same bits on every machine, whatever the number of threads.
 */
#ifndef PARADESC_IMAGES_H
#define PARADESC_IMAGES_H

#include "paradesc.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Images over a UV map ------------------------------------------------------------------------------------------------ */

/* What to draw: values at the corners of triangles, linear over each, seen by the triangles' UVs. Needs no context and no device; the
 * same input gives the same bits on every machine. */
typedef struct pdesc_uv_image_input {
  uint32_t struct_size;
  int32_t size;                    /* texels along a side of the square image, 1 to 16384 */
  int32_t triangle_count;
  int32_t value_count;
  int32_t components;              /* of a value: 1, or 3 for directions, which have no sign: v and -v are one; with numbers 1 to 6 */
  int32_t threads;                 /* 0 (default): all cores. Images do not depend on it */
  const float *uvs;                /* (triangle_count, 3, 2), modulo whole tiles as in a repeated texture, 16 x 16 of them for a triangle at
                                      most; NaN counts as 0 */
  const int32_t *triangle_values;  /* (triangle_count, 3) which value each corner has: of values at vertices, its vertex */
  const float *values;             /* (value_count, components) in any unit, which is that of the image; one that is not finite leaves
                                      its triangles to their other corners */
  const float *map;                /* (map_size, map_size, components) as pdesc_field_map gives, whose values, bilinear at the same place
                                      of the triangle, come before those of the corners where there are any; or NULL */
  int32_t map_size;                /* 1 to 16384 */
  const float *map_uvs;            /* (triangle_count, 3, 2) where the triangles lie in the map, as pdesc_mesh_layout gives */
  pdesc_progress progress;         /* called with stage "image", or NULL */
  void *user;                      /* its first argument */
  int32_t numbers;                 /* 1: each component is a number by itself, such as a coordinate; default 0 */
} pdesc_uv_image_input;

PDESC_API void pdesc_uv_image_input_init(pdesc_uv_image_input *input);
/* image: (size, size, components), row by row from v = 0 up, each row from u = 0. A texel shows the last triangle that its center lies in
 * or on the border of; NaN where there is none, or where that one has no value. count: of floats. INVALID_ARGUMENT names the first
 * index that is out of range. */
PDESC_API int32_t pdesc_uv_image_draw(const pdesc_uv_image_input *input, float *image, int64_t count);
/* Fills an image (height, width, components), in place: steps rings of texels (0 to 64) around what is finite take the mean of
 * those beside them, so that filtering and mipmaps show no seam; all others that are not finite become 0. count: of floats;
 * components: 1 to 4; width and height: 1 to 16384; threads as above. */
PDESC_API int32_t pdesc_uv_image_fill_gutter(float *image, int64_t count, int32_t width, int32_t height, int32_t components,
                                             int32_t steps, int32_t threads);

/* ---- One surface seen from another --------------------------------------------------------------------------------------- */

/* A surface, and lines through it: from points of a coarse surface along its normals, as a rule. */
typedef struct pdesc_rays_input {
  uint32_t struct_size;
  int32_t vertex_count;
  int32_t triangle_count;
  int32_t ray_count;
  int32_t threads;                   /* 0 (default): all cores */
  const float *positions;            /* (vertex_count, 3); triangles with one that is not finite, and those without area, are never met */
  const int32_t *triangle_vertices;  /* (triangle_count, 3) */
  const float *rays;                 /* (ray_count, 6) a point, and a direction of any length; where a number is not finite, or there is
                                        no direction, nothing is met */
  double reach;                      /* > 0: how far from its point a ray looks, along its direction and against it */
  pdesc_progress progress;           /* called with stage "rays", or NULL */
  void *user;                        /* its first argument */
} pdesc_rays_input;

PDESC_API void pdesc_rays_input_init(pdesc_rays_input *input);
/* What each ray meets nearest to its point, on either side, of triangles whose outside faces along its direction: triangles (ray_count),
 * -1 for none; weights (ray_count, 3) of the triangle's corners at that place, 0 for none. A ray through an edge or a vertex
 * between triangles meets one of them, never the gap. Of two at one distance the one ahead counts, then that of the lower number. */
PDESC_API int32_t pdesc_rays_cast(const pdesc_rays_input *input, int32_t *triangles, float *weights, int32_t ray_count);
/* (ray_count, components) values at what was met, from (vertex_count, components) as pdesc_uv_image_draw takes them: components 1, or 3
 * for directions; a corner without a value leaves the triangle to the others. NaN where nothing was met, or has a value. Positions, rays and
 * reach of the input are not read. */
PDESC_API int32_t pdesc_rays_values(const pdesc_rays_input *input, const int32_t *triangles, const float *weights, const float *values,
                                    int32_t components, float *met, int64_t count);

#ifdef __cplusplus
}
#endif
#endif
