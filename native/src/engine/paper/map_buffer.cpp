// Values at points → values at corners → a float texture.
#include "engine/paper/map_buffer.h"

namespace paradesc {

void MapBuffer::bake(ProgramCache &programs, GeometryBuffer &buffer, const MapInput &input) {
  std::vector<vec4> values;
  values.reserve(input.half_edges.corner_point.size());
  for (const int32_t point : input.half_edges.corner_point) values.push_back(point >= 0 ? input.values[point] : vec4(0.0f));
  buffer.draw_map(programs, values, map_);
}

std::vector<vec4> MapBuffer::read() const {
  std::vector<vec4> texels(static_cast<size_t>(size_) * static_cast<size_t>(size_));
  gl_.GetTextureImage(map_.id(), 0, GL_RGBA, GL_FLOAT, static_cast<GLsizei>(texels.size() * sizeof(vec4)), texels.data());
  check_gl(gl_, "read-back");
  return texels;
}

} // namespace paradesc
