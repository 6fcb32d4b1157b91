// A built mesh → its baked buffers, read back. Tests on the software device skip where there is none.
#pragma once

#include <memory>

#include <gtest/gtest.h>

#include "bake/shapes.h"
#include "engine/paper/geometry_buffer.h"
#include "engine/paper/gl_thread.h"
#include "mesh/normals.h"
#include "support/on_device.h"

namespace paradesc::test {

struct Buffers {
  int size = 0;
  BakeSpace bake_space;
  Normals normals;
  std::vector<vec4> forms, position, normal, distortion;
  std::vector<int32_t> ids;
  TexelCounts counts;
  int32_t chart(int x, int y) const { return ids[2 * at(y * size + x)]; }
  int32_t triangle(int x, int y) const { return ids[2 * at(y * size + x) + 1]; }
  vec4 position_at(int x, int y) const { return position[at(y * size + x)]; }
  dvec2 center(int x, int y) const { return dvec2(x + 0.5, y + 0.5) / static_cast<double>(size); }
};

inline TexelCounts draw_layout(GeometryBuffer &buffer, ProgramCache &programs, const BakeInput &input) {
  buffer.begin_layout(input.charts);
  buffer.draw_triangles(programs, 0, buffer.triangle_count());
  buffer.draw_borders(programs);
  return buffer.end_layout(programs);
}

inline void draw_frame(GeometryBuffer &buffer, ProgramCache &programs, const BakeInput &input, const Normals &normals) {
  buffer.place_corners(input, normals);
  buffer.draw_surface(programs, 0, buffer.size());
}

// bakes: how often, into the same buffer.
inline Buffers bake(GlThread &thread, const Built &built, int size, int bakes = 1, bool half = false) {
  Buffers buffers;
  buffers.size = size;
  buffers.bake_space = bake_space_of(bounding_box(built.triangles, built.half_edges));
  const NormalRings rings = build_normal_rings(built.triangles, built.half_edges);
  buffers.normals = compute_normals(built.triangles, built.half_edges, rings, PDESC_NORMALS_FITTED, 0);
  for (size_t t = 0; t < at(built.triangles.triangle_count); ++t)
    buffers.forms.push_back(built.charts.triangle_chart[t] < 0 ? vec4(0.0f)
                                                               : form_of(built.triangles, built.charts, buffers.bake_space, t));
  thread.run([&](const Gl &gl, ProgramCache &programs) {
    GeometryBuffer buffer(gl, size, half);
    const BakeInput input{built.triangles, built.charts, buffers.bake_space};
    buffers.counts = draw_layout(buffer, programs, input);
    for (int i = 0; i < bakes; ++i) draw_frame(buffer, programs, input, buffers.normals);
    buffers.position = buffer.read_position();
    buffers.normal = buffer.read_normal();
    buffers.distortion = buffer.read_distortion(programs);
    buffers.ids = buffer.read_ids();
  });
  return buffers;
}

} // namespace paradesc::test
