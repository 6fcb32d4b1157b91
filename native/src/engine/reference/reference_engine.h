// The reference as an engine: exact, slow, in object space, on any machine.
#pragma once

#include "engine/engine.h"

namespace paradesc {

std::shared_ptr<Engine> open_reference_engine(int threads);

MemoryForecast forecast_reference_memory(const ComputationSize &size);

} // namespace paradesc
