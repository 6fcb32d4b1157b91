// Handles that a caller should not use any more, or not here, are refused with a sentence, as far as a C interface can know.
#include <cstddef>
#include <string>
#include <vector>

#include "support/api_fixture.h"

namespace paradesc::test {
namespace {

TEST_F(Api, a_destroyed_mesh_is_refused_by_every_call) {
  pdesc_mesh *mesh = nullptr;
  ASSERT_EQ(pdesc_mesh_create(context.get(), &input, &mesh), PDESC_OK) << pdesc_last_error();
  pdesc_mesh_destroy(mesh);
  pdesc_mesh_report report;
  pdesc_mesh_report_init(&report);
  std::vector<float> numbers(3 * static_cast<size_t>(ball.corner_vertices.size()));
  std::vector<uint8_t> near(static_cast<size_t>(ball.vertex_count));
  const char *name = "mean_curvature";
  pdesc_field *field = never_field();
  const auto refused = [](int32_t status) { expect_refused(status, PDESC_ERROR_INVALID_ARGUMENT, {"mesh", "destroyed"}); };
  refused(pdesc_mesh_get_report(mesh, &report));
  refused(pdesc_mesh_set_positions(mesh, ball.positions.data(), ball.vertex_count));
  refused(pdesc_mesh_set_displacement(mesh, nullptr, 0, 0, 0, 1));
  refused(pdesc_mesh_set_normal_map(mesh, nullptr, 0, 0, nullptr, 0));
  refused(pdesc_compute(mesh, &options, &name, 1, nullptr, nullptr, &field));
  refused(pdesc_mesh_read_buffer(mesh, "position", numbers.data(), 3));
  refused(pdesc_mesh_layout(mesh, numbers.data(), ball.triangle_count()));
  refused(pdesc_mesh_near_seam(mesh, 0.1, near.data(), ball.vertex_count));
  EXPECT_EQ(pdesc_mesh_buffer_size(mesh), 0);
  EXPECT_EQ(field, never_field());
  pdesc_mesh_destroy(mesh); // again
}

TEST_F(Api, a_destroyed_field_is_refused_by_every_call) {
  const Mesh mesh = make_mesh(context.get(), ball);
  const char *name = "mean_curvature";
  pdesc_field *field = nullptr;
  ASSERT_EQ(pdesc_compute(mesh.get(), &options, &name, 1, nullptr, nullptr, &field), PDESC_OK) << pdesc_last_error();
  pdesc_field_destroy(field);
  pdesc_field_report report;
  pdesc_field_report_init(&report);
  std::vector<float> values(static_cast<size_t>(ball.vertex_count));
  std::vector<uint8_t> mask(values.size());
  const auto refused = [](int32_t status) { expect_refused(status, PDESC_ERROR_INVALID_ARGUMENT, {"field", "destroyed"}); };
  refused(pdesc_field_get_report(field, &report));
  refused(pdesc_field_values(field, name, values.data(), ball.vertex_count));
  refused(pdesc_field_seam_error(field, name, values.data(), ball.vertex_count));
  refused(pdesc_field_mask(field, mask.data(), ball.vertex_count));
  refused(pdesc_field_map(field, name, values.data(), 1));
  EXPECT_EQ(pdesc_field_map_size(field), 0);
  EXPECT_STREQ(pdesc_field_warnings(field), "");
  EXPECT_STREQ(pdesc_field_device(field), "");
  pdesc_field_destroy(field); // again
}

TEST_F(Api, a_destroyed_context_is_refused_and_its_meshes_live_on) {
  const Mesh mesh = make_mesh(context.get(), ball);
  pdesc_context *gone = context.get();
  context.reset();
  pdesc_mesh *other = never_mesh();
  expect_refused(pdesc_mesh_create(gone, &input, &other), PDESC_ERROR_INVALID_ARGUMENT, {"context", "destroyed"});
  EXPECT_EQ(pdesc_context_backend(gone), PDESC_BACKEND_AUTO);
  EXPECT_STREQ(pdesc_context_device(gone), "");
  EXPECT_STREQ(pdesc_context_fallback(gone), "");
  pdesc_context_destroy(gone); // again
  EXPECT_EQ(mean_curvature(mesh.get()).size(), static_cast<size_t>(ball.vertex_count));
}

TEST_F(Api, a_handle_of_another_kind_is_refused) {
  const Mesh mesh = make_mesh(context.get(), ball);
  auto *as_mesh = reinterpret_cast<pdesc_mesh *>(context.get());
  auto *as_field = reinterpret_cast<pdesc_field *>(mesh.get());
  pdesc_mesh_report report;
  pdesc_mesh_report_init(&report);
  uint8_t mask = mask_sentinel;
  expect_refused(pdesc_mesh_get_report(as_mesh, &report), PDESC_ERROR_INVALID_ARGUMENT, {"no mesh"});
  expect_refused(pdesc_field_mask(as_field, &mask, 1), PDESC_ERROR_INVALID_ARGUMENT, {"no field"});
  pdesc_mesh_destroy(as_mesh);
  pdesc_field_destroy(as_field);
  EXPECT_EQ(pdesc_context_backend(context.get()), PDESC_BACKEND_REFERENCE);
  EXPECT_EQ(pdesc_mesh_get_report(mesh.get(), &report), PDESC_OK) << pdesc_last_error();
}

struct Caller {
  pdesc_mesh *mesh;
  pdesc_context *other; // of another context than the mesh
  int calls = 0;
};

int32_t call_from_inside(void *user, const char *, double) {
  auto &caller = *static_cast<Caller *>(user);
  ++caller.calls;
  pdesc_mesh_report report;
  pdesc_mesh_report_init(&report);
  expect_refused(pdesc_mesh_get_report(caller.mesh, &report), PDESC_ERROR_INVALID_OPERATION, {"progress callback"});
  pdesc_mesh_destroy(caller.mesh); // stays alive: it is being computed
  EXPECT_STRNE(pdesc_last_error(), "");
  EXPECT_EQ(pdesc_context_backend(caller.other), PDESC_BACKEND_REFERENCE);
  return 1;
}

TEST_F(Api, a_call_from_the_progress_callback_is_refused_instead_of_waiting_for_itself) {
  const Mesh mesh = make_mesh(context.get(), ball);
  const std::vector<float> alone = mean_curvature(mesh.get());
  std::string why_not;
  const Context other = open_context(PDESC_BACKEND_REFERENCE, why_not);
  Caller caller{mesh.get(), other.get()};
  expect_same_bits(mean_curvature(mesh.get(), call_from_inside, &caller), alone);
  EXPECT_GT(caller.calls, 0);
  EXPECT_STREQ(pdesc_last_error(), "") << "a success keeps no sentence of the callback's";
}

TEST_F(Api, a_struct_that_ends_within_a_member_is_refused) {
  input.struct_size = static_cast<uint32_t>(offsetof(pdesc_mesh_input, corner_uvs)) + 4; // half a pointer
  expect_mesh_refused({"struct_size"});
  options.struct_size = static_cast<uint32_t>(offsetof(pdesc_options, map_descriptor)) + 4;
  expect_compute_refused(PDESC_ERROR_INVALID_ARGUMENT, {"struct_size"});
}

} // namespace
} // namespace paradesc::test
