// What the system says → the bytes that this process may still take.
#pragma once

#include <cstdint>
#include <string>

namespace paradesc {

// What is free without swapping (Linux: MemAvailable), or left of a control group's limit where that is less; -1 where the
// system does not say. root: where the system's files lie.
int64_t free_memory(const std::string &root = "/");

} // namespace paradesc
