// A process that was forked from one with a device: what computes there gives a sentence or the right values, and nothing hangs.
#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "support/api_fixture.h"
#include "support/fork.h"

#ifdef CAN_FORK
namespace paradesc::test {
namespace {

class Fork : public Api {
protected:
  // Says what is wrong with a call in the child, "" if nothing is: it has to be refused, by a sentence with a word.
  static std::string unless_refused(int32_t status, const std::string &word) {
    const std::string sentence = pdesc_last_error();
    if (status == PDESC_OK) return "it was not refused: " + word + "\n";
    return sentence.find(word) == std::string::npos ? "no \"" + word + "\" in: " + sentence + "\n" : "";
  }
  int32_t computed(pdesc_mesh *mesh) {
    const char *name = "mean_curvature";
    pdesc_field *field = nullptr;
    const int32_t status = pdesc_compute(mesh, &options, &name, 1, nullptr, nullptr, &field);
    pdesc_field_destroy(field);
    return status;
  }
};

TEST_F(Fork, with_a_device_open_refuses_it_and_computes_on_the_processor) {
  std::string why_not;
  Context device = open_context(device_backend(), why_not);
  if (!device) GTEST_SKIP() << why_not;
  Context processor = open_context(PDESC_BACKEND_CPU, why_not);
  Mesh mesh = make_mesh(device.get(), ball), on_processor = make_mesh(processor.get(), ball);
  options.buffer_size = 128;
  const std::vector<float> expected = mean_curvature(mesh.get()), of_processor = mean_curvature(on_processor.get());
  expect_right_in_a_fork([&] {
    std::string wrong;
    std::vector<float> buffer(128 * 128);
    wrong += unless_refused(pdesc_mesh_read_buffer(mesh.get(), "chart", buffer.data(), 128 * 128), "forked");
    for (int again = 0; again < 2; ++again) wrong += unless_refused(computed(mesh.get()), "forked");
    pdesc_context_options wanted;
    pdesc_context_options_init(&wanted);
    wanted.backend = device_backend();
    pdesc_context *another = nullptr;
    wrong += unless_refused(pdesc_context_create(&wanted, &another), "forked");
    const Context automatic = open_context(PDESC_BACKEND_AUTO, why_not);
    const Mesh of_child = make_mesh(automatic.get(), ball);
    if (mean_curvature(of_child.get()) != of_processor) wrong += "a new context has other values\n";
    if (mean_curvature(on_processor.get()) != of_processor) wrong += "the processor's context has other values\n";
    options.buffers = 1;
    wrong += unless_refused(computed(of_child.get()), "forked");
    mesh.reset();
    device.reset();
    on_processor.reset();
    processor.reset();
    return wrong;
  });
  expect_same_bits(mean_curvature(mesh.get()), expected);
}

TEST_F(Fork, while_another_thread_computes_refuses_its_context) {
  const Mesh mesh = make_mesh(context.get(), ball);
  struct Pause {
    std::atomic<bool> reached = false, over = false;
  } pause;
  std::thread other([&] {
    (void)mean_curvature(
        mesh.get(),
        [](void *user, const char *, double) -> int32_t {
          auto &here = *static_cast<Pause *>(user);
          here.reached = true;
          while (!here.over) std::this_thread::yield();
          return 1;
        },
        &pause);
  });
  while (!pause.reached) std::this_thread::yield();
  expect_right_in_a_fork([&] {
    const std::string wrong = unless_refused(computed(mesh.get()), "forked");
    pdesc_mesh_destroy(mesh.get());
    pdesc_context_destroy(context.get());
    return wrong;
  });
  pause.over = true;
  other.join();
}

} // namespace
} // namespace paradesc::test
#endif
