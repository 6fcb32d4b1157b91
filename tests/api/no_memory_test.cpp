// Memory that ends anywhere in a call: a code and a sentence, and what was there stays usable.
#include <string>
#include <vector>

#include "api_edge.h"
#include "support/api_fixture.h"
#include "support/no_memory.h"

namespace paradesc::test {
namespace {

class NoMemory : public Api {
protected:
  // This thread computes alone: the others have memory.
  static pdesc_context_options alone(int32_t backend) {
    pdesc_context_options wanted;
    pdesc_context_options_init(&wanted);
    wanted.backend = backend;
    wanted.threads = 1;
    return wanted;
  }

  // Calls with ever more allocations until one succeeds; how many calls failed.
  template <class Call> static int failures_of(const Call &call, int step) {
    for (int failed = 0;; ++failed) {
      int32_t status;
      {
        const WithoutMemory none(int64_t{failed} * step);
        status = call();
      }
      if (status == PDESC_OK) return failed;
      EXPECT_EQ(status, PDESC_ERROR_OUT_OF_MEMORY) << pdesc_last_error();
      expect_one_sentence(pdesc_last_error(), "Out of memory");
      if (::testing::Test::HasFailure()) return failed;
    }
  }
};

TEST_F(NoMemory, in_a_context_or_a_mesh_is_said_and_makes_none) {
  const pdesc_context_options wanted = alone(PDESC_BACKEND_AUTO);
  pdesc_context *made = nullptr;
  EXPECT_GT(failures_of([&] { return pdesc_context_create(&wanted, &made); }, 1), 0);
  const Context own(made);
  pdesc_mesh *mesh = nullptr;
  EXPECT_GT(failures_of([&] { return pdesc_mesh_create(own.get(), &input, &mesh); }, 1), 10);
  const Mesh owner(mesh);
}

TEST_F(NoMemory, in_a_computation_is_said_and_the_next_one_is_right) {
  for (const int32_t backend : {PDESC_BACKEND_CPU, PDESC_BACKEND_REFERENCE}) {
    const pdesc_context_options wanted = alone(backend);
    pdesc_context *made = nullptr;
    ASSERT_EQ(pdesc_context_create(&wanted, &made), PDESC_OK) << pdesc_last_error();
    const Context own(made);
    const Mesh mesh = make_mesh(own.get(), ball), other = make_mesh(own.get(), ball);
    const std::vector<float> expected = mean_curvature(other.get());
    const char *name = "mean_curvature";
    pdesc_field *field = nullptr;
    EXPECT_GT(failures_of([&] { return pdesc_compute(mesh.get(), &options, &name, 1, nullptr, nullptr, &field); }, 7), 10);
    const Field owner(field);
    std::vector<float> values(static_cast<size_t>(ball.vertex_count), sentinel);
    ASSERT_EQ(pdesc_field_values(field, name, values.data(), ball.vertex_count), PDESC_OK);
    expect_same_bits(values, expected);
  }
}

TEST_F(NoMemory, leaves_room_for_the_sentence_of_any_refusal) {
  const WithoutMemory none(0);
  EXPECT_NE(pdesc_mesh_create(nullptr, nullptr, nullptr), PDESC_OK);
  EXPECT_GT(std::string_view(pdesc_last_error()).size(), 0u);
}

TEST(LastError, is_cut_where_there_is_no_more_room_and_not_within_a_character) {
  edge::LastError error;
  for (size_t before = 4090; before <= 4096; ++before) {
    const std::string long_one = std::string(before, 'x') + "\xE2\x82\xAC\xE2\x82\xAC"; // two signs of the euro, three bytes each
    error.set({"a", long_one.c_str(), "b"});
    const std::string found = error.text();
    EXPECT_LT(found.size(), 4096u);
    EXPECT_GE(found.size(), std::min<size_t>(before + 1, 4095) - 2);
    const size_t whole = found.find_first_of('\xE2');
    if (whole != std::string::npos) {
      EXPECT_EQ((found.size() - whole) % 3, 0u) << before;
    }
  }
  error.set({"one, ", "two"});
  EXPECT_STREQ(error.text(), "one, two");
}

} // namespace
} // namespace paradesc::test
