// Images and corners as textures, one dispatch over all texels.
#include "engine/paper/surface_mapper.h"

#include <string>

#include "engine/paper/dispatch.h"
#include "shared.h"
#include "support/error.h"

namespace paradesc {

template <class Pixel> static Texture upload_image(const Gl &gl, const Image<Pixel> *image, GLenum format, GLenum channels) {
  const Image<Pixel> nothing{1, 1, std::vector<Pixel>(1, Pixel(0.0f))};
  const Image<Pixel> &used = image ? *image : nothing;
  GLint limit = 0;
  gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &limit);
  if (used.width > limit || used.height > limit)
    throw Error(PDESC_ERROR_UNSUPPORTED, "The image of " + std::to_string(used.width) + " x " + std::to_string(used.height) +
                                             " pixels is too large for this device, which takes " + std::to_string(limit) +
                                             " a side; use a smaller one.");
  Texture texture(gl, used.width, used.height, format);
  gl.TextureSubImage2D(texture.id(), 0, 0, 0, used.width, used.height, channels, GL_FLOAT, used.pixels.data());
  return texture;
}

void SurfaceMapper::upload_images(const Gl &gl, const SurfaceMaps &maps) {
  if (version_ == maps.version) return;
  heights_ = upload_image(gl, maps.displacement ? &maps.displacement->heights : nullptr, GL_R32F, GL_RED);
  colors_ = upload_image(gl, maps.normal_map ? &maps.normal_map->colors : nullptr, GL_RGBA32F, GL_RGBA);
  check_gl(gl, "upload of maps");
  version_ = maps.version;
}

void SurfaceMapper::upload_corners(const Gl &gl, const BakeInput &input, const Normals &normals, const SurfaceMaps &maps) {
  input_uvs_.upload(gl, GL_RG32F, input.triangles.input_uv, GL_STREAM_DRAW);
  std::vector<vec4> tangents;
  if (maps.normal_map) {
    const std::vector<vec4> &own = maps.normal_map->corner_tangent;
    tangents.reserve(2 * own.size());
    for (size_t corner = 0; corner < own.size(); ++corner) {
      tangents.push_back(own[corner]);
      tangents.emplace_back(frame_normal(input.triangles, normals, corner), 0.0f);
    }
  }
  tangents_.upload(gl, GL_RGBA32F, tangents, GL_STREAM_DRAW);
}

// A program for each choice instead of uniforms: zink of Mesa 25 compiles uniforms into programs, and kept an outdated value.
static GLuint displace_program(const Gl &gl, ProgramCache &programs, bool displaced, bool normal_mapped) {
  const std::string text = define("DISPLACED", displaced) + define("NORMAL_MAPPED", normal_mapped);
  return programs.get(gl, "displace " + text, {{GL_COMPUTE_SHADER, "paper/bake/displace.comp.glsl"}}, {{"variant.glsl", text}});
}

void SurfaceMapper::run(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer, const BakeInput &input,
                        const Normals &normals, const SurfaceMaps &maps) {
  upload_images(gl, maps);
  upload_corners(gl, input, normals, maps);
  gl.UseProgram(displace_program(gl, programs, maps.displacement.has_value(), maps.normal_map.has_value()));
  buffer.bind_to_rewrite();
  gl.BindTextureUnit(UNIT_HEIGHTS, heights_.id());
  gl.BindTextureUnit(UNIT_COLORS, colors_.id());
  gl.BindTextureUnit(UNIT_INPUT_UV, input_uvs_.id());
  gl.BindTextureUnit(UNIT_TANGENTS, tangents_.id());
  gl.Uniform1i(LOCATION_BUFFER_SIZE, buffer.size());
  gl.Uniform1f(LOCATION_MIDLEVEL, maps.displacement ? maps.displacement->midlevel : 0.0f);
  gl.Uniform1f(LOCATION_HEIGHT_SCALE,
               maps.displacement ? maps.displacement->scale * static_cast<float>(input.bake_space.scale) : 0.0f);
  dispatch_texels(gl, buffer.size());
  gl.MemoryBarrier(GL_ALL_BARRIER_BITS);
  check_gl(gl, "displacement");
}

} // namespace paradesc
