// What the stages of one computation hand to each other; compute/compute.cpp calls them in turn.
#pragma once

#include <chrono>
#include <optional>
#include <utility>
#include <vector>

#include "bake/distortion.h"
#include "bake/surface_maps.h"
#include "compute/passes.h"
#include "compute/compute.h"
#include "sample/neighborhoods.h"

namespace paradesc {

// The sampling ellipse reaches beyond the ball: curvature leaves the rim of one that just touches it empty.
inline constexpr float ellipse_enlargement = 1.25f;

// Everything of one frame that is made on the CPU before the device is asked.
struct Frame {
  Normals normals;
  BufferFrame buffer_frame;
  std::vector<vec4> links;
  std::vector<int32_t> seams; // (borders) what seam each belongs to, where the paper's relocation asks
  std::vector<CenterData> centers;
  std::vector<int32_t> sites;  // (centers) -1: the point has no place in the UV map
  std::vector<int32_t> points; // (centers)
  std::vector<int32_t> order;  // (centers) what number each had before they were put side by side
  std::vector<uint8_t> plain;  // (centers) as in Supports
  BareSamples bare;
  double radius_in_texels = 0.0;
  std::optional<MappedPoints> mapped; // where maps displace the surface
  float enlargement = ellipse_enlargement;
  uint64_t version = 0;     // of the mesh
  int32_t normals_kind = 0; // pdesc_normals
  bool baked = false;       // it is what the device's buffers hold
};

class Clock {
public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    return std::chrono::duration<double>(now - std::exchange(start_, now)).count();
  }

private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// Throws Error(CANCELLED) where the caller says stop.
void check_cancel(const Progress &progress, const char *stage, double fraction);

// ---- Before samples are drawn (engine/opengl/prepare.cpp)

Normals prepare_normals(Mesh &mesh, int32_t kind);
// The frame of the mesh as it is now, with its normals: the last one, while it holds. Kept in mesh.device.
Frame &prepare_frame(Mesh &mesh, const pdesc_options &options);
// Centers and metric of the frame, and the geometry buffers on the device.
void prepare_and_bake(Mesh &mesh, const pdesc_options &options, double radius, Frame &frame);
// Gives the mesh a layout of its own, which it keeps, where the UV map overlaps or leaves most of the buffers empty.
bool lay_out_afresh(Mesh &mesh, double radius_in_texels);
// The same where it has more area than its square has, before anything is drawn.
void part_crowded(Mesh &mesh);
void build_cells_for(Mesh &mesh, const pdesc_options &options, Frame &frame);
// The neighborhoods of all centers of the frame, which this puts into another order, or of those given.
void prepare_supports(Mesh &mesh, const pdesc_options &options, double radius, int samples, Frame &frame);
Supports search_supports(Mesh &mesh, const pdesc_options &options, double radius, int samples, Frame &frame,
                         const std::vector<SupportCenter> &centers);
void set_supports(Mesh &mesh, const Supports &supports, Frame &frame);
// The centers again, for another radius.
void prepare_centers(Mesh &mesh, const pdesc_options &options, double radius, Frame &frame);
// Sampling ellipses of every so many sites.
std::vector<vec4> ellipses_of(Mesh &mesh, const Frame &frame, size_t step);
// How far a pass looks around.
double reach_of(const Pass &pass, const pdesc_options &options, double radius);
// The triangles as they are measured: displaced where maps say so.
const Triangles &surface_of(const Mesh &mesh, const Frame &frame);

// ---- Sampling and descriptors (engine/opengl/evaluation.cpp)

SiteResults evaluate_at_vertices(Mesh &mesh, const pdesc_options &options, std::span<const int> asked, double radius,
                                 Frame &frame, const Progress &progress, Field &field);
SiteResults evaluate_at_texels(Mesh &mesh, const pdesc_options &options, std::span<const int> asked, double radius, Frame &frame,
                               const Progress &progress, Field &field);

} // namespace paradesc
