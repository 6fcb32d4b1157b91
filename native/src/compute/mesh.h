// The caller's arrays → a mesh: its topology, its layout, an engine's session for it, and the radius in its units.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "bake/refined_surface.h"
#include "context.h"
#include "engine/engine.h"
#include "mesh/facets.h"
#include "support/keyed.h"

namespace paradesc {

// The positions' version, the width and height of the largest map in pixels, and the radius.
using DivisionKey = std::tuple<uint64_t, int, int, double>;

struct Mesh {
  std::shared_ptr<Context> context;
  Triangles triangles;
  HalfEdges half_edges;
  Atlases atlases;
  SurfaceMaps maps;
  Box box; // of the positions
  uint64_t positions_version = 0;
  pdesc_mesh_report found{}; // defects of the mesh and its UV map as given

  // Stages that every engine reads, computed on first use.
  mutable Keyed<uint64_t, double> mean_edge;                              // by the positions' version
  std::vector<vec3> steady_normals;                                       // of faces
  uint64_t steady_version = ~uint64_t{0};                                 // version of the positions that they belong to
  Keyed<std::pair<uint64_t, int32_t>, Creases> creases;                   // by the positions' version and pdesc_creases
  Keyed<std::tuple<uint64_t, int32_t, double>, Creases> counting_creases; // and by the radius
  Keyed<std::array<uint64_t, 3>, Normals> normals; // by the positions' version, pdesc_normals and the rings' version
  Keyed<std::array<uint64_t, 3>, Facets> facets;   // by the normals' key
  uint64_t rings_version = 1;                      // differs whenever creases do; 0: normals that have no rings
  std::vector<int32_t> normals_end_at;             // Creases::edges of the rings' version
  std::optional<NormalRings> rings;                // empty if no rings are kept

  // These stages serve engines that do not follow surface maps.
  Keyed<DivisionKey, DivisionPlan> division_plan;
  Keyed<DivisionPlan, Division> division; // may stay valid when positions change
  Keyed<std::tuple<uint64_t, std::array<uint64_t, 3>, int>, RefinedSurface>
      refined;            // by the number of divisions, the normals' key and the maps' version
  uint64_t divisions = 0; // number of divisions made so far

  Keyed<std::pair<int, int>, TexelMap> texels; // by the atlas's version and the size

  std::shared_ptr<Engine> engine; // the session's, which may differ from the context's
  std::unique_ptr<Session> session;
  int64_t memory_held = 0; // approximate bytes that the mesh and its session keep for the next computation

  Mesh() = default;
  Mesh(const Mesh &) = delete;
  Mesh &operator=(const Mesh &) = delete;
};

std::unique_ptr<Mesh> make_mesh(std::shared_ptr<Context> context, const pdesc_mesh_input &input);
void move_mesh(Mesh &mesh, const float *positions, int32_t vertex_count);
pdesc_mesh_report report_of(const Mesh &mesh);
double mean_edge_of(const Mesh &mesh);
double requested_radius(const Mesh &mesh, const pdesc_options &options); // in units of the positions
const Creases &creases_of(Mesh &mesh, const pdesc_options &options);     // where normals end
NormalsOnDemand normals_of(Mesh &mesh, const pdesc_options &options);
const Facets &facets_of(Mesh &mesh, const pdesc_options &options);

// See Session::read_buffer and Session::buffer_size.
ReadBuffer read_buffer(Mesh &mesh, const std::string &name);
int buffer_size(const Mesh &mesh);

// Throws Error(UNSUPPORTED) if an engine of these abilities cannot take this many triangles.
void check_triangle_count(const Abilities &abilities, int32_t triangles);

} // namespace paradesc
