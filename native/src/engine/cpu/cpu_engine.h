// The engine for every machine: surface samples in a tree of clusters, on all cores, without a UV map or a device.
#pragma once

#include "engine/engine.h"

namespace paradesc {

std::shared_ptr<Engine> open_cpu_engine(int threads);

MemoryForecast forecast_cpu_memory(const ComputationSize &size);

} // namespace paradesc
