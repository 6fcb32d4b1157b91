// Lengths of edges → plan → pieces → points and normals. The plan depends on the mesh's positions and on the sizes of the images;
// the pieces depend only on the plan, which frames often share with the previous one; the images' contents matter only in the
// last stage.
#include "compute/refine.h"

#include "bake/refined_surface.h"

namespace paradesc {

bool is_divided(const Mesh &mesh, int32_t backend) { return mesh.maps.any() && !abilities_of(backend).surface_maps; }

static MeasureTriangle measure_of(const Mesh &mesh, const pdesc_options &options) {
  return measure_of_maps(mesh.maps, mesh.triangles, requested_radius(mesh, options));
}

static DivisionKey key_of(const Mesh &mesh, const pdesc_options &options) {
  const ivec2 size = largest_image(mesh.maps);
  return {mesh.positions_version, size.x, size.y, requested_radius(mesh, options)};
}

const DivisionPlan &division_plan_of(Mesh &mesh, const pdesc_options &options) {
  return mesh.division_plan.get(key_of(mesh, options), [&] {
    return plan_division(mesh.half_edges, measure_of(mesh, options), most_pieces, mesh.context->threads);
  });
}

static const Division &division_of(Mesh &mesh, const pdesc_options &options) {
  const DivisionPlan &plan = division_plan_of(mesh, options);
  return mesh.division.get(plan, [&] {
    mesh.refined.clear();
    ++mesh.divisions;
    return divide(mesh.half_edges, plan, mesh.context->threads);
  });
}

Surface refined_surface_of(Mesh &mesh, const pdesc_options &options) {
  const int threads = mesh.context->threads;
  const NormalsOnDemand normals = normals_of(mesh, options);
  const Division &division = division_of(mesh, options);
  const RefinedSurface &refined = mesh.refined.get({mesh.divisions, normals.key, mesh.maps.version}, [&] {
    return refine_surface(mesh.maps, mesh.triangles, mesh.half_edges, normals(), bake_space_of(mesh.box), division, threads);
  });
  static const SurfaceMaps none;
  return {refined.triangles,
          division.half_edges,
          {.make = [&refined]() -> const Normals & { return refined.normals; }},
          nullptr,
          none,
          refined.box,
          mesh.atlases,
          mesh.positions_version,
          mesh.divisions,
          DividedMesh{mesh.triangles, mesh.half_edges, division}};
}

void forget_refined_surface(Mesh &mesh) {
  mesh.division_plan.clear();
  mesh.division.clear();
  mesh.refined.clear();
}

int64_t bytes_of_refined_surface(const Mesh &mesh, const DivisionPlan &plan) {
  const int64_t points = mesh.half_edges.point_count + int64_t{plan.new_points()}, triangles = mesh.triangles.triangle_count;
  const int64_t fans = 3 * triangles + plan.side_points() + plan.inner_begin.back();
  constexpr int64_t of_piece = 4 * 12 + 4 + 11; // points, twins, fans, vertices of corners; its part of the mesh; where it is cut
  constexpr int64_t of_point = 24 + 13;         // position, normal; links
  constexpr int64_t of_fan = 8 + 24;            // its place; position and normal
  return plan.pieces() * of_piece + points * of_point + fans * of_fan + (plan.side_points() + 24 * triangles) * 4;
}

} // namespace paradesc
