// The least coarsening with few enough pieces: that which trying one after the other would find, by few counts.
#include "mesh/coarsening.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "bake/shapes.h"

namespace paradesc::test {
namespace {

struct Search {
  int steps = 0;
  int counts = 0;      // that were asked for
  int64_t counted = 0; // pieces, each count up to the limit
  Search(const std::vector<int64_t> &pieces, int64_t most) {
    int last_that_fits = -1;
    steps = fewest_steps(most, static_cast<int>(pieces.size()) - 1, [&](int asked) -> std::optional<int64_t> {
      const int64_t found = pieces[at(asked)];
      ++counts;
      counted += std::min(found, most);
      if (found > most) return std::nullopt;
      last_that_fits = asked;
      return found;
    });
    EXPECT_EQ(last_that_fits, steps) << "what is returned was counted last";
  }
};

int one_after_the_other(const std::vector<int64_t> &pieces, int64_t most) {
  return static_cast<int>(std::find_if(pieces.begin(), pieces.end(), [&](int64_t n) { return n <= most; }) - pieces.begin());
}

TEST(Coarsening, grows_by_a_quarter_a_step) {
  EXPECT_EQ(coarsening_after(0), 1.0f);
  EXPECT_EQ(coarsening_after(2), 1.5625f);
  EXPECT_EQ(steps_until_short(0.5f), 0);
  EXPECT_EQ(steps_until_short(1.0f), 0);
  EXPECT_EQ(steps_until_short(1.25f), 1);
  EXPECT_EQ(steps_until_short(1.5f), 2);
  for (const float length : {11585.0f, 1e30f, 3.4e38f}) {
    const int steps = steps_until_short(length);
    EXPECT_GE(coarsening_after(steps), length);
    EXPECT_LT(coarsening_after(steps - 1), length);
  }
}

// With nothing cut, at the guess, and one step before it, whatever the length is.
TEST(Coarsening, of_pieces_that_go_with_the_square_takes_three_counts) {
  constexpr int64_t most = 1 << 22;
  for (const float length : {8e3f, 3e4f, 1e5f, 1e8f}) {
    const int last = steps_until_short(length);
    std::vector<int64_t> pieces;
    for (int steps = 0; steps <= last; ++steps) {
      const double finer = static_cast<double>(coarsening_after(last)) / static_cast<double>(coarsening_after(steps));
      pieces.push_back(static_cast<int64_t>(12 * finer * finer));
    }
    const Search search(pieces, most);
    EXPECT_EQ(search.steps, one_after_the_other(pieces, most));
    EXPECT_EQ(search.counts, 3) << length;
    EXPECT_LE(search.counted, 2 * most + 12);
  }
}

TEST(Coarsening, of_any_pieces_that_become_fewer_is_that_which_trying_each_would_find) {
  constexpr int64_t most = 1000;
  Random random(1);
  for (int i = 0; i < 2000; ++i) {
    std::vector<int64_t> pieces(2 + at(static_cast<int>(random.uniform() * 400)));
    for (int64_t &n : pieces) n = static_cast<int64_t>(std::exp(20 * random.uniform()));
    std::sort(pieces.rbegin(), pieces.rend());
    pieces.front() = most + 1 + pieces.front();
    pieces.back() = std::min(pieces.back(), most);
    const Search search(pieces, most);
    ASSERT_EQ(search.steps, one_after_the_other(pieces, most));
    ASSERT_LE(search.counts, 3 * std::log2(static_cast<double>(pieces.size())) + 2) << "strides that grow, then halves";
  }
}

TEST(Coarsening, of_pieces_that_become_more_in_between_fits_where_one_step_less_does_not) {
  constexpr int64_t most = 1000;
  Random random(2);
  for (int i = 0; i < 500; ++i) {
    std::vector<int64_t> pieces(40);
    for (int64_t &n : pieces) n = static_cast<int64_t>(2 * most * random.uniform());
    pieces.front() = most + 1;
    pieces.back() = most;
    const int steps = Search(pieces, most).steps;
    ASSERT_LE(pieces[at(steps)], most);
    ASSERT_GT(pieces[at(steps - 1)], most);
  }
}

} // namespace
} // namespace paradesc::test
