// Geometry buffers + evaluation points → descriptors at each point, in tiles between which a computation can be cancelled.
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
  int samples_at_once;                        // samples that march in one dispatch
  bool chords;                                // distances along the surface are sums of chords
  float radius;                               // in buffer units
  float enlargement;                          // of the sampling ellipse over the radius
  int relocation;                             // pdesc_relocation
  int estimator;                              // pdesc_estimator of the curvatures
  bool use_control_variate;                   // subtracts the part of the samples' noise that the shape operator explains
  bool geodesic_ball;                         // the neighborhood ends where the distance along the surface exceeds the radius
  float adaptive;                             // 0: all samples everywhere
  bool displaced = false;                     // the surface is displaced, so its faces differ from the mesh's
  bool exact = false;                         // computes only centers that are computed again, on the triangles connected to them
  const CellBuffers *cells = nullptr;         // samples of the connected relocation
  const NeighborhoodSearch *search = nullptr; // the search for their neighborhoods
  ConnectedTriangles *connected = nullptr;    // the check of these neighborhoods
  const BufferTexture *points = nullptr;      // the points of these samples, if they are listed
  const MapBuffer *map = nullptr;             // read by operators
  float map_radius = 0;                       // radius at which the map was computed, in buffer units
  float map_sigma = 0;                        // sigma of the operators' Gaussian windows, in buffer units
  float harris_k = 0;

  // The most centers of one dispatch: the neighborhoods of all of them are stored side by side, and centers whose samples march
  // keep one or two kilobytes each between dispatches.
  int most_centers() const {
    if (search) return search->most_centers();
    return relocation == PDESC_RELOCATION_PAPER ? 16384 : 65536;
  }
  // Returns whether areas are computed, which face normals make exact.
  bool faces() const;
  // The number of value rows, which follow ROW_DESCRIPTORS in the results.
  size_t value_rows() const;
};

// Decodes a number of ROW_FLAGS: integer bits stored in a float. NaN means, as in all rows, that nothing was written.
inline uint32_t flags_of(float number) { return std::bit_cast<uint32_t>(number); }

// The program that computes these descriptors. buffer_variant: GeometryBuffer::variant(). texelless: some triangles have no
// texel.
GLuint evaluate_program(const Gl &gl, ProgramCache &programs, const EvaluateSettings &settings, const char *buffer_variant,
                        bool texelless);

// The data read back from a device.
struct Evaluated {
  std::vector<float> rows; // (ROW_DESCRIPTORS + value_rows, centers), in buffer units
  SearchCounts counts{};   // lengths of the search's lists, if there was a search
  int ambiguous = 0;       // centers
  int patches = 0;         // the largest number of patches of a flood
};

// The device's state, other than the geometry buffer, that samples read.
class Evaluator {
public:
  // Uploads everything that depends on the layout.
  void set_borders(const Gl &gl, const BorderGrid &grid);
  // Upload everything that depends on a frame.
  void set_centers(const Gl &gl, const std::vector<CenterData> &centers);
  void set_links(const Gl &gl, const std::vector<vec4> &links, const std::vector<int32_t> &seams);
  // Uses centers in an existing buffer of (count) CenterData.
  void use_centers(GLuint centers, int count);
  GLuint centers() const { return used_centers_; }
  int center_count() const { return count_; }
  // Makes room for the results of the centers.
  void begin(const Gl &gl, const EvaluateSettings &settings);
  // texture: as for UNIT_FACES, for settings that ask for faces.
  void use_faces(GLuint texture) { faces_ = texture; }
  // Sets the map's values outside of texels: at the centers, and at the samples of TexellessSamples.
  void set_map(const Gl &gl, const std::vector<vec4> &centers, const std::vector<vec4> &texelless);
  // Computes centers [first, last), in as many dispatches as their memory requires; returns when the device has finished.
  void run(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer, const EvaluateSettings &settings, int first,
           int last);
  // Checks the ambiguous centers [first, last) that run() found, by ConnectedTriangles::flood, and computes again those that
  // fail; returns as run() does.
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
