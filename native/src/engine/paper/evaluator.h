// Geometry buffers + evaluation points → descriptors at each point, in tiles between which a computation can be cancelled.
#pragma once

#include <bit>
#include <span>
#include <vector>

#include "engine/paper/border_grid.h"
#include "engine/paper/geometry_buffer.h"
#include "engine/paper/program.h"

#include "shared.h"

namespace paradesc {

inline constexpr int most_centers_of_paper = 16384, most_centers_of_affine = 65536;

struct EvaluateSettings {
  std::span<const int> descriptors; // indices into the registry
  int samples;
  uint32_t seed;
  int max_jumps;
  int pattern;              // pdesc_pattern
  int ellipse;              // pdesc_ellipse
  int samples_at_once;      // samples that march in one dispatch
  bool chords;              // distances along the surface are sums of chords
  float radius;             // in buffer units
  float enlargement;        // of the sampling ellipse over the radius
  bool paper;               // the whole pattern again on each chart; else each sample by itself (affine)
  int estimator;            // pdesc_estimator of the curvatures
  bool use_control_variate; // subtracts the part of the samples' noise that the shape operator explains
  bool geodesic_ball;       // the neighborhood ends where the distance along the surface exceeds the radius
  float adaptive;           // 0: all samples everywhere
  bool displaced = false;   // the surface is displaced, so its faces differ from the mesh's
  bool map = false;         // operators read the map of the geometry buffer
  float map_radius = 0;     // radius at which the map was computed, in buffer units
  float map_sigma = 0;      // sigma of the operators' Gaussian windows, in buffer units
  float harris_k = 0;

  // The most centers of one dispatch: each keeps one or two kilobytes between dispatches, and in the paper's way its visits.
  int most_centers() const { return paper ? most_centers_of_paper : most_centers_of_affine; }
  // Returns whether areas are computed, which face normals make exact.
  bool faces() const;
  // The number of value rows, which follow ROW_DESCRIPTORS in the results.
  size_t value_rows() const;
};

// Decodes a number of ROW_FLAGS: integer bits stored in a float. NaN means, as in all rows, that nothing was written.
inline uint32_t flags_of(float number) { return std::bit_cast<uint32_t>(number); }

// The program that computes these descriptors. buffer_variant: GeometryBuffer::variant().
GLuint evaluate_program(const Gl &gl, ProgramCache &programs, const EvaluateSettings &settings, const char *buffer_variant);

// The device's state, other than the geometry buffer, that samples read.
class Evaluator {
public:
  // Uploads everything that depends on the layout.
  void set_borders(const Gl &gl, const BorderGrid &grid);
  // Upload everything that depends on a frame.
  void set_centers(const Gl &gl, const std::vector<CenterData> &centers);
  void set_links(const Gl &gl, const std::vector<vec4> &links, const std::vector<int32_t> &seams);
  int center_count() const { return count_; }
  // Makes room for the results of the centers.
  void begin(const Gl &gl, const EvaluateSettings &settings);
  // Uploads the unit normals of triangles, for settings that ask for faces.
  void set_faces(const Gl &gl, const Triangles &triangles);
  // Sets the map's values at the centers.
  void set_map(const Gl &gl, const std::vector<vec4> &centers);
  // Computes centers [first, last), in as many dispatches as their memory requires; returns when the device has finished.
  void run(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer, const EvaluateSettings &settings, int first,
           int last);
  // rows: (ROW_DESCRIPTORS + value_rows, centers), in buffer units.
  void read(const Gl &gl, const EvaluateSettings &settings, std::vector<float> &rows) const;

private:
  EvaluateParams params_of(const EvaluateSettings &settings, int first, int last) const;
  void bind(const Gl &gl, const GeometryBuffer &buffer, const EvaluateSettings &settings) const;
  void bind_march(const Gl &gl) const;
  size_t centers_side_by_side(const Gl &gl, const EvaluateSettings &settings) const;
  void dispatch_marches(const Gl &gl, GLuint program, const EvaluateSettings &settings, EvaluateParams params);
  void find_stretches(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer, const EvaluateParams &params) const;

  Texture border_;
  Buffer params_, centers_, pattern_, results_, seams_, visits_, stretches_, progress_, map_centers_;
  BufferTexture border_list_, border_uv_, links_, faces_;
  int count_ = 0;
};

} // namespace paradesc
