// Which OpenGL device tests mean: the software rasterizer, or the graphics card where PARADESC_TEST_GPU is set (drivers.py card).
#pragma once

#include <cstdint>
#include <cstdlib>

#include "paradesc/paradesc.h"

namespace paradesc::test {

inline bool on_card() { return std::getenv("PARADESC_TEST_GPU") != nullptr; }

inline int32_t device_backend() { return on_card() ? PDESC_BACKEND_GPU : PDESC_BACKEND_SOFTWARE; }

} // namespace paradesc::test
