// Backend numbers → engines. Only this file knows which engines exist.
#pragma once

#include <memory>

#include "engine/driver_substitute.h"
#include "engine/engine.h"

namespace paradesc {

// backend: any but AUTO. Opens nothing.
Abilities abilities_of(int32_t backend);

// backend: any but AUTO. Throws Error(UNSUPPORTED) that says what was found and what to do.
std::shared_ptr<Engine> open_engine(int32_t backend, int device_index, int threads, const DriverSubstitute &substitute);

// The memory that a computation on that backend takes in addition to the mesh.
MemoryForecast forecast_memory(int32_t backend, const ComputationSize &size);

} // namespace paradesc
