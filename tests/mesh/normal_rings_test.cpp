// The rings of fans begin in one list, which may have more than 2^31 members.
#include "mesh/normal_rings.h"

#include <gtest/gtest.h>

namespace paradesc::test {
namespace {

TEST(NormalRings, begin_where_they_should_beyond_what_32_bits_hold) {
  constexpr int64_t before = (int64_t{1} << 31) - 30;
  std::vector<int64_t> begins{before};
  append_begins({24, 24, 0, 24}, begins);
  EXPECT_EQ(begins, (std::vector<int64_t>{before, before + 24, before + 48, before + 48, before + 72}));
}

} // namespace
} // namespace paradesc::test
