// AUTO is a graphics card where there is one that works, else the processor.
#include "context.h"

namespace paradesc {

static const char *keep(Context &context, const std::string &text) { return context.texts.emplace_back(text).c_str(); }

static void use(Context &context, int backend) {
  context.engine = open_engine(backend, context.device_index, context.threads, context.substitute);
  context.backend = backend;
  context.device = keep(context, context.engine->device());
}

// A graphics card, else the processor.
static void use_best(Context &context) {
  try {
    use(context, PDESC_BACKEND_GPU);
  } catch (const Error &error) {
    context.fallback = keep(context, error.what());
    use(context, PDESC_BACKEND_CPU);
  }
}

Resources resources_of(const Context &context) { return {context.threads, context.memory_limit, context.smallest_tile}; }

std::shared_ptr<Context> make_context(const pdesc_context_options &options, DriverSubstitute substitute) {
  auto context = std::make_shared<Context>();
  context->requested_backend = options.backend;
  context->device_index = options.device_index;
  context->threads = options.threads;
  context->memory_limit = options.memory_limit;
  context->substitute = std::move(substitute);
  if (options.backend == PDESC_BACKEND_AUTO)
    use_best(*context);
  else
    use(*context, options.backend);
  return context;
}

std::shared_ptr<Engine> engine_of(Context &context, int32_t backend) {
  if (backend == context.backend) return context.engine;
  std::shared_ptr<Engine> &engine = context.beside[backend];
  if (!engine || engine->lost()) engine = open_engine(backend, -1, context.threads, context.substitute);
  return engine;
}

void reopen_lost_device(Context &context) {
  if (!context.engine->lost()) return;
  try {
    use(context, context.backend);
  } catch (const Error &error) {
    std::string why = error.what();
    while (why.ends_with('.')) why.pop_back();
    throw Error(PDESC_ERROR_DEVICE_LOST,
                "The graphics device was lost and does not come back; use another backend (opening it said: " + why + ").");
  }
}

bool is_of_device(const Error &error) {
  return error.status() == PDESC_ERROR_UNSUPPORTED || error.status() == PDESC_ERROR_OUT_OF_MEMORY ||
         error.status() == PDESC_ERROR_DEVICE_LOST || error.status() == PDESC_ERROR_UNKNOWN;
}

bool fall_back(Context &context, const Error &error) {
  if (context.requested_backend != PDESC_BACKEND_AUTO || context.backend != PDESC_BACKEND_GPU || !is_of_device(error))
    return false;
  context.fallback = keep(context, error.what());
  use(context, PDESC_BACKEND_CPU);
  context.given_up = true;
  return true;
}

} // namespace paradesc
