// Queries the processor directly: __builtin_cpu_supports() always returns false when Zig links it.
#include "support/instructions.h"

#include <cstdint>

#if defined(__x86_64__)
#include <cpuid.h>
#endif

namespace paradesc {

#if defined(__x86_64__)
// Checks the system, too: it must save the wide registers.
static Instructions find_instructions() {
  uint32_t a = 0, b = 0, c = 0, d = 0;
  constexpr uint32_t os_keeps_registers = 1u << 27;
  if (!__get_cpuid(1, &a, &b, &c, &d) || !(c & os_keeps_registers)) return Instructions::baseline;
  uint32_t kept = 0, high = 0;
  __asm__("xgetbv" : "=a"(kept), "=d"(high) : "c"(0));
  if (!__get_cpuid_count(7, 0, &a, &b, &c, &d)) return Instructions::baseline;
  constexpr uint32_t avx2 = 1u << 5, avx512 = 1u << 16 | 1u << 17 | 1u << 31; // F, DQ, VL
  constexpr uint32_t halves = 0x6, whole = 0xe6;                              // registers of 256 bits, of 512 bits and masks
  if ((b & avx512) == avx512 && (kept & whole) == whole) return Instructions::avx512;
  return (b & avx2) == avx2 && (kept & halves) == halves ? Instructions::avx2 : Instructions::baseline;
}
#else
static Instructions find_instructions() { return Instructions::baseline; }
#endif

Instructions widest_instructions() {
  static const Instructions found = find_instructions(); // kept, because virtual machines answer slowly
  return found;
}

} // namespace paradesc
