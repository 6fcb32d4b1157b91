// The processor → the sums that are compiled for it.
#include "engine/cpu/add_samples.h"

#include <algorithm>
#include <cstdint>

#if defined(__x86_64__)
#include <cpuid.h>
#endif

namespace paradesc {

namespace kernels {
#define DECLARE_TARGET(target)                                                                                                   \
  inline namespace target {                                                                                                      \
  extern const SumTarget sums_of_##target;                                                                                       \
  }
DECLARE_TARGET(baseline)
#if defined(__x86_64__)
DECLARE_TARGET(avx2)
DECLARE_TARGET(avx512)
#endif
} // namespace kernels

#if defined(__x86_64__)
namespace {

struct Instructions {
  bool avx2 = false, avx512 = false;
};

} // namespace

// Asked of the processor itself: __builtin_cpu_supports() says no to everything where Zig links it. The system has to keep the
// wide registers, too.
static Instructions find_instructions() {
  uint32_t a = 0, b = 0, c = 0, d = 0;
  constexpr uint32_t os_keeps_registers = 1u << 27;
  if (!__get_cpuid(1, &a, &b, &c, &d) || !(c & os_keeps_registers)) return {};
  uint32_t kept = 0, high = 0;
  __asm__("xgetbv" : "=a"(kept), "=d"(high) : "c"(0));
  if (!__get_cpuid_count(7, 0, &a, &b, &c, &d)) return {};
  constexpr uint32_t avx2 = 1u << 5, avx512 = 1u << 16 | 1u << 17 | 1u << 31; // F, DQ, VL
  constexpr uint32_t halves = 0x6, whole = 0xe6;                              // registers of 256 bits, of 512 bits and masks
  return {(b & avx2) == avx2 && (kept & halves) == halves, (b & avx512) == avx512 && (kept & whole) == whole};
}
#endif

std::vector<SumTarget> sum_targets() {
  std::vector<SumTarget> targets;
#if defined(__x86_64__)
  const Instructions found = find_instructions();
  if (found.avx512) targets.push_back(kernels::sums_of_avx512);
  if (found.avx2) targets.push_back(kernels::sums_of_avx2);
#endif
  targets.push_back(kernels::sums_of_baseline);
  return targets;
}

} // namespace paradesc
