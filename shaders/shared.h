// Structs, limits and bindings that C++ and GLSL both compile, in std430 layout.
#ifndef PARADESC_SHARED_H
#define PARADESC_SHARED_H

#define LIST_ROW 4096 // elements per row of a list texture
#define CELL_LEAVES 4 // leaves of a cell: its parts in the quarters of its block
#define LEAF_LISTS 4  // lists of a cell: its leaves' coarse samples, one half of these, its fine samples, one half of these
#define LINK_REACH 1.25 // bound of links to a cell, in its radii: one texel beyond its points
#define LEAF_RADII 250.0 // steps per cell radius in the codes of leaves
#define CELL_TRAITS 3 // vectors of four numbers per cell at a radius
#define NEAR_TRAITS 3 // vectors of four numbers per cell near centers
#define TREE_BITS 2   // log2 of the number of children of a node in the tree of cells
#define CELL_VECTORS (4 + 2 * CELL_LEAVES) // vectors of four floats in CellData
#define MAX_MARCH_STEPS                                                                                                          \
  4096 // guard of the march; a straight line crosses at most 2 x 8192 texels between seams, far less in practice

// Sampler units of textures, each number used once: a stage of a program may have 16 of them.
#define UNIT_WEIGHTS 0     // buffer, RG32F: the texel's place in its triangle: the weights of the corners 1 and 2
#define UNIT_POSITION 1    // buffer, RGBA32F or RGBA16F: position, area element in units of area_unit (0: no surface)
#define UNIT_NORMAL 2      // buffer, RGBA32F: unit normal; RGBA16F: half.glsl says how
#define UNIT_IDS 3         // buffer, RG32I: chart (-1: none), triangle (-1 - triangle: on a chart-edge line)
#define UNIT_BORDER 4      // buffer, RG32I: free texels around (or -number of border edges in this texel), first list entry
#define UNIT_BORDER_LIST 5 // list, RG32I: border, chart
#define UNIT_BORDER_UV 6   // list, RGBA32F: u0, v0, u1, v1 of each border, the chart on its left
#define UNIT_LINKS 7       // list, RGBA32F, two a border: the matrix of M_e; its image of (u0, v0), twin (or -1 - kind), twin's chart
// For measuring cells.
#define UNIT_LABELS 8 // buffer, RG32I: the cell of each texel, or -1; the part of it that its chart covers, of 65536
#define UNIT_BOXES 9  // list, RGBA32I: low texel, width and height of each cell's box
// For a layout, and the mesh's points in it.
#define UNIT_CORNER_UVS 10 // buffer texture, RGBA32F, two a triangle: (u, v) of its corners 0 and 1; (u, v) of corner 2, its chart
#define UNIT_CORNERS 11    // buffer texture, RGBA32I: the bake vertices of each triangle's corners; the bits of 1 over its area in (u, v), twice
#define UNIT_VERTICES 12   // buffer texture, RGBA32F, two a bake vertex: position; normal
#define UNIT_VALUES 13     // buffer texture, RGBA32F: a map's value at each bake vertex
// For sampling neighborhoods.
#define UNIT_FACES 14   // buffer texture, RGBA32F: unit normal of each triangle, 0 without area; root of twice its area
#define UNIT_MAP 15     // buffer, RGBA32F: gradient of a map, its value
#define UNIT_SAMPLES 16 // buffer texture, RG32I: texel (x + 65536 y); the bits of the area in (u, v) that it stands for, a float
#define UNIT_RANGES 17  // buffer texture, RG32I: first and end in UNIT_SAMPLES, or of the samples of BINDING_TEXELLESS
#define UNIT_POINTS 18  // buffer texture, RGBA32F, two a sample of UNIT_SAMPLES: position, area; normal, extent of a texel
// For displacing baked texels.
#define UNIT_HEIGHTS 19  // image, R32F: displacement
#define UNIT_COLORS 20   // image, RGBA32F: normal map
#define UNIT_INPUT_UV 21 // list, RG32F: the caller's (u, v) of each bake vertex
#define UNIT_TANGENTS 22 // list, RGBA32F, two a corner: tangent, sign of the bitangent; normal that goes with it
#define UNIT_EDGES 23    // buffer texture, RGBA32I, two a chart-edge line: the bits of EdgeData
// For finding neighborhoods; two integers each unless stated otherwise.
#define UNIT_CELLS 24         // buffer texture, RGBA32F: CellData
#define UNIT_CELL_LISTS 25    // buffer texture, RGBA32I: first and end of a cell in UNIT_ADJACENCY, in UNIT_BOUNDARY
#define UNIT_NEAR_CELLS 26    // buffer texture, R32I: the cells near the centers of each list, sorted
#define UNIT_NEAR_NORMALS 27  // buffer texture, RGBA32F, one a list: the mean normal of its cells
#define UNIT_ADJACENCY 28     // buffer texture: neighboring cell, link
#define UNIT_NEAR_SPHERES 29  // buffer texture, RGBA32F, one of UNIT_NEAR_CELLS: its sphere
#define UNIT_NEAR_TRAITS 30   // buffer texture, RGBA32I, NEAR_TRAITS each: cell, CELL_ bits, projected area, unit of leaf codes; these codes; first and end in UNIT_NEAR_NEIGHBORS, the list
#define UNIT_NEAR_NEIGHBORS 31 // buffer texture, RGBA32I: place of the neighboring cell among those near the same one, or -1; link; first and end in UNIT_LINK_POINTS
#define UNIT_CELL_LINKS 32    // buffer texture: first and end of a link in UNIT_LINK_POINTS
#define UNIT_LINK_POINTS 33   // buffer texture, as UNIT_POINTS: points where the surface crosses from cell to cell
#define UNIT_LINK_SPHERES 34  // buffer texture, RGBA32F, one a link: around its points
#define UNIT_LEAF_LISTS 35    // buffer texture, RGBA32I, LEAF_LISTS a cell: first in UNIT_SAMPLES, how many samples each leaf has (16 bits)
#define UNIT_BOUNDARY 36      // buffer texture, RGBA32F: both ends of edges on the mesh's boundary
#define UNIT_STARTS 37        // buffer texture, one a center: first and end in UNIT_START_CELLS
#define UNIT_START_CELLS 38   // buffer texture: a cell that a center starts from; for the center's first one, also the list that the center is on
// For the current mesh, and for fitting its normals.
#define UNIT_MESH_POSITIONS 39  // buffer texture, RGB32F, one a vertex: in the caller's units
#define UNIT_TRIANGLES 40       // buffer texture, RGB32I: the vertices of each triangle
#define UNIT_MESH_NORMALS 41    // buffer texture, RGB32F
#define UNIT_SOURCES 42         // buffer texture: vertex, normal
#define UNIT_RINGS 43           // buffer texture, RGBA32I, one a fan and one more: first in UNIT_FAN_VERTICES, in UNIT_RING_VERTICES, in UNIT_RING_FACES
#define UNIT_FAN_VERTICES 44    // buffer texture, R32I, like the next two: the arrays of NormalRings
#define UNIT_RING_VERTICES 45
#define UNIT_RING_FACES 46
// For listing cells and samples at a radius.
#define UNIT_CELL_TRAITS 47      // buffer texture, RGBA32I, CELL_TRAITS each, the bits of floats: sphere; cone, both with the samples of BINDING_TEXELLESS; area, radius as it was measured, CELL_ bits
#define UNIT_CELL_NODES 48       // buffer texture, RGBA32I, two a node of the tree of cells, as tree.glsl orders them: the bits of a box's low, the node after all that are in this one; those of its high, its cell, or -1
#define UNIT_NEAR_RANGES 49      // buffer texture, RGBA32I, one a list: first and end in UNIT_NEAR_CELLS; first in UNIT_NEAR_NEIGHBORS; how many of its cells have no closer neighbor on the list
#define UNIT_START_LISTS 50      // buffer texture, one a list: first and end of its centers
#define UNIT_TEXELLESS_RANGES 51 // buffer texture, one a cell: first and end among the samples of BINDING_TEXELLESS
#define UNIT_STRIDES 52          // buffer texture, one a cell: how often a texel is doubled for a coarse sample of each leaf, for a fine one; 8 bits each
#define UNIT_NEAR_BALLS 53       // buffer texture, RGBA32F, one a list: the ball around those of its centers
#define UNIT_NEAR_LISTS 54       // buffer texture, one of UNIT_NEAR_CELLS: its list; where its neighbors begin among those of the list
// For finding the triangles that are connected to a center.
#define UNIT_PATCH_TRIANGLES 55 // buffer texture, RGBA32I, two a code of Patches: the vertices of its triangle (-1: none), the codes across its edges (-1: none)
#define UNIT_TRIANGLE_CODES 56  // buffer texture, R32I: of each triangle
#define UNIT_PATCH_RANGES 57    // buffer texture, one a patch: first and end in UNIT_PATCH_NEIGHBORS
#define UNIT_PATCH_NEIGHBORS 58 // buffer texture: patch, the bits of its triangles that share an edge with this one
#define UNIT_PATCH_SPHERES 59   // buffer texture, RGBA32F, two a patch: middle in the mesh's units, radius; area
#define UNIT_START_CODES 60     // buffer texture, R32I, one a center: the code of a triangle that it lies on
#define UNIT_COUNT 61

// Uniforms of programs with few parameters. Programs over centers use EvaluateParams.
#define LOCATION_BUFFER_SIZE 0
#define LOCATION_MIDLEVEL 6 // for displacing baked texels
#define LOCATION_HEIGHT_SCALE 7 // in buffer units
#define LOCATION_FIRST 2 // first invocation, and the one after the last
#define LOCATION_LAST 3
#define LOCATION_BLOCK_SIZE 8
#define LOCATION_RANGES 9 // largest number of ranges of a center's neighborhood
#define LOCATION_LISTS 10 // number of lists of near cells
#define LOCATION_STRIDE 11 // from place to place, in floats
#define LOCATION_LEVEL 13 // of the tree of cells
#define LOCATION_NODES 14 // number of nodes of the tree
#define LOCATION_AREA_UNIT 30   // for every program that writes or reads the area element

// Image units of images that are written.
#define IMAGE_POSITION 0
#define IMAGE_NORMAL 1
#define IMAGE_DISTORTION 2

// Uniform blocks.
#define BLOCK_EVALUATE 0
#define BLOCK_SPACE 1
#define BLOCK_SEARCH 2

// Bindings of storage buffers. A number may recur in programs of different kinds: drivers often have only 16.
#define BINDING_CENTERS 0
#define BINDING_RESULTS 1
#define BINDING_NEIGHBORHOODS 2 // (centers of one dispatch) the ranges of samples of each center's neighborhood
#define BINDING_TEXELLESS 3     // samples of triangles that no texel carries
#define BINDING_CONNECTED 4     // see floods.glsl
#define BINDING_MAP_CENTERS 5   // gradient and value of the map at each center
#define BINDING_MAP_TEXELLESS 6 // the same at the samples of BINDING_TEXELLESS
#define BINDING_CELLS 7         // measurements of each cell
#define BINDING_POINTS 8        // output: UNIT_POINTS or UNIT_LINK_SPHERES
// For the affine and the paper's relocation.
#define BINDING_PATTERN 9
#define BINDING_PROGRESS 10    // (centers of one dispatch)
#define BINDING_STRETCHES 11   // (centers, STRETCH_DIRECTIONS)
#define BINDING_SEAMS 12       // the seam of each border
#define BINDING_VISITS 13      // (centers of one dispatch, MAX_VISITS)
#define BINDING_RANGES 14      // output: UNIT_RANGES
#define BINDING_COUNT 15
// For the programs that find neighborhoods.
#define BINDING_WALKS 9 // centers that follow links, and the lists of near cells that these need
#define BINDING_NEAR_SPHERES 10
#define BINDING_NEAR_TRAITS 11
#define BINDING_NEAR_NEIGHBORS 12
#define BINDING_COUNTS 13
// For the programs that list cells and samples; they write the textures of these names.
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
// For the programs that place the mesh.
#define BINDING_PLACES 0  // position and normal, LOCATION_STRIDE floats from place to place
#define BINDING_FACES 1   // output: UNIT_FACES
#define BINDING_NORMALS 2 // output: UNIT_MESH_NORMALS
#define BINDING_PATCH_SPHERES 8 // output: UNIT_PATCH_SPHERES
#define STRETCH_DIRECTIONS 16  // of the directional ellipse
#define MAX_VISITS 64          // the most charts, each entered by one seam, on which a center's pattern is repeated

// llvmpipe silently ends all loops of an invocation after 65535 iterations in total (Mesa's LP_MAX_TGSI_LOOP_ITERATIONS). Samples
// beyond this limit count as missing area instead.
#define MAX_ITERATIONS 60000

// A neighborhood whose second moments deviate from a flat disk's by more than this share is ambiguous: it may contain samples
// that are not connected to the center within the ball.
#define DISK_DEVIATION 0.1
#define PATCH_TRIANGLES 32 // triangles of a patch, at most: one bit each in a word
#define MOST_FEW_PATCHES 32 // patches, at most, that a flood searches linearly
// Integers of BINDING_CONNECTED: the number of ambiguous centers, the largest number of patches of a flood, and the number of
// centers of a round that are computed again, with their dispatch as OpenGL takes it from a buffer.
#define CONNECTED_AMBIGUOUS 0
#define CONNECTED_PATCHES 1
#define CONNECTED_AGAIN_GROUPS 2
#define CONNECTED_AGAIN 5
#define CONNECTED_HEADER 6

// Rows of the results that precede those of the descriptors.
#define ROW_COVERAGE 0
#define ROW_FLAGS 1
#define ROW_AREA 2
#define ROW_DESCRIPTORS 3

// Bits of a center's flags, stored as an integer among the results' floats.
#define FLAG_HITS_BOUNDARY 1u // the mesh's boundary lies in the neighborhood
#define FLAG_ALL_SAMPLES 2u   // adaptive sampling took all samples

// Integers of BINDING_WALKS: two dispatches as OpenGL takes them from a buffer, each with its number of elements; then the lists.
#define WALKS_LISTS_GROUPS 0
#define WALKS_LISTS 3
#define WALKS_CENTERS_GROUPS 4
#define WALKS_CENTERS 7
#define WALKS_HEADER 8

// Bits of a cell near centers.
#define CELL_JOINED 1      // coarse samples belong to the cell as a whole, not to its leaves
#define CELL_AT_BOUNDARY 2 // an edge on the mesh's boundary runs through it
#define CELL_FACES_CENTERS 4  // its normals lie within a cone around those of its centers
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
  int first; // first center
  int last;  // past the end
  int total;
  int samples;
  float radius; // in buffer units, as are all lengths
  float variate_share; // 0: no control variate
  float adaptive;      // root mean square of the normals' deviation above which all samples are taken
  float map_radius;    // radius at which the map was computed
  float map_sigma;     // of Gaussian windows on the map
  float harris_k;
  int slots;       // number of centers that are computed again side by side
  int flood_table; // size of each one's hash table of patches: a power of two, at least twice their number
  float area_tolerance; // in squares of the radius
  // Parameters of samples that march.
  float enlargement;   // ratio of the sampling ellipse to the radius
  int max_jumps;
  int begin_sample; // first sample of this dispatch
  int end_sample;
  int marks_only;   // paper: this dispatch only finds the charts to visit; such dispatches come first
  int unused_0, unused_1;
};
// The lengths of a search's lists, or their capacities.
struct SearchCounts {
  int samples;
  int fine;      // 1: some leaves have fine samples
  int cells;     // near the cells that centers start in
  int neighbors; // of these cells
  int longest;   // cells of one list
#ifdef __cplusplus
  bool operator==(const SearchCounts &) const = default;
#endif
};
// The parameters of these lists.
struct SearchParams {
  float radius;
  float share; // of a disk of that radius: the area of one sample, in texels
  int seed;
  int block_size;
  int cell_count;
  int top_level; // of the tree of cells: this level has at most as many nodes as a node has children
  int unused_0, unused_1;
  SearchCounts room;
};
BLOCK_OF_VECTORS CenterData {
  vec3 position; // in buffer units
  int chart;
  vec3 normal;   // unit
  float phase;   // rotation of the pattern in radians
  vec4 uv;       // (u, v) of the evaluation; (u, v) slightly inside the chart, where marches start
  vec4 ellipse;  // columns of the 2x2 map from the unit disk to (u, v) offsets
};
struct NeighborhoodRanges {
  int first;  // into the list of ranges: of all samples, or of the first half if sampling is adaptive
  int middle; // of the other half
  int last;   // of samples of triangles without texels
  int end;
  float hits_boundary; // above 0 if the mesh's boundary lies in the ball
  float missing_area;  // area of samples beyond a device's iterations
  int single_sheet;    // 1: the surface in the ball faces one way; 0: links were followed
};
BLOCK_OF_VECTORS TexellessSample {
  vec3 position; // in buffer units
  float area;
  vec3 normal; // unit
  int triangle;
};
BLOCK_OF_VECTORS LeafData {
  vec4 sphere; // around its texels' points: middle, radius; radius below 0 if it has none
  vec4 area;   // area element for sampling; least cosine between the normals of one texel and of the others
};
BLOCK_OF_VECTORS CellData {
  vec4 sphere; // as a leaf's
  vec4 cone;   // the normal of one texel; its least cosine with the others' normals
  vec4 area;   // of its surface; radius of the sphere as measured
  LeafData leaf[CELL_LEAVES];
  ivec4 leaf_codes; // spheres of the leaves, rounded up: 8 bits each of an offset and a radius, in units of the cell's; -1: none
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
