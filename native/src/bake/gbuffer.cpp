// Triangles and chart edges → float textures of surface points, one a texel.
#include "bake/gbuffer.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "bake/seam_links.h"
#include "shared.h"
#include "support/error.h"
#include "support/parallel.h"

namespace paradesc {

BakeVertices build_bake_vertices(const Triangles &triangles, const Charts &charts, const std::vector<int32_t> &corner_group) {
  struct Key {
    int32_t group, corner;
    auto operator<=>(const Key &) const = default;
  };
  // Corners by site, those of one site by group.
  std::vector<int32_t> begin(charts.sites.size() + 2, 0);
  for (const int32_t site : charts.corner_site)
    if (site >= 0) ++begin[static_cast<size_t>(site) + 2];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<Key> keys(static_cast<size_t>(begin.back()));
  for (int32_t corner = 0; corner < 3 * triangles.triangle_count; ++corner) {
    const int32_t site = charts.corner_site[static_cast<size_t>(corner)];
    if (site < 0) continue;
    const int32_t group = corner_group.empty() ? corner : corner_group[static_cast<size_t>(corner)];
    keys[static_cast<size_t>(begin[static_cast<size_t>(site) + 1]++)] = {group, corner};
  }
  BakeVertices vertices;
  vertices.index.assign(static_cast<size_t>(3 * triangles.triangle_count), 0);
  for (size_t site = 0; site < charts.sites.size(); ++site) {
    const auto first = static_cast<size_t>(begin[site]), last = static_cast<size_t>(begin[site + 1]);
    std::sort(keys.begin() + static_cast<ptrdiff_t>(first), keys.begin() + static_cast<ptrdiff_t>(last));
    for (size_t i = first; i < last; ++i) {
      if (i == first || keys[i].group != keys[i - 1].group) vertices.corner.push_back(keys[i].corner);
      vertices.index[static_cast<size_t>(keys[i].corner)] = static_cast<uint32_t>(vertices.corner.size() - 1);
    }
  }
  return vertices;
}

GeometryBuffer::GeometryBuffer(const Gl &gl, int size, bool half)
    : gl_(gl), size_(size), half_(half), position_(gl, size, size, half ? GL_RGBA16F : GL_RGBA32F),
      normal_(gl, size, size, half ? GL_RGBA16F : GL_RGBA32F), ids_(gl, size, size, GL_RG32I),
      depth_(gl, size, size, GL_DEPTH_COMPONENT32F) {
  gl.CreateFramebuffers(1, &framebuffer_);
  gl.CreateVertexArrays(1, &vertex_array_);
  const GLuint colors[] = {position_.id(), normal_.id(), ids_.id()};
  const GLenum targets[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1, GL_COLOR_ATTACHMENT2};
  for (unsigned i = 0; i < 3; ++i) gl.NamedFramebufferTexture(framebuffer_, targets[i], colors[i], 0);
  gl.NamedFramebufferTexture(framebuffer_, GL_DEPTH_ATTACHMENT, depth_.id(), 0);
  gl.NamedFramebufferDrawBuffers(framebuffer_, 3, targets);
  check_gl(gl, "buffers");
  if (gl.CheckNamedFramebufferStatus(framebuffer_, GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    throw Error(PDESC_ERROR_UNSUPPORTED, "This device cannot draw into float buffers of " + std::to_string(size) + " x " +
                                             std::to_string(size) + " texels; use smaller buffers or the reference backend.");
  struct Attribute {
    GLint components;
    GLuint offset, binding;
  };
  const Attribute attributes[] = {{3, 0, 0}, {3, 12, 0}, {2, 0, 1}, {1, 8, 1}};
  for (GLuint i = 0; i < 4; ++i) {
    gl.EnableVertexArrayAttrib(vertex_array_, i);
    if (i == 3)
      gl.VertexArrayAttribIFormat(vertex_array_, i, 1, GL_INT, attributes[i].offset);
    else
      gl.VertexArrayAttribFormat(vertex_array_, i, attributes[i].components, GL_FLOAT, GL_FALSE, attributes[i].offset);
    gl.VertexArrayAttribBinding(vertex_array_, i, attributes[i].binding);
  }
}

GeometryBuffer::~GeometryBuffer() {
  gl_.DeleteFramebuffers(1, &framebuffer_);
  gl_.DeleteVertexArrays(1, &vertex_array_);
}

static std::vector<EdgeData> edge_data(const BakeInput &input) {
  std::vector<EdgeData> edges;
  edges.reserve(input.charts.borders.size());
  for (const Border &border : input.charts.borders) {
    const auto [first, second] = border_ends(input.triangles, border);
    auto position = [&](int corner) {
      return input.frame.to_buffer(
          input.triangles.positions[static_cast<size_t>(input.triangles.corner_vertex[static_cast<size_t>(corner)])]);
    };
    const auto a = static_cast<size_t>(first), b = static_cast<size_t>(second);
    edges.push_back({vec4(input.triangles.corner_uv[a], input.triangles.corner_uv[b]),
                     vec4(position(first), static_cast<float>(border.chart)),
                     vec4(position(second), static_cast<float>(border.half_edge / 3)), vec4(input.normals.corner[a], 0.0f),
                     vec4(input.normals.corner[b], 0.0f)});
  }
  return edges;
}

void GeometryBuffer::upload_topology(const BakeInput &input) {
  struct Fixed {
    vec2 uv;
    int32_t chart;
  };
  std::vector<Fixed> fixed;
  fixed.reserve(input.vertices.corner.size());
  for (const int32_t corner : input.vertices.corner)
    fixed.push_back(
        {input.triangles.corner_uv[static_cast<size_t>(corner)], input.charts.triangle_chart[static_cast<size_t>(corner / 3)]});
  uv_chart_.upload(gl_, fixed);
  index_.upload(gl_, input.vertices.index);
  index_count_ = input.vertices.corner.empty() ? 0 : static_cast<GLsizei>(input.vertices.index.size());
  gl_.VertexArrayVertexBuffer(vertex_array_, 1, uv_chart_.id(), 0, sizeof(Fixed));
  gl_.VertexArrayElementBuffer(vertex_array_, index_.id());
  check_gl(gl_, "upload");
}

void GeometryBuffer::upload(const BakeInput &input) {
  struct Moving {
    vec3 position, normal;
  };
  std::vector<Moving> moving(input.vertices.corner.size());
  parallel_blocks(static_cast<int>(moving.size()), input.threads, 8192, [&](int begin, int end) {
    for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
      const auto c = static_cast<size_t>(input.vertices.corner[i]);
      moving[i] = {input.frame.to_buffer(input.triangles.positions[static_cast<size_t>(input.triangles.corner_vertex[c])]),
                   input.normals.corner[c]};
    }
  });
  position_normal_.upload(gl_, moving, GL_STREAM_DRAW);
  gl_.VertexArrayVertexBuffer(vertex_array_, 0, position_normal_.id(), 0, sizeof(Moving));
  forms_.upload(gl_, GL_RGBA32F, input.forms.data(), input.forms.size());
  const std::vector<EdgeData> edges = edge_data(input);
  edges_.upload(gl_, edges, GL_STREAM_DRAW);
  edge_count_ = static_cast<GLsizei>(edges.size());
  set_area_unit(input);
  check_gl(gl_, "upload");
}

double GeometryBuffer::megabytes() const {
  constexpr int ids = 8, depth = 4;
  const int floats = 2 * 4 * (half_ ? 2 : 4); // position and normal
  return 1e-6 * (floats + ids + depth) * size_ * size_;
}

// About the mean of the area element over the UV map: what exceeds 65504 times the mean has less than a 65504th of the map. A
// power of two, so that nothing is rounded.
void GeometryBuffer::set_area_unit(const BakeInput &input) {
  if (!half_) return;
  double space = 0.0, map = 0.0;
  for (size_t t = 0; t < input.forms.size(); ++t) {
    const vec2 *uv = &input.triangles.corner_uv[3 * t];
    const double area = std::abs(cross(dvec2(uv[1]) - dvec2(uv[0]), dvec2(uv[2]) - dvec2(uv[0])));
    if (!(input.forms[t].w > 0.0f)) continue;
    space += area * static_cast<double>(input.forms[t].w);
    map += area;
  }
  const double mean = map > 0.0 && space > 0.0 ? space / map : 1.0;
  area_unit_ = static_cast<float>(std::exp2(std::clamp(std::round(std::log2(mean)), -100.0, 100.0)));
}

void GeometryBuffer::use(GLuint program) const {
  gl_.UseProgram(program);
  gl_.Uniform1f(LOCATION_AREA_UNIT, area_unit_);
  gl_.Uniform1i(LOCATION_HALF_FLOATS, half_);
}

void GeometryBuffer::draw_triangles(int first, int last) const {
  gl_.BindTextureUnit(UNIT_TRIANGLES, forms_.id());
  gl_.BindVertexArray(vertex_array_);
  const auto offset = 3 * static_cast<uintptr_t>(first) * sizeof(GLuint); // into the buffer of indices
  gl_.DrawElements(GL_TRIANGLES, 3 * (last - first), GL_UNSIGNED_INT, reinterpret_cast<const void *>(offset));
}

void GeometryBuffer::bake(ProgramCache &programs, const BakeInput &input, bool topology_changed) {
  if (topology_changed) upload_topology(input);
  upload(input);
  clear();
  draw(programs, 0, triangle_count());
  draw_borders(programs);
}

void GeometryBuffer::clear() {
  const float zero[4] = {0, 0, 0, 0}, far_depth = 1.0f;
  const GLint none[4] = {-1, -1, 0, 0};
  gl_.ClearNamedFramebufferfv(framebuffer_, GL_COLOR, 0, zero);
  gl_.ClearNamedFramebufferfv(framebuffer_, GL_COLOR, 1, zero);
  gl_.ClearNamedFramebufferiv(framebuffer_, GL_COLOR, 2, none);
  gl_.ClearNamedFramebufferfv(framebuffer_, GL_DEPTH, 0, &far_depth);
}

void GeometryBuffer::begin_drawing() const {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  gl_.BindVertexArray(vertex_array_); // nothing is drawn without one, not even what has no vertex of its own
  gl_.Viewport(0, 0, size_, size_);
  gl_.Enable(GL_DEPTH_TEST);
  gl_.DepthMask(GL_TRUE);
  gl_.Disable(GL_BLEND);
}

void GeometryBuffer::draw(ProgramCache &programs, int first_triangle, int last_triangle) {
  begin_drawing();
  gl_.DepthFunc(GL_LEQUAL);
  use(programs.get(gl_, "bake", {{GL_VERTEX_SHADER, "bake.vert.glsl"}, {GL_FRAGMENT_SHADER, "bake.frag.glsl"}}));
  gl_.Uniform1i(LOCATION_FIRST_TRIANGLE, first_triangle);
  draw_triangles(first_triangle, last_triangle);
  check_gl(gl_, "bake");
}

void GeometryBuffer::draw_borders(ProgramCache &programs) {
  begin_drawing();
  gl_.DepthFunc(GL_LESS);
  use(programs.get(gl_, "edge", {{GL_VERTEX_SHADER, "edge.vert.glsl"}, {GL_FRAGMENT_SHADER, "edge.frag.glsl"}}));
  gl_.Uniform1i(0, size_);
  gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_EDGES, edges_.id());
  gl_.DrawArrays(GL_TRIANGLES, 0, 6 * edge_count_);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, 0);
  gl_.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_FRAMEBUFFER_BARRIER_BIT);
  check_gl(gl_, "bake");
}

TexelCounts GeometryBuffer::count_owners(ProgramCache &programs) {
  const Texture owners(gl_, size_, size_, GL_R32F);
  GLuint framebuffer = 0;
  gl_.CreateFramebuffers(1, &framebuffer);
  gl_.NamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT0, owners.id(), 0);
  const float zero[4] = {0, 0, 0, 0};
  gl_.ClearNamedFramebufferfv(framebuffer, GL_COLOR, 0, zero);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  gl_.Viewport(0, 0, size_, size_);
  gl_.Disable(GL_DEPTH_TEST);
  gl_.Enable(GL_BLEND);
  gl_.BlendFunc(GL_ONE, GL_ONE);
  gl_.UseProgram(programs.get(gl_, "count", {{GL_VERTEX_SHADER, "bake.vert.glsl"}, {GL_FRAGMENT_SHADER, "count.frag.glsl"}}));
  draw_triangles(0, triangle_count());
  gl_.Disable(GL_BLEND);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, 0);
  gl_.DeleteFramebuffers(1, &framebuffer);
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

void GeometryBuffer::bind() const {
  gl_.BindTextureUnit(UNIT_TRIANGLES, forms_.id());
  gl_.BindTextureUnit(UNIT_POSITION, position_.id());
  gl_.BindTextureUnit(UNIT_NORMAL, normal_.id());
  gl_.BindTextureUnit(UNIT_IDS, ids_.id());
}

void GeometryBuffer::bind_to_rewrite() const {
  bind();
  gl_.BindImageTexture(0, position_.id(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  gl_.BindImageTexture(1, normal_.id(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
}

static std::vector<vec4> read_image(const Gl &gl, GLuint texture, int size) {
  std::vector<vec4> texels(static_cast<size_t>(size) * static_cast<size_t>(size));
  gl.GetTextureImage(texture, 0, GL_RGBA, GL_FLOAT, static_cast<GLsizei>(texels.size() * sizeof(vec4)), texels.data());
  check_gl(gl, "read-back");
  return texels;
}

std::vector<vec4> GeometryBuffer::read_distortion(ProgramCache &programs) const {
  const Texture distortion(gl_, size_, size_, GL_RGBA32F);
  gl_.UseProgram(programs.get(gl_, "distortion", {{GL_COMPUTE_SHADER, "distortion.comp.glsl"}}));
  gl_.BindTextureUnit(UNIT_TRIANGLES, forms_.id());
  gl_.BindTextureUnit(UNIT_IDS, ids_.id());
  gl_.BindImageTexture(0, distortion.id(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  const auto groups = static_cast<GLuint>((size_ + 7) / 8);
  gl_.DispatchCompute(groups, groups, 1);
  gl_.MemoryBarrier(GL_ALL_BARRIER_BITS);
  return read_image(gl_, distortion.id(), size_);
}

// As in half.glsl: what rounding took from a number, by one of `count` steps.
static float rest_of(int step, int count) {
  return ((static_cast<float>(step) + 0.5f) * 2.0f / static_cast<float>(count) - 1.0f) / 4096.0f;
}

static vec3 from_octahedron(vec2 place) {
  const float z = 1.0f - std::abs(place.x) - std::abs(place.y);
  if (z < 0.0f) place = vec2(std::copysign(1.0f - std::abs(place.y), place.x), std::copysign(1.0f - std::abs(place.x), place.y));
  return normalize(vec3(place, z));
}

std::vector<vec4> GeometryBuffer::read_position() const {
  std::vector<vec4> texels = read_image(gl_, position_.id(), size_);
  if (!half_) return texels;
  const std::vector<vec4> stored = read_image(gl_, normal_.id(), size_);
  for (size_t i = 0; i < texels.size(); ++i) {
    if (!(texels[i].w > 0.0f)) continue;
    const int code = static_cast<int>(stored[i].w) + 2048;
    texels[i] += vec4(rest_of(code & 15, 16), rest_of(code >> 4 & 15, 16), rest_of(code >> 8, 16), 0.0f);
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
    const int code = static_cast<int>(texels[i].z) + 2048;
    texels[i] = vec4(from_octahedron(vec2(texels[i]) + vec2(rest_of(code & 63, 64), rest_of(code >> 6, 64))), 0.0f);
  }
  return texels;
}

std::vector<int32_t> GeometryBuffer::read_ids() const {
  std::vector<int32_t> texels(2 * static_cast<size_t>(size_) * static_cast<size_t>(size_));
  gl_.GetTextureImage(ids_.id(), 0, GL_RG_INTEGER, GL_INT, static_cast<GLsizei>(texels.size() * sizeof(int32_t)), texels.data());
  check_gl(gl_, "read-back");
  return texels;
}

} // namespace paradesc
