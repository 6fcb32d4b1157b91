/* images.h - images over a UV map, and rays between surfaces. Needs neither a context nor a device. C99; part of paradesc.h,
 * whose conventions hold here, too. The same input gives the same bits on every machine, whatever the number of threads. */
#ifndef PARADESC_IMAGES_H
#define PARADESC_IMAGES_H

#include "paradesc.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Images over a UV map ------------------------------------------------------------------------------------------------ */

/* An image to draw: values at the corners of triangles, linear over each triangle, placed by the triangles' UVs. Needs no context
 * and no device; the same input gives the same bits on every machine. */
typedef struct pdesc_uv_image_input {
  uint32_t struct_size;
  int32_t size;                    /* texels along a side of the square image, 1 to 16384 */
  int32_t triangle_count;
  int32_t value_count;
  int32_t components;              /* per value: 1, or 3 for directions (v and -v are the same); with numbers 1 to 6 */
  int32_t threads;                 /* 0 (default): all cores. Images do not depend on it */
  const float *uvs;                /* (triangle_count, 3, 2), modulo whole tiles as in a repeated texture; a triangle may cover
                                      at most 16 x 16 tiles; NaN counts as 0 */
  const int32_t *triangle_values;  /* (triangle_count, 3) the index of each corner's value; for values at vertices, its vertex */
  const float *values;             /* (value_count, components) in the unit of the image; a corner whose value is not finite is
                                      ignored in favor of the triangle's other corners */
  const float *map;                /* (map_size, map_size, components) from pdesc_field_map, or NULL. Its values, bilinear at the
                                      same place of the triangle, replace those of the corners where they exist */
  int32_t map_size;                /* 1 to 16384 */
  const float *map_uvs;            /* (triangle_count, 3, 2) the triangles' place in the map, from pdesc_mesh_layout */
  pdesc_progress progress;         /* called with stage "image", or NULL */
  void *user;                      /* its first argument */
  int32_t numbers;                 /* 1: components are independent numbers, such as coordinates; default 0 */
} pdesc_uv_image_input;

PDESC_API void pdesc_uv_image_input_init(pdesc_uv_image_input *input);
/* image: (size, size, components), row by row from v = 0 up, each row from u = 0. A texel shows the last triangle that contains
 * its center, border included; NaN if there is none, or if that triangle has no value. count: of floats. INVALID_ARGUMENT names
 * the first index that is out of range. */
PDESC_API int32_t pdesc_uv_image_draw(const pdesc_uv_image_input *input, float *image, int64_t count);
/* Fills an image (height, width, components) in place: `steps` rings of texels (0 to 64) around finite texels get the mean of
 * their neighbors, so that filtering and mipmaps show no seam; all other non-finite values become 0. count: of floats;
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
  const float *positions;            /* (vertex_count, 3); a triangle without area, or with a non-finite position, is never hit */
  const int32_t *triangle_vertices;  /* (triangle_count, 3) */
  const float *rays;                 /* (ray_count, 6) a point, and a direction of any length; a ray with a non-finite number, or
                                        without direction, hits nothing */
  double reach;                      /* > 0: how far from its point a ray extends, along its direction and against it */
  pdesc_progress progress;           /* called with stage "rays", or NULL */
  void *user;                        /* its first argument */
} pdesc_rays_input;

PDESC_API void pdesc_rays_input_init(pdesc_rays_input *input);
/* Finds each ray's hit nearest to its point, on either side, among triangles whose outside faces along the direction: triangles
 * (ray_count), -1 for none; weights (ray_count, 3) of the triangle's corners, 0 for none. A ray through an edge or a vertex
 * between triangles hits one of them, never the gap. At equal distances the hit ahead counts, then the lower triangle. */
PDESC_API int32_t pdesc_rays_cast(const pdesc_rays_input *input, int32_t *triangles, float *weights, int32_t ray_count);
/* (ray_count, components) values at the hits, from (vertex_count, components) as for pdesc_uv_image_draw: components 1, or 3 for
 * directions; a corner without a value is ignored in favor of the triangle's others. NaN if nothing was hit, or the hit has no
 * value. Positions, rays and reach of the input are not read. */
PDESC_API int32_t pdesc_rays_values(const pdesc_rays_input *input, const int32_t *triangles, const float *weights, const float *values,
                                    int32_t components, float *met, int64_t count);

#ifdef __cplusplus
}
#endif
#endif
