// Blocks of counts up to the largest that there is.
#include "support/parallel.h"

#include <algorithm>
#include <limits>
#include <mutex>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace paradesc::test {
namespace {

constexpr int largest = std::numeric_limits<int>::max();

TEST(ParallelBlocks, cover_counts_up_to_the_largest_without_a_gap) {
  for (const int count : {0, 1, 7, 1 << 20, largest - 4096, largest - 1, largest})
    for (const int block : {1 << 20, (1 << 30) - 1, 1 << 30, largest}) {
      std::mutex mutex;
      std::vector<std::pair<int, int>> visited;
      parallel_blocks(count, 3, block, [&](int begin, int end) {
        const std::lock_guard lock(mutex);
        visited.emplace_back(begin, end);
      });
      std::ranges::sort(visited);
      int end = 0;
      for (const auto &[first, last] : visited) {
        ASSERT_EQ(first, end) << count << " in blocks of " << block;
        ASSERT_GT(last, first);
        end = last;
      }
      ASSERT_EQ(end, count) << "in blocks of " << block;
      ASSERT_EQ(static_cast<int>(visited.size()), (Blocks{count, block}.number()));
    }
}

TEST(Blocks, of_the_largest_count_are_as_many_as_it_takes) {
  EXPECT_EQ((Blocks{largest, 1}.number()), largest);
  EXPECT_EQ((Blocks{largest, 8192}.number()), 262144);
  EXPECT_EQ((Blocks{largest, 8192}.begin(262143)), largest - 8191);
  EXPECT_EQ((Blocks{largest, 8192}.end(262143)), largest);
}

} // namespace
} // namespace paradesc::test
