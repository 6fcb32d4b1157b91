// The tests' own operator new, which counts.
#include "support/no_memory.h"

#include <cstdlib>
#include <new>

namespace paradesc::test {

thread_local int64_t allocations_left = -1;

[[maybe_unused]] static void *allocated(std::size_t size, std::size_t alignment) {
  if (allocations_left == 0) throw std::bad_alloc();
  if (allocations_left > 0) --allocations_left;
  size = size ? size : 1;
#if defined(_WIN32)
  void *const found = alignment ? _aligned_malloc(size, alignment) : std::malloc(size);
#else
  void *const found =
      alignment ? std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment) : std::malloc(size);
#endif
  if (!found) throw std::bad_alloc();
  return found;
}

} // namespace paradesc::test

#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define PARADESC_HAS_OTHER_NEW // a second one cannot be linked, so memory never ends under ThreadSanitizer
#endif
#endif

#ifndef PARADESC_HAS_OTHER_NEW
void *operator new(std::size_t size) { return paradesc::test::allocated(size, 0); }
void *operator new[](std::size_t size) { return paradesc::test::allocated(size, 0); }
// AddressSanitizer has its own of these, whose memory free() may not return.
void *operator new(std::size_t size, const std::nothrow_t &) noexcept { return std::malloc(size ? size : 1); }
void *operator new[](std::size_t size, const std::nothrow_t &) noexcept { return std::malloc(size ? size : 1); }
void *operator new(std::size_t size, std::align_val_t alignment) {
  return paradesc::test::allocated(size, static_cast<std::size_t>(alignment));
}
void *operator new[](std::size_t size, std::align_val_t alignment) {
  return paradesc::test::allocated(size, static_cast<std::size_t>(alignment));
}
void operator delete(void *memory) noexcept { std::free(memory); }
void operator delete[](void *memory) noexcept { std::free(memory); }
void operator delete(void *memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void *memory, std::size_t) noexcept { std::free(memory); }
#if defined(_WIN32)
static void free_aligned(void *memory) noexcept { _aligned_free(memory); }
#else
static void free_aligned(void *memory) noexcept { std::free(memory); }
#endif
void operator delete(void *memory, std::align_val_t) noexcept { free_aligned(memory); }
void operator delete[](void *memory, std::align_val_t) noexcept { free_aligned(memory); }
void operator delete(void *memory, std::size_t, std::align_val_t) noexcept { free_aligned(memory); }
void operator delete[](void *memory, std::size_t, std::align_val_t) noexcept { free_aligned(memory); }
#endif
