// Chooses the engine. texture_space_needs() is the only list of options that need texture space.
#include "compute/choice.h"

#include <vector>

#include "support/error.h"

namespace paradesc {

std::string texture_space_needs(const pdesc_options &options) {
  std::vector<std::string> needs;
  if (options.relocation == PDESC_RELOCATION_AFFINE) needs.emplace_back("the relocation affine");
  if (options.relocation == PDESC_RELOCATION_PAPER) needs.emplace_back("the relocation paper");
  if (options.precision == PDESC_PRECISION_HALF) needs.emplace_back("half floats");
  if (options.adaptive > 0.0) needs.emplace_back("adaptive sampling");
  if (options.buffers != 0) needs.emplace_back("baked buffers");
  std::string sentence;
  for (size_t i = 0; i < needs.size(); ++i) sentence += (i == 0 ? "" : i + 1 < needs.size() ? ", " : " and ") + needs[i];
  return sentence;
}

int32_t backend_for(const Context &context, const pdesc_options &options) {
  return context.automatic && !texture_space_needs(options).empty() ? PDESC_BACKEND_SOFTWARE : context.backend;
}

static std::shared_ptr<Engine> engine_for(Context &context, const pdesc_options &options) {
  if (backend_for(context, options) == context.backend) return context.engine;
  try {
    return software_of(context);
  } catch (const Error &error) {
    throw Error(PDESC_ERROR_UNSUPPORTED, "A computation with " + texture_space_needs(options) +
                                             " takes OpenGL, and there is no software device here (" + error.clause() +
                                             "); do without what was asked for, or choose the backend gpu if there is a card.");
  }
}

void take_engine(Mesh &mesh, const pdesc_options &options) {
  reopen_lost_device(*mesh.context);
  const std::shared_ptr<Engine> engine = engine_for(*mesh.context, options);
  if (mesh.session && mesh.engine == engine) return;
  mesh.session.reset();
  mesh.memory_held = 0;
  mesh.engine = engine;
  mesh.session = engine->open_session();
}

// Refuses options that need texture space.
static void refuse_without_texture_space(const pdesc_options &options) {
  const std::string needs = texture_space_needs(options);
  if (needs.empty()) return;
  throw Error(PDESC_ERROR_INVALID_OPERATION, "A computation with " + needs +
                                                 " takes texture space, which the backend cpu does without; use the backend "
                                                 "gpu, software or auto.");
}

void refuse_beyond_abilities(const Mesh &mesh, const pdesc_options &options) {
  const Abilities abilities = abilities_of(mesh.engine->backend());
  if (abilities.texture_space && mesh.triangles.corner_uv.empty())
    throw Error(PDESC_ERROR_INVALID_OPERATION,
                "The mesh has no UV map, which texture space needs; unwrap it, or use the cpu or the reference backend.");
  if (!abilities.texture_space && !abilities.any_options) refuse_without_texture_space(options);
  if (abilities.texels && options.evaluate == PDESC_EVALUATE_TEXEL && mesh.triangles.corner_uv.empty())
    throw Error(PDESC_ERROR_INVALID_OPERATION, "Texels were to be evaluated, and the mesh has no UV map in which they could lie; "
                                               "unwrap it, or evaluate at vertices, which needs none.");
  check_triangle_count(abilities, mesh.triangles.triangle_count);
}

} // namespace paradesc
