// Structs, limits and bindings that C++ and GLSL both compile, in std430 layout.
#ifndef PARADESC_SHARED_H
#define PARADESC_SHARED_H

#define LIST_ROW 4096 // elements per row of a list texture
#define CELL_LEAVES 4 // of a cell: its parts in the quarters of its block
#define LEAF_LISTS 4  // of a cell: its leaves' coarse samples, one half of these, its fine samples, one half of these
#define LINK_REACH 1.25 // in radii of a cell: where links to it may lie, a texel beyond its points
#define LEAF_RADII 250.0 // steps to the radius of the cell, in the codes of its leaves
#define CELL_TRAITS 3 // of four numbers, of a cell at a radius
#define NEAR_TRAITS 3 // of four numbers, of a cell near centers
#define TREE_BITS 2   // of the number of nodes in a node of the tree of cells
#define CELL_VECTORS (4 + 2 * CELL_LEAVES) // of four floats in CellData
#define MAX_MARCH_STEPS                                                                                                          \
  4096 // guard of the march; a straight line crosses at most 2 x 8192 texels between seams, far less in practice

// Textures by their sampler units, each number once: a stage of a program may have 16 of them.
#define UNIT_WEIGHTS 0     // buffer, RG32F: where the texel lies in its triangle: the weights of the corners 1 and 2
#define UNIT_POSITION 1    // buffer, RGBA32F or RGBA16F: position, area element in units of area_unit (0: no surface)
#define UNIT_NORMAL 2      // buffer, RGBA32F: unit normal; RGBA16F: half.glsl says how
#define UNIT_IDS 3         // buffer, RG32I: chart (-1: none), triangle (-1 - triangle: on a chart-edge line)
#define UNIT_BORDER 4      // buffer, RG32I: free texels around (or -number of border edges in this texel), first list entry
#define UNIT_BORDER_LIST 5 // list, RG32I: border, chart
#define UNIT_BORDER_UV 6   // list, RGBA32F: u0, v0, u1, v1 of each border, the chart on its left
#define UNIT_LINKS 7       // list, RGBA32F, two a border: the matrix of M_e; its image of (u0, v0), twin (or -1 - kind), twin's chart
// Of the measuring of cells.
#define UNIT_LABELS 8 // buffer, RG32I: the cell of each texel, or -1; the part of it that its chart covers, of 65536
#define UNIT_BOXES 9  // list, RGBA32I: low texel, width and height of each cell's box
// Of a layout, and of the mesh's points in it.
#define UNIT_CORNER_UVS 10 // buffer texture, RGBA32F, two a triangle: (u, v) of its corners 0 and 1; (u, v) of corner 2, its chart
#define UNIT_CORNERS 11    // buffer texture, RGBA32I: the bake vertices of each triangle's corners; the bits of 1 over its area in (u, v), twice
#define UNIT_VERTICES 12   // buffer texture, RGBA32F, two a bake vertex: position; normal
#define UNIT_VALUES 13     // buffer texture, RGBA32F: a map's value at each bake vertex
// Of what neighborhoods are sampled from.
#define UNIT_FACES 14   // buffer texture, RGBA32F: unit normal of each triangle, 0 without area; root of twice its area
#define UNIT_MAP 15     // buffer, RGBA32F: gradient of a map, its value
#define UNIT_SAMPLES 16 // buffer texture, RG32I: texel (x + 65536 y); the bits of the area in (u, v) that it stands for, a float
#define UNIT_RANGES 17  // buffer texture, RG32I: first and end in UNIT_SAMPLES, or of the samples of BINDING_TEXELLESS
#define UNIT_POINTS 18  // buffer texture, RGBA32F, two a sample of UNIT_SAMPLES: position, area; normal, extent of a texel
// Of the pass that displaces baked texels.
#define UNIT_HEIGHTS 19  // image, R32F: displacement
#define UNIT_COLORS 20   // image, RGBA32F: normal map
#define UNIT_INPUT_UV 21 // list, RG32F: the caller's (u, v) of each bake vertex
#define UNIT_TANGENTS 22 // list, RGBA32F, two a corner: tangent, sign of the bitangent; normal that goes with it
#define UNIT_EDGES 23    // buffer texture, RGBA32I, two a chart-edge line: the bits of EdgeData
// Of what centers find their neighborhoods in; pairs of numbers unless it says otherwise.
#define UNIT_CELLS 24         // buffer texture, RGBA32F: CellData
#define UNIT_CELL_LISTS 25    // buffer texture, RGBA32I: first and end of a cell in UNIT_ADJACENCY, in UNIT_BOUNDARY
#define UNIT_NEAR_CELLS 26    // buffer texture, R32I: the cells near the centers of each list, sorted
#define UNIT_NEAR_NORMALS 27  // buffer texture, RGBA32F, one a list: the mean normal of its cells
#define UNIT_ADJACENCY 28     // buffer texture: neighboring cell, link
#define UNIT_NEAR_SPHERES 29  // buffer texture, RGBA32F, one of UNIT_NEAR_CELLS: its sphere
#define UNIT_NEAR_TRAITS 30   // buffer texture, RGBA32I, NEAR_TRAITS each: cell, CELL_ bits, projected area, unit of leaf codes; these codes; first and end in UNIT_NEAR_NEIGHBORS, the list
#define UNIT_NEAR_NEIGHBORS 31 // buffer texture, RGBA32I: place of the neighboring cell among those near the same one, or -1; link; first and end in UNIT_LINK_POINTS
#define UNIT_CELL_LINKS 32    // buffer texture: first and end of a link in UNIT_LINK_POINTS
#define UNIT_LINK_POINTS 33   // buffer texture, as UNIT_POINTS: where the surface goes over from cell to cell
#define UNIT_LINK_SPHERES 34  // buffer texture, RGBA32F, one a link: around its points
#define UNIT_LEAF_LISTS 35    // buffer texture, RGBA32I, LEAF_LISTS a cell: first in UNIT_SAMPLES, how many samples each leaf has (16 bits)
#define UNIT_BOUNDARY 36      // buffer texture, RGBA32F: both ends of edges on the mesh's boundary
#define UNIT_STARTS 37        // buffer texture, one a center: first and end in UNIT_START_CELLS
#define UNIT_START_CELLS 38   // buffer texture: a cell that a center starts from, the list of the centers in it; a center is on that of its first one
// Of the mesh as it lies now, and of what its normals are fitted to.
#define UNIT_MESH_POSITIONS 39  // buffer texture, RGB32F, one a vertex: as they were given
#define UNIT_TRIANGLES 40       // buffer texture, RGB32I: the vertices of each triangle
#define UNIT_MESH_NORMALS 41    // buffer texture, RGB32F
#define UNIT_SOURCES 42         // buffer texture: vertex, normal
#define UNIT_RINGS 43           // buffer texture, RGBA32I, one a fan and one more: first in UNIT_FAN_VERTICES, in UNIT_RING_VERTICES, in UNIT_RING_FACES
#define UNIT_FAN_VERTICES 44    // buffer texture, R32I, likewise the next two: as NormalRings has them
#define UNIT_RING_VERTICES 45
#define UNIT_RING_FACES 46
// Of the lists of cells and samples at a radius.
#define UNIT_CELL_TRAITS 47      // buffer texture, RGBA32I, CELL_TRAITS each, the bits of floats: sphere; cone, both with the samples of BINDING_TEXELLESS; area, radius as it was measured, CELL_ bits
#define UNIT_CELL_NODES 48       // buffer texture, RGBA32I, two a node of the tree of cells, as tree.glsl orders them: the bits of a box's low, the node after all that are in this one; those of its high, its cell, or -1
#define UNIT_NEAR_RANGES 49      // buffer texture, RGBA32I, one a list: first and end in UNIT_NEAR_CELLS; first in UNIT_NEAR_NEIGHBORS; how many of its cells have no neighbor on it that lies closer
#define UNIT_START_LISTS 50      // buffer texture, one a list: first and end of its centers
#define UNIT_TEXELLESS_RANGES 51 // buffer texture, one a cell: first and end among the samples of BINDING_TEXELLESS
#define UNIT_STRIDES 52          // buffer texture, one a cell: how often a texel is doubled for a coarse sample of each leaf, for a fine one; 8 bits each
#define UNIT_NEAR_BALLS 53       // buffer texture, RGBA32F, one a list: the ball around those of its centers
#define UNIT_NEAR_LISTS 54       // buffer texture, one of UNIT_NEAR_CELLS: its list; where its neighbors begin among those of the list
// Of what the triangles that are connected to a center are found in.
#define UNIT_PATCH_TRIANGLES 55 // buffer texture, RGBA32I, two a code of Patches: the vertices of its triangle (-1: none), the codes across its edges (-1: none)
#define UNIT_TRIANGLE_CODES 56  // buffer texture, R32I: of each triangle
#define UNIT_PATCH_RANGES 57    // buffer texture, one a patch: first and end in UNIT_PATCH_NEIGHBORS
#define UNIT_PATCH_NEIGHBORS 58 // buffer texture: patch, the bits of its triangles that share an edge with this one
#define UNIT_PATCH_SPHERES 59   // buffer texture, RGBA32F, two a patch: middle in the mesh's units, radius; area
#define UNIT_START_CODES 60     // buffer texture, R32I, one a center: the code of a triangle that it lies on
#define UNIT_COUNT 61

// Uniforms of programs that take few. Programs over centers take EvaluateParams.
#define LOCATION_BUFFER_SIZE 0
#define LOCATION_MIDLEVEL 6 // of the pass that displaces baked texels
#define LOCATION_HEIGHT_SCALE 7 // in buffer units
#define LOCATION_FIRST 2 // invocation, and the one after the last
#define LOCATION_LAST 3
#define LOCATION_BLOCK_SIZE 8
#define LOCATION_RANGES 9 // that the neighborhood of a center has at most
#define LOCATION_LISTS 10 // of near cells: how many there are
#define LOCATION_STRIDE 11 // from place to place, in floats
#define LOCATION_LEVEL 13 // of the tree of cells
#define LOCATION_NODES 14 // that it has
#define LOCATION_AREA_UNIT 30   // of every program that writes or reads the area element

// Images that are written.
#define IMAGE_POSITION 0
#define IMAGE_NORMAL 1
#define IMAGE_DISTORTION 2

// Uniform blocks.
#define BLOCK_EVALUATE 0
#define BLOCK_SPACE 1
#define BLOCK_SEARCH 2

// Storage buffers, each number once: drivers often have 16.
#define BINDING_CENTERS 0
#define BINDING_RESULTS 1
#define BINDING_NEIGHBORHOODS 2 // (centers of one dispatch) the ranges of samples of each center's neighborhood
#define BINDING_TEXELLESS 3     // samples of triangles that no texel carries
#define BINDING_CONNECTED 4     // as floods.glsl has it
#define BINDING_MAP_CENTERS 5   // gradient and value of the map at each center
#define BINDING_MAP_TEXELLESS 6 // the same at the samples of BINDING_TEXELLESS
#define BINDING_CELLS 7         // what was measured of each cell
#define BINDING_POINTS 8        // where UNIT_POINTS is written, or UNIT_LINK_SPHERES
// In the affine and the paper's relocation.
#define BINDING_PATTERN 9
#define BINDING_PROGRESS 10    // (centers of one dispatch)
#define BINDING_STRETCHES 11   // (centers, STRETCH_DIRECTIONS)
#define BINDING_SEAMS 12       // the seam of each border
#define BINDING_VISITS 13      // (centers of one dispatch, MAX_VISITS)
#define BINDING_RANGES 14      // where UNIT_RANGES is written
#define BINDING_COUNT 15
// Of the programs that find neighborhoods.
#define BINDING_WALKS 9 // centers that go over links, and the lists of near cells that these need
#define BINDING_NEAR_SPHERES 10
#define BINDING_NEAR_TRAITS 11
#define BINDING_NEAR_NEIGHBORS 12
#define BINDING_COUNTS 13
// Of those that list cells and samples: where the textures of these names are written.
#define BINDING_CELL_TRAITS 8
#define BINDING_CELL_NODES 9
#define BINDING_STRIDES 10
#define BINDING_LEAF_LISTS 11
#define BINDING_SAMPLES 12
#define BINDING_NEAR_CELLS 8
#define BINDING_NEAR_RANGES 9
#define BINDING_NEAR_NORMALS 10
#define BINDING_NEAR_BALLS 11
#define BINDING_NEAR_LISTS 14
#define BINDING_FOUND_CELLS 12 // (lists, SearchParams::room.longest) cells of each list
// Of those that find where the mesh lies.
#define BINDING_PLACES 0  // position and normal, LOCATION_STRIDE floats from place to place
#define BINDING_FACES 1   // where UNIT_FACES is written
#define BINDING_NORMALS 2 // where UNIT_MESH_NORMALS is written
#define BINDING_PATCH_SPHERES 8 // where UNIT_PATCH_SPHERES is written
#define STRETCH_DIRECTIONS 16  // of the directional ellipse
#define MAX_VISITS 64          // charts, by way of a seam each, that one center's pattern is repeated on

// llvmpipe silently ends all loops of an invocation after 65535 iterations in total (Mesa's LP_MAX_TGSI_LOOP_ITERATIONS): what
// would go beyond this many counts as missing area instead.
#define MAX_ITERATIONS 60000

// Where the second moments of a neighborhood deviate from a flat disk's by more than this part, it is ambiguous: samples may have come in that
// are not connected within the ball.
#define DISK_DEVIATION 0.1
#define PATCH_TRIANGLES 32 // of a patch at most: a bit each of one word
#define MOST_FEW_PATCHES 32 // that a flood looks through one after the other
// Integers of BINDING_CONNECTED: how many centers are ambiguous, how many patches a flood came to at most, and how many centers of a round are
// computed again, with the dispatch of these as OpenGL takes it from a buffer.
#define CONNECTED_AMBIGUOUS 0
#define CONNECTED_PATCHES 1
#define CONNECTED_AGAIN_GROUPS 2
#define CONNECTED_AGAIN 5
#define CONNECTED_HEADER 6

// Rows of the results that come before the descriptors'.
#define ROW_COVERAGE 0
#define ROW_FLAGS 1
#define ROW_AREA 2
#define ROW_DESCRIPTORS 3

// Bits of a center's flags, a whole number among the results' floats.
#define FLAG_HITS_BOUNDARY 1u // the mesh's boundary lies in the neighborhood
#define FLAG_ALL_SAMPLES 2u   // adaptive sampling took all samples

// Integers of BINDING_WALKS: two dispatches, as OpenGL takes them from a buffer, each with how much it has to do; then the lists.
#define WALKS_LISTS_GROUPS 0
#define WALKS_LISTS 3
#define WALKS_CENTERS_GROUPS 4
#define WALKS_CENTERS 7
#define WALKS_HEADER 8

// Bits of a cell among those that centers look through.
#define CELL_JOINED 1      // its coarse samples are the cell's, not its leaves'
#define CELL_AT_BOUNDARY 2 // an edge on the mesh's boundary runs through it
#define CELL_FACES_CENTERS 4  // its normals lie within a cone around those that look at it
#define CELL_FINE_LEAF 8      // and the next ones: this leaf has fine samples

#ifdef __cplusplus
namespace paradesc {
#define BLOCK_OF_VECTORS struct alignas(16)
#else
#define BLOCK_OF_VECTORS struct
ivec2 list_texel(int index) { return ivec2(index % LIST_ROW, index / LIST_ROW); }
#endif

// The parameters of one dispatch over centers.
struct EvaluateParams {
  int first; // centers from here on
  int last;  // past the end
  int total;
  int samples;
  float radius; // in buffer units, as are all lengths
  float variate_share; // 0: no control variate
  float adaptive;      // root mean square of the normals' deviation above which all samples are taken
  float map_radius;    // at which the map was computed
  float map_sigma;     // of Gaussian windows on it
  float harris_k;
  int slots;       // for centers that are computed again side by side
  int flood_table; // places for the patches of each: a power of two, twice as many as there are
  float area_tolerance; // in squares of the radius
  // For samples that march.
  float enlargement;   // of the ellipse that they start in over the radius
  int max_jumps;
  int begin_sample; // those of this dispatch
  int end_sample;
  int marks_only;   // paper: the dispatches that find the charts to visit come before the others
  int unused_0, unused_1;
};
// How long the lists of a search are, or how long they may be.
struct SearchCounts {
  int samples;
  int fine;      // 1: some leaves have fine samples
  int cells;     // near those that centers start in
  int neighbors; // of these cells
  int longest;   // cells of one list
#ifdef __cplusplus
  bool operator==(const SearchCounts &) const = default;
#endif
};
// What these lists are made with.
struct SearchParams {
  float radius;
  float share; // of a disk of that radius, for one sample, in texels
  int seed;
  int block_size;
  int cell_count;
  int top_level; // of the tree of cells, which has no more nodes than a node has
  int unused_0, unused_1;
  SearchCounts room;
};
BLOCK_OF_VECTORS CenterData {
  vec3 position; // in buffer units
  int chart;
  vec3 normal;   // unit
  float phase;   // rotation of the pattern in radians
  vec4 uv;       // (u, v) of the evaluation; (u, v) just inside the chart where marches start
  vec4 ellipse;  // columns of the 2x2 map from the unit disk to (u, v) offsets
};
struct NeighborhoodRanges {
  int first;  // into the list of ranges: of all samples, or of the first half where sampling is adaptive
  int middle; // of the other half
  int last;   // of samples of triangles that no texel carries
  int end;
  float hits_boundary; // above 0 where the mesh's boundary lies in the ball
  float missing_area;  // area of what exceeds the iterations of a device
  int single_sheet;    // the surface in the ball faces one way; others searched by themselves
};
BLOCK_OF_VECTORS TexellessSample {
  vec3 position; // in buffer units
  float area;
  vec3 normal; // unit
  int triangle;
};
BLOCK_OF_VECTORS LeafData {
  vec4 sphere; // around the points of its texels: middle, radius; below 0 where it has none
  vec4 area;   // the area element by which it is sampled, the least cosine between the normal of one texel and the others'
};
BLOCK_OF_VECTORS CellData {
  vec4 sphere; // as a leaf's
  vec4 cone;   // the normal of one texel, the least cosine between it and the others'
  vec4 area;   // of its surface; the sphere's radius as it was measured
  LeafData leaf[CELL_LEAVES];
  ivec4 leaf_codes; // spheres of the leaves, rounded up: 8 bits each of an offset and a radius, in units of the cell's; -1: none
};
BLOCK_OF_VECTORS VisitData {
  vec4 linear; // columns of the linear part of the maps over the seams crossed
  vec2 center; // carried by them, in texels
  int chart, seam;
  int next;       // the next visit of the same chart, in a circle
  float crossing; // from the center to where the seam was met
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
