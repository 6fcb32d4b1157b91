// The engines' own functions, by backend.
#include "engine/engines.h"

#include "engine/cpu/cpu_engine.h"
#include "engine/paper/paper_engine.h"
#include "engine/reference/reference_engine.h"

namespace paradesc {

Abilities abilities_of(int32_t backend) {
  if (backend == PDESC_BACKEND_REFERENCE) return {.any_options = true};
  if (backend == PDESC_BACKEND_CPU) return {.texels = true};
  // Shaders store chart numbers in floats, which are exact up to 2^24, and there may be as many charts as triangles.
  return {.texture_space = true, .surface_maps = true, .texels = true, .prepared = 0.3, .max_triangles = 1 << 24};
}

std::shared_ptr<Engine> open_engine(int32_t backend, int device_index, int threads, const DriverSubstitute &substitute) {
  if (backend == PDESC_BACKEND_REFERENCE) return open_reference_engine(threads);
  if (backend == PDESC_BACKEND_CPU) return open_cpu_engine(threads);
  return open_paper_engine(backend == PDESC_BACKEND_SOFTWARE, device_index, substitute);
}

MemoryForecast forecast_memory(int32_t backend, const ComputationSize &size) {
  if (backend == PDESC_BACKEND_REFERENCE) return forecast_reference_memory(size);
  if (backend == PDESC_BACKEND_CPU) return forecast_cpu_memory(size);
  return forecast_paper_memory(backend == PDESC_BACKEND_SOFTWARE, size);
}

} // namespace paradesc
