// Triangles and chart edges → the owner of each texel → float textures of surface points, one per texel.
#include "engine/paper/geometry_buffer.h"

#include <algorithm>
#include <cmath>

#include "engine/paper/dispatch.h"
#include "engine/paper/half.h"
#include "support/error.h"

namespace paradesc {

static GLuint make_framebuffer(const Gl &gl, std::initializer_list<GLuint> colors) {
  constexpr GLenum targets[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
  GLuint framebuffer = 0;
  gl.CreateFramebuffers(1, &framebuffer);
  for (size_t i = 0; i < colors.size(); ++i) gl.NamedFramebufferTexture(framebuffer, targets[i], colors.begin()[i], 0);
  gl.NamedFramebufferDrawBuffers(framebuffer, static_cast<GLsizei>(colors.size()), targets);
  return framebuffer;
}

GeometryBuffer::GeometryBuffer(const Gl &gl, int size, bool half)
    : gl_(gl), size_(size), half_(half), position_(gl, size, size, half ? GL_RGBA16F : GL_RGBA32F),
      normal_(gl, size, size, half ? GL_RGBA16F : GL_RGBA32F), ids_(gl, size, size, GL_RG32I), weights_(gl, size, size, GL_RG32F),
      layout_framebuffer_(gl, make_framebuffer(gl, {ids_.id(), weights_.id()})),
      surface_framebuffer_(gl, make_framebuffer(gl, {position_.id(), normal_.id()})) {
  GLuint vertex_array = 0;
  gl.CreateVertexArrays(1, &vertex_array);
  no_attributes_ = {gl, vertex_array};
  check_gl(gl, "buffers");
  for (const GLuint framebuffer : {layout_framebuffer_.id(), surface_framebuffer_.id()})
    if (gl.CheckNamedFramebufferStatus(framebuffer, GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
      throw Error(PDESC_ERROR_UNSUPPORTED, "This device cannot draw into float buffers of " + std::to_string(size) + " x " +
                                               std::to_string(size) + " texels; use smaller buffers or the reference backend.");
}

double GeometryBuffer::megabytes() const {
  constexpr int ids = 8, weights = 8;
  const int floats = 2 * 4 * (half_ ? 2 : 4); // position and normal
  return 1e-6 * (floats + ids + weights) * size_ * size_;
}

// ---- The layout

static std::vector<EdgeData> edge_data(const Charts &charts) {
  std::vector<EdgeData> edges;
  edges.reserve(charts.borders.size());
  for (const Border &border : charts.borders) {
    const auto [first, second] = border_ends(charts, border);
    const auto a = static_cast<size_t>(first), b = static_cast<size_t>(second);
    edges.push_back(
        {vec4(charts.corner_uv[a], charts.corner_uv[b]), ivec4(border.chart, border.half_edge / 3, first % 3, second % 3)});
  }
  return edges;
}

void GeometryBuffer::begin_layout(const Charts &charts) {
  const auto count = charts.triangle_chart.size();
  std::vector<vec4> corner_uvs(2 * count, vec4(0.0f)); // all zero for triangles on no chart: one point, which draws nothing
  area_in_map_ = 0.0;
  for (size_t t = 0; t < count; ++t) {
    if (charts.triangle_chart[t] < 0) continue;
    const vec2 *uv = &charts.corner_uv[3 * t];
    const double area = std::abs(cross(dvec2(uv[1]) - dvec2(uv[0]), dvec2(uv[2]) - dvec2(uv[0])));
    corner_uvs[2 * t] = vec4(uv[0], uv[1]);
    corner_uvs[2 * t + 1] = vec4(uv[2], static_cast<float>(charts.triangle_chart[t]), static_cast<float>(1.0 / area));
    area_in_map_ += area;
  }
  triangle_count_ = charts.chart_count > 0 ? static_cast<int>(count) : 0;
  corner_uvs_.upload(gl_, GL_RGBA32F, corner_uvs, GL_STATIC_DRAW);
  const std::vector<EdgeData> edges = edge_data(charts);
  drawing_ = std::make_unique<Drawing>();
  drawing_->edges.upload(gl_, GL_RGBA32I, edges, GL_STATIC_DRAW);
  drawing_->edge_count = static_cast<GLsizei>(edges.size());
  drawing_->depth = Texture(gl_, size_, size_, GL_DEPTH_COMPONENT32F);
  const GLuint framebuffer = layout_framebuffer_.id();
  gl_.NamedFramebufferTexture(framebuffer, GL_DEPTH_ATTACHMENT, drawing_->depth.id(), 0);
  const float zero[4] = {0, 0, 0, 0}, far_depth = 1.0f;
  const GLint none[4] = {-1, -1, 0, 0};
  gl_.ClearNamedFramebufferiv(framebuffer, GL_COLOR, 0, none);
  gl_.ClearNamedFramebufferfv(framebuffer, GL_COLOR, 1, zero);
  gl_.ClearNamedFramebufferfv(framebuffer, GL_DEPTH, 0, &far_depth);
  check_gl(gl_, "layout");
}

void GeometryBuffer::begin_drawing(GLenum depth_function) const {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, layout_framebuffer_.id());
  gl_.Viewport(0, 0, size_, size_);
  gl_.Enable(GL_DEPTH_TEST);
  gl_.DepthMask(GL_TRUE);
  gl_.DepthFunc(depth_function);
  gl_.Disable(GL_BLEND);
  gl_.BindVertexArray(no_attributes_.id()); // drawing requires a vertex array
}

void GeometryBuffer::draw_triangles(ProgramCache &programs, int first, int last) {
  begin_drawing(GL_LEQUAL);
  gl_.UseProgram(programs.get(
      gl_, "layout", {{GL_VERTEX_SHADER, "paper/bake/layout.vert.glsl"}, {GL_FRAGMENT_SHADER, "paper/bake/layout.frag.glsl"}}));
  gl_.Uniform1i(LOCATION_BUFFER_SIZE, size_);
  gl_.BindTextureUnit(UNIT_CORNER_UVS, corner_uvs_.id());
  gl_.DrawArrays(GL_TRIANGLES, 3 * first, 3 * (last - first));
  check_gl(gl_, "layout");
}

void GeometryBuffer::draw_borders(ProgramCache &programs) {
  begin_drawing(GL_LESS);
  gl_.UseProgram(programs.get(
      gl_, "edge", {{GL_VERTEX_SHADER, "paper/bake/edge.vert.glsl"}, {GL_FRAGMENT_SHADER, "paper/bake/edge.frag.glsl"}}));
  gl_.Uniform1i(LOCATION_BUFFER_SIZE, size_);
  gl_.BindTextureUnit(UNIT_EDGES, drawing_->edges.id());
  gl_.DrawArrays(GL_TRIANGLES, 0, 6 * drawing_->edge_count);
  check_gl(gl_, "layout");
}

TexelCounts GeometryBuffer::end_layout(ProgramCache &programs) {
  const TexelCounts counts = count_owners(programs);
  gl_.NamedFramebufferTexture(layout_framebuffer_.id(), GL_DEPTH_ATTACHMENT, 0, 0);
  drawing_.reset();
  return counts;
}

TexelCounts GeometryBuffer::count_owners(ProgramCache &programs) const {
  const Texture owners(gl_, size_, size_, GL_R32F);
  const GlName<&Gl::DeleteFramebuffers> framebuffer(gl_, make_framebuffer(gl_, {owners.id()}));
  const float zero[4] = {0, 0, 0, 0};
  gl_.ClearNamedFramebufferfv(framebuffer.id(), GL_COLOR, 0, zero);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer.id());
  gl_.Viewport(0, 0, size_, size_);
  gl_.Disable(GL_DEPTH_TEST);
  gl_.Enable(GL_BLEND);
  gl_.BlendFunc(GL_ONE, GL_ONE);
  gl_.UseProgram(programs.get(
      gl_, "count", {{GL_VERTEX_SHADER, "paper/bake/layout.vert.glsl"}, {GL_FRAGMENT_SHADER, "paper/bake/count.frag.glsl"}}));
  gl_.BindTextureUnit(UNIT_CORNER_UVS, corner_uvs_.id());
  gl_.DrawArrays(GL_TRIANGLES, 0, 3 * triangle_count_);
  gl_.Disable(GL_BLEND);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, 0);
  std::vector<float> counts(static_cast<size_t>(size_) * static_cast<size_t>(size_));
  gl_.GetTextureImage(owners.id(), 0, GL_RED, GL_FLOAT, static_cast<GLsizei>(counts.size() * sizeof(float)), counts.data());
  check_gl(gl_, "count of owners");
  TexelCounts result;
  for (const float count : counts) {
    result.covered += count > 0.5f;
    result.overlapping += count > 1.5f;
  }
  return result;
}

// ---- A frame

void GeometryBuffer::place_corners(const BakeInput &input, const Normals &normals) {
  std::vector<vec4> places(2 * input.charts.corner_wedge.size(), vec4(0.0f));
  for (size_t corner = 0; corner < places.size() / 2; ++corner) {
    if (input.charts.corner_wedge[corner] < 0) continue;
    places[2 * corner] = vec4(input.bake_space.to_buffer(input.triangles.position(static_cast<int32_t>(corner))), 0.0f);
    places[2 * corner + 1] = vec4(normals.corner(corner), 0.0f);
  }
  vertices_.upload(gl_, GL_RGBA32F, places, GL_STREAM_DRAW);
  set_area_unit(input);
}

// Roughly the mean area element over the UV map: values above 65504 times the mean cover less than a 65504th of the map. The unit
// is a power of two, so that nothing is rounded.
void GeometryBuffer::set_area_unit(const BakeInput &input) {
  if (!half_) return;
  double space = 0.0;
  for (size_t t = 0; t < static_cast<size_t>(input.triangles.triangle_count); ++t) {
    if (input.charts.triangle_chart[t] < 0) continue;
    const auto at = [&](size_t k) { return dvec3(input.triangles.positions[input.triangles.corner_vertex[3 * t + k]]); };
    space += length(cross(at(1) - at(0), at(2) - at(0)));
  }
  space *= input.bake_space.scale * input.bake_space.scale;
  const double mean = area_in_map_ > 0.0 && space > 0.0 ? space / area_in_map_ : 1.0;
  area_unit_ = static_cast<float>(std::exp2(std::clamp(std::round(std::log2(mean)), -100.0, 100.0)));
}

// Draws one fragment for every texel of these rows.
void GeometryBuffer::draw_screen(GLuint framebuffer, int first_row, int last_row) const {
  bind_owners();
  gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  gl_.Viewport(0, 0, size_, size_);
  gl_.Disable(GL_DEPTH_TEST);
  gl_.Disable(GL_BLEND);
  gl_.Enable(GL_SCISSOR_TEST);
  gl_.Scissor(0, first_row, size_, last_row - first_row);
  gl_.BindVertexArray(no_attributes_.id());
  gl_.DrawArrays(GL_TRIANGLES, 0, 3);
  gl_.Disable(GL_SCISSOR_TEST);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, 0);
  gl_.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_FRAMEBUFFER_BARRIER_BIT);
}

void GeometryBuffer::draw_surface(ProgramCache &programs, int first_row, int last_row) {
  gl_.UseProgram(
      programs.get(gl_, std::string("surface ") + variant(),
                   {{GL_VERTEX_SHADER, "paper/bake/screen.vert.glsl"}, {GL_FRAGMENT_SHADER, "paper/bake/surface.frag.glsl"}},
                   {{"variant.glsl", variant()}}));
  gl_.Uniform1f(LOCATION_AREA_UNIT, area_unit_);
  draw_screen(surface_framebuffer_.id(), first_row, last_row);
  check_gl(gl_, "bake");
}

void GeometryBuffer::draw_map(ProgramCache &programs, const HalfEdges &half_edges, const MapValues &points) {
  if (!map_.id()) map_ = Texture(gl_, size_, size_, GL_RGBA32F);
  const GlName<&Gl::DeleteFramebuffers> framebuffer(gl_, make_framebuffer(gl_, {map_.id()}));
  std::vector<vec4> values;
  values.reserve(half_edges.corner_point.size());
  for (const int32_t point : half_edges.corner_point) values.push_back(point >= 0 ? points[point] : vec4(0.0f));
  values_.upload(gl_, GL_RGBA32F, values, GL_STREAM_DRAW);
  gl_.UseProgram(programs.get(
      gl_, "map", {{GL_VERTEX_SHADER, "paper/bake/screen.vert.glsl"}, {GL_FRAGMENT_SHADER, "paper/bake/map.frag.glsl"}}));
  gl_.BindTextureUnit(UNIT_VALUES, values_.id());
  draw_screen(framebuffer.id(), 0, size_);
  check_gl(gl_, "map");
}

// ---- Reading

void GeometryBuffer::bind() const {
  gl_.BindTextureUnit(UNIT_POSITION, position_.id());
  gl_.BindTextureUnit(UNIT_NORMAL, normal_.id());
  gl_.BindTextureUnit(UNIT_IDS, ids_.id());
}

void GeometryBuffer::bind_owners() const {
  gl_.BindTextureUnit(UNIT_IDS, ids_.id());
  gl_.BindTextureUnit(UNIT_WEIGHTS, weights_.id());
  gl_.BindTextureUnit(UNIT_CORNER_UVS, corner_uvs_.id());
  gl_.BindTextureUnit(UNIT_VERTICES, vertices_.id());
}

void GeometryBuffer::bind_to_rewrite() const {
  bind_owners();
  gl_.BindImageTexture(IMAGE_POSITION, position_.id(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  gl_.BindImageTexture(IMAGE_NORMAL, normal_.id(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
}

static std::vector<vec4> read_image(const Gl &gl, GLuint texture, int size) {
  std::vector<vec4> texels(static_cast<size_t>(size) * static_cast<size_t>(size));
  gl.GetTextureImage(texture, 0, GL_RGBA, GL_FLOAT, static_cast<GLsizei>(texels.size() * sizeof(vec4)), texels.data());
  check_gl(gl, "read-back");
  return texels;
}

std::vector<vec4> GeometryBuffer::read_distortion(ProgramCache &programs) const {
  const Texture distortion(gl_, size_, size_, GL_RGBA32F);
  gl_.UseProgram(programs.get(gl_, "distortion", {{GL_COMPUTE_SHADER, "paper/bake/distortion.comp.glsl"}}));
  bind_owners();
  gl_.BindImageTexture(IMAGE_DISTORTION, distortion.id(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  dispatch_texels(gl_, size_);
  gl_.MemoryBarrier(GL_ALL_BARRIER_BITS);
  return read_image(gl_, distortion.id(), size_);
}

std::vector<vec4> GeometryBuffer::read_position() const {
  std::vector<vec4> texels = read_image(gl_, position_.id(), size_);
  if (!half_) return texels;
  const std::vector<vec4> stored = read_image(gl_, normal_.id(), size_);
  for (size_t i = 0; i < texels.size(); ++i) {
    if (!(texels[i].w > 0.0f)) continue;
    texels[i] += vec4(half_floats::Text().three_of_code(stored[i].w), 0.0f);
    texels[i].w *= area_unit_;
  }
  return texels;
}

std::vector<vec4> GeometryBuffer::read_normal() const {
  std::vector<vec4> texels = read_image(gl_, normal_.id(), size_);
  if (!half_) return texels;
  const std::vector<int32_t> ids = read_ids();
  for (size_t i = 0; i < texels.size(); ++i) {
    if (ids[2 * i] < 0) continue;
    half_floats::Text text;
    texels[i] = vec4(text.from_octahedron(vec2(texels[i]) + text.two_of_code(texels[i].z)), 0.0f);
  }
  return texels;
}

std::vector<vec4> GeometryBuffer::read_map() const { return read_image(gl_, map_.id(), size_); }

std::vector<int32_t> GeometryBuffer::read_ids() const {
  std::vector<int32_t> texels(2 * static_cast<size_t>(size_) * static_cast<size_t>(size_));
  gl_.GetTextureImage(ids_.id(), 0, GL_RG_INTEGER, GL_INT, static_cast<GLsizei>(texels.size() * sizeof(int32_t)), texels.data());
  check_gl(gl_, "read-back");
  return texels;
}

} // namespace paradesc
