// Structs, limits and bindings that C++ and GLSL both compile, in std430 layout.
#ifndef PARADESC_SHARED_H
#define PARADESC_SHARED_H

#define MAX_MARCH_STEPS                                                                                                          \
  4096 // guard of the march; a straight line crosses at most 2 x 8192 texels between seams, far less in practice

// Sampler units of textures, each number used once: a stage of a program may have 16 of them.
#define UNIT_WEIGHTS 0     // buffer, RG32F: the texel's place in its triangle: the weights of the corners 1 and 2
#define UNIT_POSITION 1    // buffer, RGBA32F or RGBA16F: position, area element in units of area_unit (0: no surface)
#define UNIT_NORMAL 2      // buffer, RGBA32F: unit normal; RGBA16F: half.glsl says how
#define UNIT_IDS 3         // buffer, RG32I: chart (-1: none), triangle (-1 - triangle: on a chart-edge line)
#define UNIT_BORDER 4      // buffer, RG32I: free texels around (or -number of border edges in this texel), first list entry
#define UNIT_BORDER_LIST 5 // buffer texture, RG32I: border, chart
#define UNIT_BORDER_UV 6   // buffer texture, RGBA32F: u0, v0, u1, v1 of each border, the chart on its left
#define UNIT_LINKS                                                                                                               \
  7 // buffer texture, RGBA32F, two a border: the matrix of M_e; its image of (u0, v0), twin (or -1 - kind), twin's chart
// For a layout, and the mesh's points in it.
#define UNIT_CORNER_UVS                                                                                                          \
  8 // buffer texture, RGBA32F, two a triangle: (u, v) of its corners 0 and 1; (u, v) of corner 2, its chart, 1 over twice its
    // area in (u, v)
#define UNIT_VERTICES 9 // buffer texture, RGBA32F, two a corner: position; normal
#define UNIT_VALUES 10  // buffer texture, RGBA32F: a map's value at each corner
#define UNIT_EDGES 11   // buffer texture, RGBA32I, two a chart-edge line: the bits of EdgeData
// For sampling neighborhoods.
#define UNIT_FACES 12 // buffer texture, RGBA32F: unit normal of each triangle, 0 without area
#define UNIT_MAP 13   // buffer, RGBA32F: gradient of a map, its value
// For displacing baked texels.
#define UNIT_HEIGHTS 14  // image, R32F: displacement
#define UNIT_COLORS 15   // image, RGBA32F: normal map
#define UNIT_INPUT_UV 16 // buffer texture, RG32F: the caller's (u, v) of each corner
#define UNIT_TANGENTS 17 // buffer texture, RGBA32F, two a corner: tangent, sign of the bitangent; normal that goes with it
#define UNIT_COUNT 18

// Uniforms of programs with few parameters. Programs over centers use EvaluateParams.
#define LOCATION_BUFFER_SIZE 0
#define LOCATION_FIRST 2        // first row of texels
#define LOCATION_MIDLEVEL 6     // for displacing baked texels
#define LOCATION_HEIGHT_SCALE 7 // in buffer units
#define LOCATION_AREA_UNIT 30   // for every program that writes or reads the area element

// Image units of images that are written.
#define IMAGE_POSITION 0
#define IMAGE_NORMAL 1
#define IMAGE_DISTORTION 2

// Uniform blocks.
#define BLOCK_EVALUATE 0

// Bindings of storage buffers; drivers often have only 16.
#define BINDING_CENTERS 0
#define BINDING_RESULTS 1
#define BINDING_MAP_CENTERS 2 // gradient and value of the map at each center
#define BINDING_PATTERN 3
#define BINDING_PROGRESS 4  // (centers of one dispatch)
#define BINDING_STRETCHES 5 // (centers, STRETCH_DIRECTIONS)
#define BINDING_SEAMS 6     // the seam of each border
#define BINDING_VISITS 7    // (centers of one dispatch, MAX_VISITS)
#define BINDING_COUNT 8
#define STRETCH_DIRECTIONS 16 // of the directional ellipse
#define MAX_VISITS 64         // the most charts, each entered by one seam, on which a center's pattern is repeated

// Rows of the results that precede those of the descriptors.
#define ROW_COVERAGE 0
#define ROW_FLAGS 1
#define ROW_DESCRIPTORS 2

// Bits of a center's flags, stored as an integer among the results' floats.
#define FLAG_HITS_BOUNDARY 1u // the mesh's boundary lies in the neighborhood
#define FLAG_ALL_SAMPLES 2u   // adaptive sampling took all samples

#ifdef __cplusplus
namespace paradesc {
#define BLOCK_OF_VECTORS struct alignas(16)
#else
#define BLOCK_OF_VECTORS struct
#endif

// The parameters of one dispatch over centers.
struct EvaluateParams {
  int first; // first center
  int last;  // past the end
  int total;
  int samples;
  float radius;        // in buffer units, as are all lengths
  float variate_share; // 0: no control variate
  float adaptive;      // root mean square of the normals' deviation above which all samples are taken
  float map_radius;    // radius at which the map was computed
  float map_sigma;     // of Gaussian windows on the map
  float harris_k;
  float enlargement; // ratio of the sampling ellipse to the radius
  int max_jumps;
  int begin_sample; // first sample of this dispatch
  int end_sample;
  int marks_only; // paper: this dispatch only finds the charts to visit; such dispatches come first
  int unused;
};
BLOCK_OF_VECTORS CenterData {
  vec3 position; // in buffer units
  int chart;
  vec3 normal;  // unit
  float phase;  // rotation of the pattern in radians
  vec4 uv;      // (u, v) of the evaluation; (u, v) slightly inside the chart, where marches start
  vec4 ellipse; // columns of the 2x2 map from the unit disk to (u, v) offsets
};
BLOCK_OF_VECTORS VisitData {
  vec4 linear; // columns of the linear part of the maps over the seams crossed
  vec2 center; // the center carried by these maps, in texels
  int chart, seam;
  int next;       // the next visit of the same chart, cyclically
  float crossing; // distance from the center to where the seam was met
  vec2 unused;
};
BLOCK_OF_VECTORS EdgeData {
  vec4 uv;     // u0, v0, u1, v1
  ivec4 owner; // chart, triangle, the numbers of its corners at (u0, v0) and (u1, v1)
};

#undef BLOCK_OF_VECTORS
#ifdef __cplusplus
} // namespace paradesc
#endif

#endif
