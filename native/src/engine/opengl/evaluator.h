// Geometry buffers + evaluation points → descriptors at each point, in tiles that can be cancelled between.
#pragma once

#include <bit>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "engine/opengl/cell_buffers.h"
#include "engine/opengl/connected_triangles.h"
#include "engine/opengl/geometry_buffer.h"
#include "engine/opengl/map_buffer.h"
#include "engine/opengl/neighborhood_search.h"
#include "engine/opengl/program.h"
#include "sample/border_grid.h"

#include "shared.h"

namespace paradesc {

struct EvaluateSettings {
  std::span<const int> descriptors; // indices into the registry
  int samples;
  uint32_t seed;
  int max_jumps;
  int pattern;                                // pdesc_pattern
  int ellipse;                                // pdesc_ellipse
  int samples_at_once;                        // how many march in one dispatch
  bool chords;                                // distances along the surface are sums of chords
  float radius;                               // in buffer units
  float enlargement;                          // of the sampling ellipse over the radius
  int relocation;                             // pdesc_relocation
  int estimator;                              // pdesc_estimator of the curvatures
  bool use_control_variate;                   // which takes the noise of samples from what the shape operator explains
  bool geodesic_ball;                         // the neighborhood ends where the distance along the surface exceeds the radius
  float adaptive;                             // 0: all samples everywhere
  bool displaced = false;                     // the surface is displaced: its faces are not the mesh's
  bool exact = false;                         // only centers that are computed again, on the triangles connected to them
  const CellBuffers *cells = nullptr;         // what samples of the connected relocation read
  const NeighborhoodSearch *search = nullptr; // and what finds their neighborhoods
  ConnectedTriangles *connected = nullptr;    // and what checks them
  const BufferTexture *points = nullptr;      // the points of these samples, if they are listed
  const MapBuffer *map = nullptr;             // what operators read
  float map_radius = 0;                       // at which it was computed, in buffer units
  float map_sigma = 0;                        // of their Gaussian windows, in buffer units
  float harris_k = 0;

  // Centers that a dispatch may hold: neighborhoods of all of them lie side by side, and those that march leave a kilobyte or
  // two each between dispatches.
  int most_centers() const {
    if (search) return search->most_centers();
    return relocation == PDESC_RELOCATION_PAPER ? 16384 : 65536;
  }
  // Whether areas are measured, which the normals of faces make exact.
  bool faces() const;
  // Rows of values among the results, after ROW_DESCRIPTORS.
  size_t value_rows() const;
};

// A number of ROW_FLAGS: bits of whole numbers, where the others are floats; NaN, as everywhere, where nothing was written.
inline uint32_t flags_of(float number) { return std::bit_cast<uint32_t>(number); }

// The program that computes these descriptors. buffer_variant: GeometryBuffer::variant(). texelless: some triangles have no
// texel.
GLuint evaluate_program(const Gl &gl, ProgramCache &programs, const EvaluateSettings &settings, const char *buffer_variant,
                        bool texelless);

// What is read back of a device.
struct Evaluated {
  std::vector<float> rows; // (ROW_DESCRIPTORS + value_rows, centers), in buffer units
  SearchCounts counts{};   // how long the lists were that neighborhoods were found in, if they were
  int ambiguous = 0;       // centers
  int patches = 0;         // that a flood came to, at most
};

// The part of the device's state that samples read beside the geometry buffer.
class Evaluator {
public:
  // Uploads what depends on the layout.
  void set_borders(const Gl &gl, const BorderGrid &grid);
  // Upload what depends on a frame.
  void set_centers(const Gl &gl, const std::vector<CenterData> &centers);
  void set_links(const Gl &gl, const std::vector<vec4> &links, const std::vector<int32_t> &seams);
  // Takes centers from a buffer that is there already, (count) CenterData.
  void use_centers(GLuint centers, int count);
  GLuint centers() const { return used_centers_; }
  int center_count() const { return count_; }
  // Makes room for their results.
  void begin(const Gl &gl, const EvaluateSettings &settings);
  // As UNIT_FACES says, for settings that ask for faces.
  void use_faces(GLuint texture) { faces_ = texture; }
  // The map where it is not read from texels: at the centers, and at the samples of TexellessSamples.
  void set_map(const Gl &gl, const std::vector<vec4> &centers, const std::vector<vec4> &texelless);
  // Computes centers [first, last), in as many dispatches as have room for them; returns when the device has finished.
  void run(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer, const EvaluateSettings &settings, int first,
           int last);
  // Looks at the ambiguous centers [first, last) that run() found, as ConnectedTriangles::flood, and computes again what has to
  // be; returns as run() does.
  void check(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer, const DeviceSurface &surface,
             EvaluateSettings settings, int first, int last);
  void read(const Gl &gl, const EvaluateSettings &settings, Evaluated &read) const;

private:
  void use_params(const Gl &gl, const EvaluateParams &params);
  GLuint use_program(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer, const EvaluateSettings &settings) const;
  EvaluateParams params_of(const EvaluateSettings &settings, int first, int last) const;
  void bind(const Gl &gl, const EvaluateSettings &settings) const;
  void bind_march(const Gl &gl) const;
  size_t centers_side_by_side(const Gl &gl, const EvaluateSettings &settings) const;
  void dispatch_marches(const Gl &gl, GLuint program, const EvaluateSettings &settings, EvaluateParams params);
  void find_stretches(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer, const EvaluateParams &params) const;

  Texture border_;
  ListTexture border_list_, border_uv_, links_;
  Buffer params_, centers_, pattern_, results_, seams_, visits_, stretches_, progress_, map_centers_, map_texelless_;
  GLuint used_centers_ = 0, faces_ = 0;
  int count_ = 0;
};

} // namespace paradesc
