// OpenGL 4.5 as an engine: texture space on a graphics card or a software device. This header includes none of OpenGL's.
#pragma once

#include "engine/driver_substitute.h"
#include "engine/engine.h"

namespace paradesc {

// software: a software rasterizer, else a hardware device. device_index: among the devices of that kind; -1: the first that
// works. Throws Error(UNSUPPORTED) that says what was found and what to do.
std::shared_ptr<Engine> open_paper_engine(bool software, int device_index, const DriverSubstitute &substitute);

MemoryForecast forecast_paper_memory(bool software, const ComputationSize &size);

} // namespace paradesc
