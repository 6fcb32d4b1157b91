// Memory that ends: this thread gets so many allocations more, and then none.
#pragma once

#include <cstdint>

namespace paradesc::test {

extern thread_local int64_t allocations_left; // below 0: as many as there are

class WithoutMemory {
public:
  explicit WithoutMemory(int64_t after) { allocations_left = after; }
  ~WithoutMemory() { allocations_left = -1; }
  WithoutMemory(const WithoutMemory &) = delete;
  WithoutMemory &operator=(const WithoutMemory &) = delete;
};

} // namespace paradesc::test
