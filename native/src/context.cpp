// AUTO computes on the processor, and on a software device for options that need texture space.
#include "context.h"

#include "support/error.h"

namespace paradesc {

static void use(Context &context, int32_t backend) {
  context.engine = open_engine(backend, context.device_index, context.threads, context.substitute);
  context.device = context.devices.emplace_back(context.engine->device()).c_str();
}

Resources resources_of(const Context &context) {
  return {context.threads, context.memory_limit, context.smallest_tile, context.tile_seconds};
}

std::shared_ptr<Context> make_context(const pdesc_context_options &options, DriverSubstitute substitute) {
  auto context = std::make_shared<Context>();
  context->automatic = options.backend == PDESC_BACKEND_AUTO;
  context->backend = context->automatic ? PDESC_BACKEND_CPU : options.backend;
  context->device_index = options.device_index;
  context->threads = options.threads;
  context->memory_limit = options.memory_limit;
  context->substitute = std::move(substitute);
  use(*context, context->backend);
  return context;
}

std::shared_ptr<Engine> software_of(Context &context) {
  if (!context.software || context.software->lost())
    context.software = open_engine(PDESC_BACKEND_SOFTWARE, -1, context.threads, context.substitute);
  return context.software;
}

void reopen_lost_device(Context &context) {
  if (!context.engine->lost()) return;
  try {
    use(context, context.backend);
  } catch (const Error &error) {
    throw Error(PDESC_ERROR_DEVICE_LOST,
                "The graphics device was lost and does not come back; use another backend (opening it said: " + error.clause() +
                    ").");
  }
}

} // namespace paradesc
