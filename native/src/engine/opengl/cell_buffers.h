// Cells and their samples on the device: where they are measured, and the points that centers fetch.
#pragma once

#include <span>
#include <vector>

#include "engine/opengl/geometry_buffer.h"
#include "engine/opengl/program.h"
#include "sample/cell_samples.h"
#include "sample/cells.h"

#include "shared.h"

namespace paradesc {

// The largest number of samples whose points are listed beside the buffers: 128 MiB.
inline constexpr int max_listed_points = 1 << 22;

// Reads the surface's points (texels) from the geometry buffer as it is now; each texel is x + size y.
std::vector<vec3> read_points(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer,
                              std::span<const int32_t> texels);

class CellBuffers {
public:
  CellBuffers(const Gl &gl, const Cells &cells, int buffer_size);
  // Measures the cells in the geometry buffer as it is now.
  std::vector<CellData> measure(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer);
  void set_samples(const Gl &gl, const CellSamples &samples);
  // Lists the points of the samples in the geometry buffer as it is now, for centers to fetch instead of its texels. Returns
  // false if that would take too much memory. points: where they go.
  bool list_points(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer, BufferTexture &points) const;
  void bind(const Gl &gl) const;

private:
  Texture labels_;
  ListTexture boxes_;
  Buffer measured_;
  BufferTexture samples_;
  int cell_count_ = 0, block_size_ = 1, sample_count_ = 0;
};

} // namespace paradesc
