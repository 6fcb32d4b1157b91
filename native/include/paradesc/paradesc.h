/* paradesc.h - geometric descriptors of a triangle mesh at a radius: on the CPU, or in the texture space of its UV map. C99.
 *
 * The method is that of Andreadis, Papaioannou, Mavridis, "GPU Accelerated Computation of Geometric Descriptors in
 * Parametric Space"; "(n)" below is an equation of that paper.
 *
 * CONVENTIONS
 *   Right-handed object space. The winding of the faces says which side is outside; normals point there.
 *   A convex place has positive curvature: a sphere of radius R has H = k1 = k2 = 1/R with outward faces.
 *   Units: H, k1, k2, curvedness 1/length; K and local bending energy 1/length^2; sphere volume length^3;
 *   euclidean area length^2; normalized sphere volume, shape index and coverage have none. Length is that of
 *   the given positions: apply the object's scale first to get world units.
 *   Operators (gradient_magnitude, laplacian, difference_of_gaussians, harris) work on a map f: the values of a descriptor at the
 *   vertices, linear on triangles. Derivatives are along the surface, per length. The Harris response is made of r grad f, so
 *   its unit is that of f to the fourth power, and equal shapes of any size have equal responses at equal relative radius.
 *   Derivatives are those of a fitted quadratic. A part of the surface that is narrower than about a seventh of the radius, or a
 *   quarter at its end, does not determine a quadratic: gradient and Laplacian are undefined there. Harris is undefined if the
 *   gradient is undefined everywhere in its window.
 *   A value that is undefined (shape index of a plane, a loose vertex, no surface found) or overflows a float is NaN in raw
 *   results.
 *
 * MEMORY AND THREADS
 *   Inputs are borrowed for the duration of a call; outputs are allocated by the caller, who passes their length.
 *   Handles are opaque. Every handle may be used from any thread; calls on one context, on its meshes and on their fields are
 *   serialized. A mesh must be destroyed before its context; a field may outlive its mesh. A destroyed handle, or one of another
 *   kind, is refused (INVALID_ARGUMENT) unless a new one has its address. No thread may use a handle that another destroys.
 *   A forked process can use its handles of CPU and REFERENCE. Devices stay with the original process: in the fork, using them or
 *   opening others is refused, since no driver supports a fork. Any handle may be destroyed.
 *   A progress callback may not call into the context that called it: INVALID_OPERATION.
 *
 * ERRORS
 *   A call that can fail returns a pdesc_status, and on failure leaves one sentence (what was asked, what was found, what to
 *   do) in pdesc_last_error() of the calling thread. Outputs are untouched on failure. Faults of a part of a mesh are not
 *   errors: they are counted in pdesc_mesh_report, and all other vertices get results.
 *
 * SAME INPUT, SAME RESULT
 *   One device always gives the same bits, whatever the number of threads and the split of the work into dispatches; so does
 *   REFERENCE on one machine, and CPU on any. Another device, or another version of its driver, rounds differently. On smooth
 *   surfaces, at the defaults of pdesc_options, CPU differs from REFERENCE by at most PDESC_PARITY_PERCENT of a descriptor's range
 *   over the mesh (areas: of their value) and PDESC_PARITY_DEGREES for directions, as means over vertices. The same bounds hold for
 *   GPU and SOFTWARE if charts are wider than the radius, except for operators on a map.
 *
 * GROWTH
 *   Every struct starts with struct_size, set by its *_init function; members are only ever appended.
 */
#ifndef PARADESC_H
#define PARADESC_H

#include <stdint.h>

#if defined(_WIN32)
#  if defined(PARADESC_BUILDING)
#    define PDESC_API __declspec(dllexport)
#  else
#    define PDESC_API __declspec(dllimport)
#  endif
#else
#  define PDESC_API __attribute__((visibility("default")))
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* Raised when an existing call or struct member changes its meaning; appended members do not raise it. */
#define PDESC_ABI_VERSION 1

/* Bounds on the differences between backends, see SAME INPUT, SAME RESULT. */
#define PDESC_PARITY_PERCENT 1.0
#define PDESC_PARITY_DEGREES 1.0

typedef enum pdesc_status {
  PDESC_OK = 0,
  PDESC_ERROR_UNKNOWN = 1,           /* a defect of this library; the sentence says where */
  PDESC_ERROR_INVALID_ARGUMENT = 2,  /* an input is unusable; the sentence names the first offender */
  PDESC_ERROR_INVALID_OPERATION = 3, /* the call does not fit the state of the object */
  PDESC_ERROR_OUT_OF_MEMORY = 4,
  PDESC_ERROR_UNSUPPORTED = 5,       /* no device of the requested backend, or the device lacks something */
  PDESC_ERROR_CANCELLED = 6,         /* the progress callback returned 0; the mesh stays usable */
  PDESC_ERROR_DEVICE_LOST = 7        /* the driver dropped the device; the next compute reopens it, or says that it cannot */
} pdesc_status;

typedef enum pdesc_backend {
  PDESC_BACKEND_AUTO = 0,      /* CPU, and SOFTWARE for options that need texture space; see pdesc_context_create */
  PDESC_BACKEND_GPU = 1,       /* a hardware device by EGL or WGL, OpenGL 4.5 */
  PDESC_BACKEND_SOFTWARE = 2,  /* a software rasterizer (llvmpipe), OpenGL 4.5 */
  PDESC_BACKEND_REFERENCE = 3, /* object space on the CPU, exact quadrature over the surface, needs no UV map */
  PDESC_BACKEND_CPU = 4        /* samples of the surface on all cores, needs a UV map only at texels */
} pdesc_backend;

typedef enum pdesc_normals {
  PDESC_NORMALS_FITTED = 0, /* local jets over mesh rings (Cazals and Pouget); the faces' mean if the surface is not smooth */
  PDESC_NORMALS_MAX = 1,    /* weights sin(angle)/(|e1||e2|) (Max 1999) */
  PDESC_NORMALS_MESH = 2    /* the corner normals given with the mesh */
} pdesc_normals;

/* The edges along which a surface has no tangent plane. Fitted and Max's normals do not cross them. Within the radius of such an
 * edge, curvatures, their directions, bending energy, cavity, convexity and sphere volume are those of the solid in the ball
 * (paper eq. 8 with the true volume): H = 8 (pi - a)/(3 pi r) on an edge of inner angle a. Beyond 1.25 radii they are the smooth
 * surface's. */
typedef enum pdesc_creases {
  PDESC_CREASES_AUTO = 0,   /* marked edges between smooth faces, and edges that bend far more than the surface around them */
  PDESC_CREASES_MARKED = 1, /* marked edges alone */
  PDESC_CREASES_NONE = 2    /* curvature as without creases; normals are still not averaged across marked edges */
} pdesc_creases;

typedef enum pdesc_radius_unit {
  PDESC_RADIUS_DIAGONAL = 0,  /* fraction of the bounding box's diagonal */
  PDESC_RADIUS_ABSOLUTE = 1,  /* units of the positions */
  PDESC_RADIUS_MEAN_EDGE = 2  /* multiples of the mean edge length */
} pdesc_radius_unit;

typedef enum pdesc_relocation {
  PDESC_RELOCATION_CONNECTED = 0, /* the surface that is connected to the vertex within the ball, by CPU and REFERENCE; GPU and
                                     SOFTWARE do not support this and compute with AFFINE */
  PDESC_RELOCATION_AFFINE = 1,    /* each sample of a pattern is carried across seams by itself (paper 3.4, with the affine map of
                                     each seam edge in place of eq. 2 and 3) */
  PDESC_RELOCATION_PAPER = 2      /* the paper's: the whole pattern again on every chart that samples landed on, around the center
                                     carried there (corrected eq. 2 and 3), up to max_jumps charts away */
} pdesc_relocation;

typedef enum pdesc_estimator {
  PDESC_ESTIMATOR_SHAPE_OPERATOR = 0, /* curvatures are those of the least-squares shape operator */
  PDESC_ESTIMATOR_INTEGRAL = 1,       /* the paper's: H from the sphere volume (8), K from the geodesic area (11-14), k1 and k2 (10) */
  PDESC_ESTIMATOR_EXTRAPOLATED = 2    /* the shape operator without the radius' blur, to lowest order: 5 S' - 4 S, S in the
                                         window 1 - t, S' in its square, t = (distance/r)^2. Use a larger radius: noise grows */
} pdesc_estimator;

typedef enum pdesc_variance_reduction {
  PDESC_VARIANCE_REDUCTION_SHAPE = 0, /* samples only integrate what the shape operator does not explain; its part is exact */
  PDESC_VARIANCE_REDUCTION_NONE = 1   /* the plain sums of the paper */
} pdesc_variance_reduction;

typedef enum pdesc_geodesic {
  PDESC_GEODESIC_LOCAL = 0, /* s = rho (1 + (k rho)^2/24), k the normal curvature from p to q */
  PDESC_GEODESIC_CHORDS = 1 /* the paper's sum of chords along the straight path in the UV map; AFFINE and PAPER only */
} pdesc_geodesic;

typedef enum pdesc_distance {
  PDESC_DISTANCE_EUCLIDEAN = 0, /* the neighborhood is the surface in the ball */
  PDESC_DISTANCE_GEODESIC = 1   /* the neighborhood is the surface within r along the surface */
} pdesc_distance;

typedef enum pdesc_pattern {
  PDESC_PATTERN_GOLDEN_ANGLE = 0, /* Vogel's spiral */
  PDESC_PATTERN_STRATIFIED = 1    /* the paper's: one random place in each square of a grid, mapped to the disk (Shirley, Chiu) */
} pdesc_pattern;

typedef enum pdesc_ellipse {
  PDESC_ELLIPSE_CENTER = 0,     /* A(s) by the distortion at the center */
  PDESC_ELLIPSE_DIRECTIONAL = 1 /* each direction stretched by the largest distortion along it (paper 4.1) */
} pdesc_ellipse;

typedef enum pdesc_evaluate {
  PDESC_EVALUATE_VERTEX = 0, /* at the vertices themselves */
  PDESC_EVALUATE_TEXEL = 1   /* at the texels of a square map over the layout, as the paper does. Vertices are looked up in it,
                                bilinearly, or by a plane fitted to texels beside a border; NaN without a place in the UV map */
} pdesc_evaluate;

typedef enum pdesc_precision {
  PDESC_PRECISION_FULL = 0, /* 32-bit floats in the buffers */
  PDESC_PRECISION_HALF = 1  /* 16-bit floats: 32 instead of 48 bytes a texel. Unused numbers keep the rounding errors of positions
                               and normals, so results hardly change; the center of an evaluation stays in 32 bits */
} pdesc_precision;

/* Bits of a vertex' mask. */
#define PDESC_MASK_NO_FACE 1u      /* no usable face at this vertex: NaN */
#define PDESC_MASK_BOUNDARY 2u     /* a boundary of the mesh cuts the neighborhood: the formulas use the part that exists */
#define PDESC_MASK_LOW_COVERAGE 4u /* coverage below 0.9: part of the neighborhood was not found in the UV map */
#define PDESC_MASK_NO_TEXEL 8u     /* the vertex has no place in the UV map (no area there): NaN */

typedef struct pdesc_context pdesc_context; /* a device and its compiled programs */
typedef struct pdesc_mesh pdesc_mesh;       /* a mesh, its adjacency, charts and seams */
typedef struct pdesc_field pdesc_field;     /* results at the vertices of one mesh */

/* ---- Library ------------------------------------------------------------------------------------------------------------ */

PDESC_API int32_t pdesc_abi_version(void);        /* compare with PDESC_ABI_VERSION before any other call */
PDESC_API const char *pdesc_version(void);        /* "0.1.0" */
PDESC_API const char *pdesc_last_error(void);     /* sentence of the calling thread's last failure; valid until its next call */

/* One row of the descriptor registry. Strings live as long as the library is loaded. */
typedef struct pdesc_descriptor_info {
  uint32_t struct_size;
  const char *name;         /* "mean_curvature": used in every call, and as attribute name */
  const char *label;        /* "Mean Curvature" */
  const char *description;  /* one sentence with the source */
  int32_t length_power;     /* unit is length^power: -1 for H */
  int32_t is_signed;        /* 1: zero is the neutral value, show with a diverging color map */
  double neutral_value;     /* the value of a plane (NaN where a plane has none); in units that do not depend on r */
  double display_minimum;   /* fixed display range, NaN if the range is to follow from the values */
  double display_maximum;
  int32_t components;       /* 1, or 3: a vector in object space */
  int32_t map_degree;       /* 0: a descriptor of the surface; else an operator on pdesc_options.map_descriptor, whose unit is
                               length^length_power times the map's unit to this power */
} pdesc_descriptor_info;

PDESC_API void pdesc_descriptor_info_init(pdesc_descriptor_info *info);
PDESC_API int32_t pdesc_descriptor_count(void);
/* index in [0, pdesc_descriptor_count()). */
PDESC_API int32_t pdesc_descriptor_get(int32_t index, pdesc_descriptor_info *info);

/* ---- Context ------------------------------------------------------------------------------------------------------------ */

typedef struct pdesc_context_options {
  uint32_t struct_size;
  int32_t backend;      /* pdesc_backend; default AUTO */
  int32_t device_index; /* among the devices of that backend, -1 (default): the first that works */
  int32_t threads;      /* for work on the CPU, 0 (default): all cores. Results do not depend on it */
  int64_t memory_limit; /* bytes that a mesh and its computations may take, 0 (default): half of what is free at the time */
} pdesc_context_options;

PDESC_API void pdesc_context_options_init(pdesc_context_options *options);
/* options may be NULL: defaults. AUTO is CPU on every system; GPU must be requested. Under AUTO, options that only texture space
 * supports (relocations AFFINE and PAPER, half floats, adaptive sampling, buffers to be read) are computed by
 * SOFTWARE, with a sentence in the field's warnings; they are UNSUPPORTED if there is no software device. If a device fails, the
 * call returns its error, and the context stays usable. */
PDESC_API int32_t pdesc_context_create(const pdesc_context_options *options, pdesc_context **context);
PDESC_API void pdesc_context_destroy(pdesc_context *context); /* NULL is allowed */
/* The strings live as long as the context. */
PDESC_API int32_t pdesc_context_backend(const pdesc_context *context);       /* the pdesc_backend in use */
PDESC_API const char *pdesc_context_device(const pdesc_context *context);    /* its name, for people */
PDESC_API const char *pdesc_context_fallback(const pdesc_context *context);  /* always "", for older callers */

/* stage: "mesh", "bake", ...; fraction of the whole in [0, 1]. Return 0 to cancel. Called on the calling thread every few ms. */
typedef int32_t (*pdesc_progress)(void *user, const char *stage, double fraction);

/* ---- Mesh --------------------------------------------------------------------------------------------------------------- */

/* A corner is a face's use of a vertex (Blender's loop). Triangles refer to corners, corners to vertices. */
typedef struct pdesc_mesh_input {
  uint32_t struct_size;
  int32_t vertex_count;
  int32_t corner_count;
  int32_t triangle_count;
  const float *positions;            /* (vertex_count, 3) */
  const int32_t *corner_vertices;    /* (corner_count) */
  const int32_t *triangle_corners;   /* (triangle_count, 3) */
  const float *corner_uvs;           /* (corner_count, 2), or NULL: REFERENCE computes, and CPU at vertices */
  const float *corner_normals;       /* (corner_count, 3) unit, or NULL; read by PDESC_NORMALS_MESH and normal maps only */
  const uint8_t *triangle_smooth;    /* (triangle_count) 0 where flat shaded, or NULL: all smooth */
  const int32_t *sharp_edges;        /* (sharp_edge_count, 2) vertex pairs marked sharp, or NULL. Fitted and Max's normals do not
                                        cross those between two smooth faces */
  int32_t sharp_edge_count;
  pdesc_progress progress;           /* called with stage "mesh" and fraction 0 while the mesh is made, or NULL */
  void *user;                        /* its first argument */
} pdesc_mesh_input;

PDESC_API void pdesc_mesh_input_init(pdesc_mesh_input *input);

/* Properties and defects of a mesh. Counts are of triangles, edges or vertices as named. */
typedef struct pdesc_mesh_report {
  uint32_t struct_size;
  int32_t vertex_count;
  int32_t triangle_count;
  int32_t loose_vertices;           /* no usable face */
  int32_t welded_vertices;          /* vertices that share their point with an earlier one (split by an exporter): at the same
                                       position, or beside open edges within rounding, 16 units in the last place */
  int32_t degenerate_triangles;     /* no area in space, or a corner used twice: left out */
  int32_t zero_uv_area_triangles;   /* on the surface, but without texels: no area in the UV map, or a needle below 1e-7 of it */
  int32_t flipped_triangles;        /* their UV orientation is the one with less UV area */
  int32_t nonmanifold_edges;        /* more than two faces, or two wound against each other: the surface is separated there */
  int32_t nonmanifold_vertices;     /* several fans of faces at one vertex: the surface is separated there */
  int32_t boundary_edges;           /* one face */
  int32_t charts;
  int32_t seam_edges;               /* mesh edges whose two sides have different places in the UV map */
  int32_t self_seam_edges;          /* of those, within one chart */
  int32_t unlinked_edges;           /* chart edges beside a triangle without UV area, across which no sample can be carried */
  int32_t parts;                    /* connected components */
  int32_t uv_remapped;              /* 1: UVs outside [0,1] were mapped into the unit square by one affine map */
  float diagonal;                   /* of the bounding box of the vertices with a face */
  float mean_edge;
  int32_t copied_triangles;         /* left out: at the same three places as others that are wound alike or have the same
                                       vertices. Their vertices get the values of the surface there */
  int32_t opposed_edges;            /* nonmanifold_edges along which all faces run the same way, wound against each other */
  int32_t inward_parts;             /* closed parts that are inside out (negative volume), except hollows of a larger part */
} pdesc_mesh_report;

PDESC_API void pdesc_mesh_report_init(pdesc_mesh_report *report);

/* Validates and copies the input, builds adjacency, charts and seams. INVALID_ARGUMENT names the first index or coordinate
 * that cannot be used. */
PDESC_API int32_t pdesc_mesh_create(pdesc_context *context, const pdesc_mesh_input *input, pdesc_mesh **mesh);
/* New positions for the same topology: (vertex_count, 3). The report's diagonal, mean_edge and inward_parts are updated. Results
 * have the same bits as a new mesh's if the same vertices coincide (beside open edges to rounding, see welded_vertices), the same
 * triangles have no area, no vertex has several fans of faces, and private_layout is 0. These stay as at creation, and so do
 * corner_normals. */
PDESC_API int32_t pdesc_mesh_set_positions(pdesc_mesh *mesh, const float *positions, int32_t vertex_count);
/* Images over the mesh's UV map, which change the measured surface but not the mesh: diagonal, mean edge and report stay those of
 * the base. Rows run from bottom to top as v does (as in Blender's images); lookups are bilinear by the UVs as given, and repeat
 * outside [0,1]. Images are copied; NULL removes a map. CPU and REFERENCE divide triangles for a map until pieces are as small as
 * its pixels or an eighth of the radius, into about 4 million pieces at most; a field's warnings name details that are lost by
 * that limit. GPU and SOFTWARE follow maps at vertices, not at texels. */
/* Displacement: (height, width) floats. Every surface point p moves to p + n (value - midlevel) scale; n is the interpolated unit
 * normal, scale is in units of the positions. A vertex with several places in the UV map moves by their mean by angle. */
PDESC_API int32_t pdesc_mesh_set_displacement(pdesc_mesh *mesh, const float *heights, int32_t width, int32_t height,
                                              double midlevel, double scale);
/* Normal map: (height, width, 3) red, green, blue in [0,1] for components -1 to 1 in the tangent space of each corner
 * (MikkTSpace). corner_tangents (corner_count, 4): the unit tangent, and the sign of the bitangent, sign * cross(normal,
 * tangent). The tangent space's normals are the mesh's corner normals if given (give those that the map was made from), else the
 * computed normals. The map's normals replace the surface's, displaced or not. After pdesc_mesh_set_positions set the map again
 * with new tangents. */
PDESC_API int32_t pdesc_mesh_set_normal_map(pdesc_mesh *mesh, const float *rgb, int32_t width, int32_t height,
                                            const float *corner_tangents, int32_t corner_count);
PDESC_API int32_t pdesc_mesh_get_report(const pdesc_mesh *mesh, pdesc_mesh_report *report);
PDESC_API void pdesc_mesh_destroy(pdesc_mesh *mesh); /* NULL is allowed */

/* ---- Compute ------------------------------------------------------------------------------------------------------------ */

typedef struct pdesc_options {
  uint32_t struct_size;
  double radius;        /* > 0; default 0.02 */
  int32_t radius_unit;  /* pdesc_radius_unit; default DIAGONAL. The radius may not exceed the diagonal */
  int32_t samples;      /* over the neighborhood of a vertex, at least, 8 to 4096; default 256. CPU takes fewer pieces, cut exactly. Not used by REFERENCE */
  int32_t buffer_size;  /* texels along a side of the square buffers, 64 to 8192; default 1024. Not used by REFERENCE, nor by CPU */
  int32_t normals;      /* pdesc_normals; default FITTED */
  int32_t max_jumps;    /* seams that one sample may cross, 0 to 64; default 8. Used in texture space only; the paper: 1 */
  uint32_t seed;        /* of the places of samples; default 0. Used in texture space only */
  int32_t seam_error;   /* has no effect and must be 0 */
  int32_t relocation;   /* pdesc_relocation; default CONNECTED, which GPU and SOFTWARE compute as AFFINE. Not used by REFERENCE */
  int32_t estimator;    /* pdesc_estimator; default SHAPE_OPERATOR */
  int32_t variance_reduction; /* pdesc_variance_reduction; default SHAPE. Used where samples are points: not by CPU and REFERENCE */
  int32_t geodesic;     /* pdesc_geodesic; default LOCAL. REFERENCE always uses LOCAL */
  int32_t distance;     /* pdesc_distance; default EUCLIDEAN */
  int32_t pattern;      /* pdesc_pattern; default GOLDEN_ANGLE. Used in texture space only */
  int32_t ellipse;      /* pdesc_ellipse; default CENTER. Used in texture space only */
  int32_t evaluate;     /* pdesc_evaluate; default VERTEX. Not used by REFERENCE */
  int32_t texels;       /* along a side of the map of TEXEL evaluation, 16 to 8192; default 512 */
  int32_t precision;    /* pdesc_precision of the buffers; default FULL. Not used by REFERENCE, nor while a surface map is set (full) */
  double adaptive;      /* above 0: half of the samples first, the others only where the normals there deviate from the shape operator by
                           more than this, root mean square, in radians (paper 4.2). Default 0: all samples everywhere */
  const char *map_descriptor; /* the map f that operators work on: a descriptor of the surface with one component, at the same radius.
                                 Default NULL: "sphere_volume_normalized". It and its derivatives take four times the samples.
                                 Read during the call only */
  double map_sigma;     /* of the Gaussian windows of harris and difference_of_gaussians, times the radius, 0.1 to 4; default 1. Windows
                           end at 2 sigma: f itself is smooth at the scale of the radius, and a corner lies in the middle of its slopes */
  double harris_k;      /* k of harris (16), in [0, 0.25); default 0.04 */
  int32_t buffers;      /* 1: baked buffers are to be read afterwards (pdesc_mesh_read_buffer); default 0. GPU and SOFTWARE always leave
                           some, AUTO only where this asks for them */
  int32_t creases;      /* pdesc_creases; default AUTO. On a surface that maps displace, creases only separate normals */
} pdesc_options;

PDESC_API void pdesc_options_init(pdesc_options *options);
/* The pdesc_backend that would compute with these options: under AUTO it may be another than the context's own. Opens no device. */
PDESC_API int32_t pdesc_mesh_backend(const pdesc_mesh *mesh, const pdesc_options *options, int32_t *backend);

/* Computes the named descriptors at every vertex from one sampling. descriptor_count >= 1. progress may be NULL. */
PDESC_API int32_t pdesc_compute(pdesc_mesh *mesh, const pdesc_options *options, const char *const *descriptors,
                                int32_t descriptor_count, pdesc_progress progress, void *user, pdesc_field **field);

/* The bytes that a computation may take, computed from counts and options before anything is allocated. On the CPU, a smooth surface
 * without creases takes a quarter of them. pdesc_mesh_create and pdesc_compute refuse more than is allowed (OUT_OF_MEMORY, with these
 * numbers): the part that every surface takes at once, and the rest as soon as the surface is known to need it. */
typedef struct pdesc_memory {
  uint32_t struct_size;
  int64_t mesh;    /* held by the mesh, with or without a computation */
  int64_t host;    /* at the peak of the computation, in addition to the mesh */
  int64_t device;  /* of the device at the peak; 0 on REFERENCE */
  int64_t total;   /* of the host at the peak: mesh, host, and on SOFTWARE device */
  int64_t allowed; /* limit of total: pdesc_context_options.memory_limit, or mesh and half of the free memory */
} pdesc_memory;
PDESC_API void pdesc_memory_init(pdesc_memory *memory);
/* backend: a pdesc_backend; AUTO: the one that would compute, see pdesc_mesh_backend. */
PDESC_API int32_t pdesc_mesh_memory(const pdesc_mesh *mesh, const pdesc_options *options, const char *const *descriptors,
                                    int32_t descriptor_count, int32_t backend, pdesc_memory *memory);

/* The reason for a private layout, in which charts are moved, turned and scaled (strongly stretched ones along one direction),
 * and their texel densities are within a factor of two of the median. The mesh keeps the layout; the UV map itself is unchanged,
 * and pdesc_mesh_report still describes the UV map. */
typedef enum pdesc_layout {
  PDESC_LAYOUT_GIVEN = 0,    /* none: the UV map was used as it is, or after one affine map if it leaves [0,1] */
  PDESC_LAYOUT_OVERLAPS = 1, /* places in the UV map belonged to several triangles, of one or several charts */
  PDESC_LAYOUT_SPARSE = 2    /* less than 15 % of the texels were used, or the radius spanned less than four of them; half of the
                                surface now has 1.5 times as many along a line, in the direction that has the fewest */
} pdesc_layout;
/* The buffers of the last compute in texture space (under AUTO: with options.buffers = 1): texels along a side, 0 if there are
 * none; and (size, size, components) values, row by row from v = 0 up. name: "position" (3, units of the positions), "normal"
 * (3), "chart" (1, a number, -1 for none), "neighbor" (1, the chart beyond a seam that runs through the texel, -1 for none),
 * "distortion" (4: sigma_u, sigma_v, theta_e, area element, paper 3.3). NaN off the charts. count: of floats. */
PDESC_API int32_t pdesc_mesh_buffer_size(const pdesc_mesh *mesh);
PDESC_API int32_t pdesc_mesh_read_buffer(pdesc_mesh *mesh, const char *name, float *values, int64_t count);
/* (triangle_count, 3, 2) the (u, v) of every triangle's corners in the layout of the last compute: the UV map's own, or those of
 * the private layout. Maps and buffers use this layout. */
PDESC_API int32_t pdesc_mesh_layout(const pdesc_mesh *mesh, float *uvs, int32_t triangle_count);

typedef struct pdesc_field_report {
  uint32_t struct_size;
  double radius;                /* as used, in units of the positions */
  double coverage_mean;         /* over vertices with a face; 1 where nothing is lost */
  int32_t undefined_vertices;   /* NaN in at least one of the descriptors */
  int32_t boundary_vertices;    /* PDESC_MASK_BOUNDARY */
  int32_t low_coverage_vertices;
  int32_t overlapping_texels;   /* texels claimed by several triangles in the layout used: only by rounding of rasterizers */
  int32_t covered_texels;
  int32_t bare_triangles;       /* usable triangles without a texel of their own */
  double radius_in_texels;      /* median of the support radius measured in texels, in the direction that has the fewest; below 4 the
                                   buffer is too coarse */
  double seconds_prepare;       /* normals, metric and seam maps on the CPU */
  double seconds_bake;
  double seconds_evaluate;
  double seconds_total;
  int32_t private_layout;       /* pdesc_layout */
  int32_t places;               /* of evaluation: vertices, or texels */
  double refined_share;         /* of the places of evaluation that took all samples; 1 without adaptive sampling */
  double buffer_megabytes;      /* of the baked buffers on the device, 10^6 bytes */
  int32_t cut_charts;           /* charts that overlapped themselves and were cut into pieces for the private layout */
  int32_t backend;              /* the pdesc_backend that computed */
  double memory_megabytes;      /* host memory of the mesh and the computation at the peak, as forecast by pdesc_mesh_memory */
  int32_t crease_edges;         /* edges of the mesh that counted as creases at this radius */
} pdesc_field_report;

PDESC_API void pdesc_field_report_init(pdesc_field_report *report);
PDESC_API int32_t pdesc_field_get_report(const pdesc_field *field, pdesc_field_report *report);
/* One sentence per line about what limits these results (overlapping UVs, a coarse buffer, ...), or "". */
PDESC_API const char *pdesc_field_warnings(const pdesc_field *field);
/* The name of the device that computed, for people. */
PDESC_API const char *pdesc_field_device(const pdesc_field *field);

/* values: (vertex_count) float32, one for each original vertex; (vertex_count, 3) for a descriptor with three components.
 * name: a requested descriptor, or "coverage". */
PDESC_API int32_t pdesc_field_values(const pdesc_field *field, const char *name, float *values, int32_t vertex_count);
/* Always INVALID_OPERATION, for older callers. */
PDESC_API int32_t pdesc_field_seam_error(const pdesc_field *field, const char *name, float *values, int32_t vertex_count);
/* (vertex_count) bits PDESC_MASK_*. */
PDESC_API int32_t pdesc_field_mask(const pdesc_field *field, uint8_t *mask, int32_t vertex_count);
/* (vertex_count) 1 if a seam of the UV map, or of the private layout, lies within the radius, measured along edges between
 * vertices. */
PDESC_API int32_t pdesc_mesh_near_seam(const pdesc_mesh *mesh, double radius, uint8_t *near_seam, int32_t vertex_count);
/* The map of PDESC_EVALUATE_TEXEL: texels along a side, 0 if there is none; and its values over the layout used, row by row from
 * v = 0 up, each row from u = 0: (size, size, components). NaN off the surface. count: of floats. name: as for values, or
 * "boundary", which is 1 where PDESC_MASK_BOUNDARY holds, else 0. */
PDESC_API int32_t pdesc_field_map_size(const pdesc_field *field);
PDESC_API int32_t pdesc_field_map(const pdesc_field *field, const char *name, float *values, int64_t count);
PDESC_API void pdesc_field_destroy(pdesc_field *field); /* NULL is allowed */

#ifdef __cplusplus
}
#endif

#include "images.h" /* functions that need no context */
#endif
