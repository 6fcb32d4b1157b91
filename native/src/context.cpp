// Backends in the order of AUTO, each tried where the one before has failed.
#include "context.h"

#include "support/parallel.h"

namespace paradesc {

static const char *keep(Context &context, const std::string &text) { return context.texts.emplace_back(text).c_str(); }

static void use_device(Context &context, int backend) {
  context.gl = std::make_shared<GlThread>(backend == PDESC_BACKEND_SOFTWARE, context.device_index, context.substitute);
  context.backend = backend;
  context.device = keep(context, context.gl->device());
}

static void use_reference(Context &context) {
  context.gl.reset();
  context.backend = PDESC_BACKEND_REFERENCE;
  context.device = keep(context, "CPU, " + std::to_string(thread_count(context.threads)) + " threads (object-space reference)");
}

// The first of the backends from this one on that works.
static void use_first(Context &context, int backend) {
  for (; backend <= PDESC_BACKEND_SOFTWARE; ++backend) {
    try {
      return use_device(context, backend);
    } catch (const Error &error) {
      context.fallback = keep(context, error.what());
    }
  }
  use_reference(context);
}

std::shared_ptr<Context> make_context(const pdesc_context_options &options, DriverSubstitute substitute) {
  auto context = std::make_shared<Context>();
  context->asked = options.backend;
  context->device_index = options.device_index;
  context->threads = options.threads;
  context->memory_limit = options.memory_limit;
  context->substitute = std::move(substitute);
  if (options.backend == PDESC_BACKEND_AUTO)
    use_first(*context, PDESC_BACKEND_GPU);
  else if (options.backend == PDESC_BACKEND_REFERENCE)
    use_reference(*context);
  else
    use_device(*context, options.backend);
  return context;
}

void reopen_lost_device(Context &context) {
  if (!context.gl || !context.gl->lost()) return;
  try {
    use_device(context, context.backend);
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
  if (context.asked != PDESC_BACKEND_AUTO || !context.gl || !is_of_device(error)) return false;
  const char *why = keep(context, error.what());
  use_first(context, context.backend + 1);
  context.fallback = why;
  context.given_up = true;
  return true;
}

} // namespace paradesc
