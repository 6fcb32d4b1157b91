// Geometry buffers + evaluation points → descriptors at each point, in tiles that can be cancelled between.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "bake/gbuffer.h"
#include "gpu/program.h"
#include "sample/neighborhood.h"
#include "shared.h"

namespace paradesc {

struct EvaluateSettings {
  std::span<const int> descriptors; // indices into the registry
  int samples;
  uint32_t seed;
  int max_jumps;
  float radius;       // in buffer units
  int block_size;     // texels, a power of two: supports near seams are sampled block by block
  float enlargement;  // of the sampling ellipse over the radius
};

// The part of the device's state that samples read beside the geometry buffer.
class Evaluator {
public:
  // Of the layout: once per topology.
  void set_borders(const Gl &gl, const BorderGrid &grid);
  // Of a frame. Centers [0, interior) have no border near their support and need no scouts.
  void set_frame(const Gl &gl, const std::vector<vec4> &links, const std::vector<CenterData> &centers, int interior);
  void set_settings(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer, const EvaluateSettings &settings);
  int center_count() const { return count_; }
  // Computes centers [first, last); returns when the device has finished.
  void run(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer, const EvaluateSettings &settings, int first, int last) const;
  // (ROW_DESCRIPTORS + descriptors, centers), in buffer units.
  std::vector<float> read(const Gl &gl, const EvaluateSettings &settings) const;

private:
  void find_windows(const Gl &gl, ProgramCache &programs, const EvaluateSettings &settings, int first, int last, int buffer_size) const;

  Texture border_, blocks_;
  ListTexture border_list_, border_uv_, links_;
  Buffer centers_, scouts_, windows_, searches_, active_, results_;
  int count_ = 0, interior_ = 0;
};

// GLSL that composes the descriptors asked for into one dispatch.
std::string compose_descriptors(std::span<const int> descriptors);

} // namespace paradesc
