// The engine for every machine. It uses all cores and a tree of surface clusters, and needs neither a UV map nor a GPU.
#pragma once

#include "engine/engine.h"

namespace paradesc {

std::shared_ptr<Engine> open_cpu_engine(int threads);

MemoryForecast forecast_cpu_memory(const ComputationSize &size);

} // namespace paradesc
