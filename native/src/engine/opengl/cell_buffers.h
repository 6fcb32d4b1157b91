// Cells and their samples on the device: where they are measured, and the points that centers fetch.
#pragma once

#include <vector>

#include "engine/opengl/geometry_buffer.h"
#include "engine/opengl/program.h"
#include "sample/cell_samples.h"
#include "sample/cells.h"

#include "shared.h"

namespace paradesc {

// The largest number of samples whose points are listed beside the buffers: 128 MiB.
inline constexpr int max_listed_points = 1 << 22;

class CellBuffers {
public:
  CellBuffers(const Gl &gl, const Cells &cells, int buffer_size);
  // Measures the cells in the geometry buffer as it is now.
  std::vector<CellData> measure(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer);
  void set_samples(const Gl &gl, const CellSamples &samples);
  // Lists the points of the samples in the geometry buffer as it is now, for centers to fetch instead of its texels. Returns
  // false if that would take too much memory. points: where they go.
  bool list_points(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer, BufferTexture &points) const;
  // Lists the points of the links in the geometry buffer as it is now.
  void list_link_points(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer);
  void bind(const Gl &gl) const;
  // Binds what neighborhoods are found in: cells as they were measured, links, and where samples are listed.
  void bind_to_search(const Gl &gl) const;
  GLuint measured() const { return measured_.buffer_id(); } // (cells) CellData

private:
  Texture labels_;
  ListTexture boxes_;
  BufferTexture measured_, adjacency_, links_, link_texels_, link_points_, link_spheres_, samples_, leaf_lists_;
  int cell_count_ = 0, block_size_ = 1, link_count_ = 0, link_texel_count_ = 0, sample_count_ = 0;
};

} // namespace paradesc
