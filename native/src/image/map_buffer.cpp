// Values at points → vertices and chart edges with a value each → a float texture.
#include "image/map_buffer.h"

#include "bake/seam_links.h"

namespace paradesc {

namespace {

struct MapVertex {
  vec4 value;
  vec2 uv;
};

} // namespace

MapBuffer::MapBuffer(const Gl &gl, int size)
    : gl_(gl), size_(size), map_(gl, size, size, GL_RGBA32F), depth_(gl, size, size, GL_DEPTH_COMPONENT32F) {
  gl.CreateFramebuffers(1, &framebuffer_);
  gl.NamedFramebufferTexture(framebuffer_, GL_COLOR_ATTACHMENT0, map_.id(), 0);
  gl.NamedFramebufferTexture(framebuffer_, GL_DEPTH_ATTACHMENT, depth_.id(), 0);
  gl.CreateVertexArrays(1, &vertex_array_);
  for (GLuint i = 0; i < 2; ++i) {
    gl.EnableVertexArrayAttrib(vertex_array_, i);
    gl.VertexArrayAttribFormat(vertex_array_, i, i == 0 ? 4 : 2, GL_FLOAT, GL_FALSE, i == 0 ? 0 : sizeof(vec4));
    gl.VertexArrayAttribBinding(vertex_array_, i, 0);
  }
}

MapBuffer::~MapBuffer() {
  gl_.DeleteFramebuffers(1, &framebuffer_);
  gl_.DeleteVertexArrays(1, &vertex_array_);
}

void MapBuffer::upload(const MapInput &input) {
  auto value = [&](int32_t corner) {
    const int32_t point = input.half_edges.corner_point[static_cast<size_t>(corner)];
    return point >= 0 ? input.values[static_cast<size_t>(point)] : vec4(0.0f);
  };
  auto uv = [&](int32_t corner) { return input.triangles.corner_uv[static_cast<size_t>(corner)]; };
  std::vector<MapVertex> vertices;
  vertices.reserve(input.vertices.corner.size());
  for (const int32_t corner : input.vertices.corner) vertices.push_back({value(corner), uv(corner)});
  std::vector<EdgeData> edges;
  std::vector<vec4> ends;
  edges.reserve(input.charts.borders.size());
  for (const Border &border : input.charts.borders) {
    const auto [first, second] = border_ends(input.triangles, border);
    EdgeData edge{};
    edge.uv = vec4(uv(first), uv(second));
    edges.push_back(edge);
    ends.push_back(value(first));
    ends.push_back(value(second));
  }
  vertices_.upload(gl_, vertices, GL_STREAM_DRAW);
  index_.upload(gl_, input.vertices.index);
  edges_.upload(gl_, edges, GL_STREAM_DRAW);
  edge_ends_.upload(gl_, ends, GL_STREAM_DRAW);
  index_count_ = vertices.empty() ? 0 : static_cast<GLsizei>(input.vertices.index.size());
  edge_count_ = static_cast<GLsizei>(edges.size());
  gl_.VertexArrayVertexBuffer(vertex_array_, 0, vertices_.id(), 0, sizeof(MapVertex));
  gl_.VertexArrayElementBuffer(vertex_array_, index_.id());
  check_gl(gl_, "map upload");
}

// State and order of drawing are those of GeometryBuffer::bake: each texel falls to the same triangle or edge.
void MapBuffer::bake(ProgramCache &programs, const MapInput &input) {
  upload(input);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  gl_.Viewport(0, 0, size_, size_);
  const float zero[4] = {0, 0, 0, 0}, far_depth = 1.0f;
  gl_.ClearNamedFramebufferfv(framebuffer_, GL_COLOR, 0, zero);
  gl_.ClearNamedFramebufferfv(framebuffer_, GL_DEPTH, 0, &far_depth);
  gl_.Enable(GL_DEPTH_TEST);
  gl_.DepthFunc(GL_LEQUAL);
  gl_.DepthMask(GL_TRUE);
  gl_.Disable(GL_BLEND);
  gl_.UseProgram(programs.get(gl_, "map", {{GL_VERTEX_SHADER, "map.vert.glsl"}, {GL_FRAGMENT_SHADER, "map.frag.glsl"}}));
  gl_.BindVertexArray(vertex_array_);
  gl_.DrawElements(GL_TRIANGLES, index_count_, GL_UNSIGNED_INT, nullptr);
  gl_.DepthFunc(GL_LESS);
  gl_.UseProgram(
      programs.get(gl_, "map edge", {{GL_VERTEX_SHADER, "edge.vert.glsl"}, {GL_FRAGMENT_SHADER, "map_edge.frag.glsl"}}));
  gl_.Uniform1i(0, size_);
  gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_EDGES, edges_.id());
  gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_MAP_EDGES, edge_ends_.id());
  gl_.DrawArrays(GL_TRIANGLES, 0, 6 * edge_count_);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, 0);
  gl_.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_FRAMEBUFFER_BARRIER_BIT);
  check_gl(gl_, "map");
}

std::vector<vec4> MapBuffer::read() const {
  std::vector<vec4> texels(static_cast<size_t>(size_) * static_cast<size_t>(size_));
  gl_.GetTextureImage(map_.id(), 0, GL_RGBA, GL_FLOAT, static_cast<GLsizei>(texels.size() * sizeof(vec4)), texels.data());
  check_gl(gl_, "read-back");
  return texels;
}

} // namespace paradesc
