// The system's report of its memory → the bytes that this process may still use.
#pragma once

#include <cstdint>
#include <string>

namespace paradesc {

// Bytes that are free without swapping (Linux: MemAvailable), or left of a control group's limit if that is less; -1 if the
// system does not tell. root: the folder of the system's files.
int64_t free_memory(const std::string &root = "/");

// Bytes that may be taken in addition to those held: what the limit leaves, or half of the free memory if the limit is 0.
int64_t allowed_memory(int64_t limit, int64_t held);

} // namespace paradesc
