// Centers in the order in which a device evaluates them, and which of them share what is near.
#include "sample/starts.h"

#include <gtest/gtest.h>

#include "support/math.h"

namespace paradesc {
namespace {

using Numbers = std::vector<int32_t>;

// Centers 0 to 4 start in the cells 2, none, 0 and 1, 2, 2 and 0.
Starts five_centers() {
  const Numbers begin = {0, 1, 1, 3, 4, 6}, cells = {2, 0, 1, 2, 2, 0};
  return list_starts(begin, cells, 3);
}

TEST(Starts, come_by_the_first_cell_of_each_center_and_those_without_a_cell_come_last) {
  EXPECT_EQ(five_centers().order, (Numbers{2, 0, 3, 4, 1}));
}

TEST(Starts, of_a_center_stay_its_own) {
  const Starts starts = five_centers();
  const std::vector<Numbers> expected = {{0, 1}, {2}, {2}, {2, 0}, {}};
  ASSERT_EQ(starts.range.size(), expected.size());
  for (size_t i = 0; i < expected.size(); ++i) {
    Numbers found;
    for (int32_t k = starts.range[i].x; k < starts.range[i].y; ++k) found.push_back(starts.cell[static_cast<size_t>(k)].x);
    EXPECT_EQ(found, expected[i]) << i;
  }
}

TEST(Starts, of_one_cell_are_a_list) {
  const Starts starts = five_centers();
  EXPECT_EQ(starts.list, (std::vector<ivec2>{{0, 1}, {1, 4}}));
  for (size_t list = 0; list < starts.list.size(); ++list)
    for (int32_t i = starts.list[list].x; i < starts.list[list].y; ++i)
      EXPECT_EQ(starts.cell[static_cast<size_t>(starts.range[static_cast<size_t>(i)].x)].y, list);
}

TEST(Starts, that_are_more_than_one_invocation_may_look_at_are_several_lists) {
  constexpr int32_t count = 10000;
  Numbers begin, cells(count, 0);
  for (int32_t i = 0; i <= count; ++i) begin.push_back(i);
  const Starts starts = list_starts(begin, cells, 1);
  ASSERT_EQ(starts.list.size(), 3u);
  EXPECT_EQ(starts.list.front().x, 0);
  EXPECT_EQ(starts.list.back().y, count);
  for (size_t i = 0; i < starts.list.size(); ++i) {
    EXPECT_LE(starts.list[i].y - starts.list[i].x, 4096);
    if (i > 0) {
      EXPECT_EQ(starts.list[i].x, starts.list[i - 1].y);
    }
  }
}

} // namespace
} // namespace paradesc
