// libFuzzer's entry: any bytes → a sequence of calls of the C interface, in any order and with any arguments that a caller may
// give without lying about the length of an array. Returned values are checked; the sanitizers watch the rest.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <thread>

#include "bytes.h"
#include "claims.h"
#include "images.h"
#include "mesh.h"
#include "paradesc/paradesc.h"
#include "passed.h"
#include "programs.h"
#include "rays.h"

#ifndef PARADESC_FUZZ_BACKEND
#define PARADESC_FUZZ_BACKEND PDESC_BACKEND_CPU
#endif
#ifndef PARADESC_FUZZ_STOPPED
#define PARADESC_FUZZ_STOPPED 0
#endif

namespace paradesc::fuzz {
namespace {

constexpr bool on_device = PARADESC_FUZZ_BACKEND == PDESC_BACKEND_SOFTWARE;
// Samples cost time on all backends but the reference, which reads neither their number nor that of texels.
constexpr bool on_reference = PARADESC_FUZZ_BACKEND == PDESC_BACKEND_REFERENCE;
constexpr int32_t most_samples = on_reference ? 4096 : on_device ? 64 : 256, most_texels = on_reference ? 8192 : 64;
constexpr bool mostly_stopped = PARADESC_FUZZ_STOPPED;
// Without a limit every mesh and computation asks the system what is free, for longer than many an input takes. If surfaces
// are divided for their maps, the limit keeps the pieces from becoming millions, or thousands on the reference, which sums over
// all pieces at each of their points for filters of a map.
constexpr int64_t usual_limit = int64_t{1} << (on_device ? 31 : on_reference ? 22 : 26);

const char *any_descriptor(Bytes &bytes, bool rarely_wrong = true) {
  constexpr const char *wrong[] = {nullptr,    "",       "coverage", "mean",     "mean_curvature ", "%s%n",
                                   "position", "normal", "chart",    "neighbor", "distortion"};
  if (!rarely_wrong || bytes.one_in(16)) return wrong[static_cast<size_t>(bytes.below(std::size(wrong)))];
  pdesc_descriptor_info info;
  pdesc_descriptor_info_init(&info);
  done(pdesc_descriptor_get(bytes.below(pdesc_descriptor_count()), &info));
  return info.name;
}

size_t components_of(const std::string &name) {
  pdesc_descriptor_info info;
  pdesc_descriptor_info_init(&info);
  for (int32_t i = 0; i < pdesc_descriptor_count(); ++i)
    if (pdesc_descriptor_get(i, &info) == PDESC_OK && name == info.name) return static_cast<size_t>(info.components);
  return 1;
}

int32_t choice(Bytes &bytes, int count) { return bytes.one_in(32) ? bytes.whole() : bytes.below(count); }

// Sizes that are computed within the time of a fuzzer, or none that are allowed at all.
int32_t size_of(Bytes &bytes, int32_t low, int32_t high) {
  if (bytes.one_in(16)) {
    const int32_t any = bytes.whole();
    return any > high && any <= 8192 ? 8193 : any;
  }
  return low + bytes.byte() * (high - low) / 255;
}

pdesc_options make_options(Bytes &bytes) {
  pdesc_options options;
  pdesc_options_init(&options);
  const double share = bytes.share();
  options.radius = share * std::abs(share); // mostly a few triangles: what takes time are the sums over them
  options.radius_unit = choice(bytes, 3);
  options.samples = size_of(bytes, 8, most_samples);
  options.buffer_size = size_of(bytes, 64, on_device ? 160 : 8192);
  options.normals = choice(bytes, 3);
  options.max_jumps = size_of(bytes, 0, 64);
  options.seed = bytes.byte();
  options.relocation = choice(bytes, 3);
  options.estimator = choice(bytes, 3);
  options.variance_reduction = choice(bytes, 2);
  options.geodesic = bytes.one_in(4) ? choice(bytes, 2) : 0;
  options.distance = choice(bytes, 2);
  options.pattern = choice(bytes, 2);
  options.ellipse = choice(bytes, 2);
  options.evaluate = choice(bytes, 2);
  options.texels = size_of(bytes, 16, most_texels);
  options.precision = choice(bytes, 2);
  if (bytes.one_in(4)) options.adaptive = static_cast<double>(bytes.number());
  if (bytes.one_in(4)) options.map_descriptor = any_descriptor(bytes);
  if (bytes.one_in(4)) options.map_sigma = 4.0 * bytes.share();
  if (bytes.one_in(4)) options.harris_k = 0.25 * bytes.share();
  options.creases = choice(bytes, 3);
  return options;
}

struct MeshSlot {
  pdesc_mesh *mesh = nullptr;
  int32_t vertices = 0, corners = 0, triangles = 0;
};

struct FieldSlot {
  pdesc_field *field = nullptr;
  int32_t vertices = 0;
  std::vector<std::string> names;
};

// The state and the action of a progress callback.
struct Watch {
  std::thread::id caller;
  int until_cancel;
  const MeshSlot *mesh;
};

int32_t on_progress(void *user, const char *stage, double fraction) {
  auto &watch = *static_cast<Watch *>(user);
  claim(std::this_thread::get_id() == watch.caller, "progress was reported on another thread");
  claim(stage && *stage, "a stage has no name");
  claim(fraction >= 0.0 && fraction <= 1.0, "a fraction lies outside of [0, 1]");
  pdesc_mesh_report report;
  pdesc_mesh_report_init(&report);
  claim(pdesc_mesh_get_report(watch.mesh->mesh, &report) == PDESC_ERROR_INVALID_OPERATION,
        "a call from the callback was not refused");
  return watch.until_cancel-- != 0;
}

class Session {
public:
  explicit Session(Bytes &bytes) : bytes_(bytes) {}
  ~Session() {
    for (FieldSlot &slot : fields_) destroy(slot);
    for (MeshSlot &slot : meshes_) destroy(slot);
    if (!on_device) pdesc_context_destroy(context_);
  }
  Session(const Session &) = delete;
  Session &operator=(const Session &) = delete;

  void run() {
    open();
    create();
    compute();
    for (int calls = 0; calls < 24 && !bytes_.empty(); ++calls) call();
  }

private:
  void open() {
    if (on_device) {
      context_ = device();
      return;
    }
    pdesc_context_options options;
    pdesc_context_options_init(&options);
    options.backend = PARADESC_FUZZ_BACKEND;
    const bool rare = bytes_.one_in(32);
    options.threads = rare ? 1 + bytes_.below(3) : 1;
    options.memory_limit = rare ? 0 : usual_limit;
    takes_maps_ = !rare;
    claim(done(pdesc_context_create(&options, &context_)), "the backend is not there");
    claim(pdesc_context_backend(context_) == PARADESC_FUZZ_BACKEND && *pdesc_context_device(context_), "a context is another");
  }

  // Opening a device and compiling its programs takes longer than hundreds of inputs, but a context keeps every program.
  static pdesc_context *device() {
    static pdesc_context *opened = nullptr;
    static int uses = 0;
    if (opened && ++uses % 1000 != 0) return opened;
    pdesc_context_destroy(opened);
    pdesc_context_options options;
    pdesc_context_options_init(&options);
    options.backend = PARADESC_FUZZ_BACKEND;
    options.threads = 1;
    options.memory_limit = usual_limit;
    claim(done(pdesc_context_create(&options, &opened)), "the software backend is not there");
    return opened;
  }

  MeshSlot &any_mesh() { return meshes_[static_cast<size_t>(bytes_.below(2))]; }
  FieldSlot &any_field() { return fields_[static_cast<size_t>(bytes_.below(2))]; }

  void call() {
    const int kind = bytes_.byte();
    if (kind >= 252) return cast_rays(bytes_);
    if (kind >= 240) return kind % 2 ? draw_image(bytes_) : fill_gutter(bytes_);
    switch (kind % 20) {
    case 0:
      return create();
    case 1:
    case 2:
    case 3:
      return compute();
    case 4:
      return move();
    case 5:
      return displace();
    case 6:
      return map_normals();
    case 7:
      return read_mesh(any_mesh());
    case 8:
      return read_buffer(any_mesh());
    case 9:
    case 10:
    case 11:
      return read_values(any_field());
    case 12:
      return read_map(any_field());
    case 13:
      return destroy(any_mesh());
    case 14:
      return destroy(any_field());
    case 15:
      return near_seam(any_mesh());
    case 16:
      return use_the_dead();
    case 17:
      return use_another_kind();
    case 18:
      return open_another();
    default:
      return read_report(any_field());
    }
  }

  void create() {
    const auto arrays = make_arrays(bytes_);
    Passed<pdesc_mesh_input> passed(bytes_, arrays->input);
    pdesc_mesh *made = nullptr;
    MeshSlot &slot = any_mesh();
    if (!done(pdesc_mesh_create(bytes_.one_in(64) ? nullptr : context_, bytes_.one_in(64) ? nullptr : passed.get(), &made))) {
      claim(!made, "an output was touched on failure");
      return;
    }
    destroy(slot);
    const pdesc_mesh_input input = passed.read();
    slot = {made, input.vertex_count, input.corner_count, input.triangle_count};
    read_mesh(slot);
  }

  void compute() {
    const MeshSlot &mesh = any_mesh();
    pdesc_options chosen = make_options(bytes_);
    const char *usual = on_device ? choose_usual_program(chosen) : nullptr;
    Passed<pdesc_options> passed(bytes_, chosen);
    std::vector<const char *> names(
        static_cast<size_t>(bytes_.one_in(8) ? bytes_.below(24) : 1 + bytes_.below(on_device ? 2 : 4)));
    for (const char *&name : names) name = any_descriptor(bytes_);
    if (usual && !names.empty()) names = {usual};
    auto count = static_cast<int32_t>(names.size());
    if (bytes_.one_in(64)) count = std::min(count, bytes_.whole());
    Watch watch{std::this_thread::get_id(), calls_until_cancel(), &mesh};
    const bool watched = bytes_.one_in(2) || watch.until_cancel >= 0;
    pdesc_field *made = nullptr;
    const pdesc_options *options = bytes_.one_in(32) && !on_device ? nullptr : passed.get();
    if (!done(pdesc_compute(mesh.mesh, options, names.data(), count, watched ? on_progress : nullptr, &watch, &made))) {
      claim(!made, "an output was touched on failure");
      return;
    }
    FieldSlot &slot = any_field();
    destroy(slot);
    slot = {made, mesh.vertices, {names.begin(), names.begin() + count}};
    check_field(slot, mesh);
  }

  // -1: never. The sums take most of the time, so the target of stopped computations reaches them, but rarely goes on.
  int calls_until_cancel() {
    if (mostly_stopped) return bytes_.one_in(32) ? -1 : bytes_.below(2);
    return bytes_.one_in(8) ? bytes_.below(40) : -1;
  }

  // All that the header says about every result.
  static void check_field(const FieldSlot &slot, const MeshSlot &mesh) {
    pdesc_field_report report;
    pdesc_field_report_init(&report);
    claim(done(pdesc_field_get_report(slot.field, &report)), "a field has no report");
    pdesc_mesh_report whole;
    pdesc_mesh_report_init(&whole);
    claim(done(pdesc_mesh_get_report(mesh.mesh, &whole)), "a mesh has no report");
    claim(std::isfinite(report.radius) && (report.radius > 0.0 || whole.diagonal == 0.0f), "the radius in use is none");
    claim(report.coverage_mean >= 0.0 && report.coverage_mean <= 1.0 + 1e-6, "the mean coverage is none");
    const auto count = static_cast<size_t>(slot.vertices);
    std::vector<uint8_t> mask(count, 0xEE), undefined(count, 0);
    claim(done(pdesc_field_mask(slot.field, mask.data(), slot.vertices)), "a field has no mask");
    for (const std::string &name : slot.names) {
      const size_t width = components_of(name);
      std::vector<float> values(width * count, sentinel);
      claim(done(pdesc_field_values(slot.field, name.c_str(), values.data(), slot.vertices)),
            "a descriptor that was asked for is not there");
      for (size_t i = 0; i < values.size(); ++i) {
        claim(values[i] != sentinel, "a value was not written");
        claim(!std::isinf(values[i]), ("a value of " + name + " is infinite").c_str());
        claim(std::isnan(values[i]) || !(mask[i / width] & (PDESC_MASK_NO_FACE | PDESC_MASK_NO_TEXEL)),
              "a value stands where none exists");
        undefined[i / width] |= std::isnan(values[i]);
      }
    }
    claim(std::count(undefined.begin(), undefined.end(), 1) == report.undefined_vertices,
          "the count of undefined vertices is wrong");
    for (const uint8_t bits : mask) claim(bits < 16, "a mask has unknown bits");
  }

  void move() {
    const MeshSlot &slot = any_mesh();
    int32_t count = slot.vertices;
    if (bytes_.one_in(16)) count = std::min(count, bytes_.whole());
    std::vector<float> positions(3 * static_cast<size_t>(std::max(count, 0)));
    const float scale = bytes_.number();
    for (float &x : positions) x = bytes_.number() * scale;
    done(pdesc_mesh_set_positions(slot.mesh, bytes_.one_in(32) ? nullptr : positions.data(), count));
  }

  void displace() {
    if (!takes_maps_) return;
    const int32_t width = bytes_.below(6), height = bytes_.below(6);
    std::vector<float> heights(static_cast<size_t>(width * height));
    for (float &x : heights) x = bytes_.number();
    const float *image = bytes_.one_in(8) ? nullptr : heights.data();
    done(pdesc_mesh_set_displacement(any_mesh().mesh, image, bytes_.one_in(16) ? -1 : width, height,
                                     static_cast<double>(bytes_.number()), static_cast<double>(bytes_.number())));
  }

  void map_normals() {
    if (!takes_maps_) return;
    const MeshSlot &slot = any_mesh();
    const int32_t width = bytes_.below(4), height = bytes_.below(4);
    std::vector<float> colors(static_cast<size_t>(3 * width * height)), tangents(4 * static_cast<size_t>(slot.corners));
    for (float &x : colors) x = bytes_.one_in(8) ? bytes_.number() : static_cast<float>(bytes_.byte()) / 255.0f;
    for (float &x : tangents) x = bytes_.number();
    const float *image = bytes_.one_in(8) ? nullptr : colors.data();
    done(pdesc_mesh_set_normal_map(slot.mesh, image, width, height, bytes_.one_in(16) ? nullptr : tangents.data(),
                                   bytes_.one_in(16) ? std::min(slot.corners, bytes_.whole()) : slot.corners));
  }

  void read_mesh(const MeshSlot &slot) {
    pdesc_mesh_report ours;
    pdesc_mesh_report_init(&ours);
    Passed<pdesc_mesh_report> passed(bytes_, ours);
    if (!done(pdesc_mesh_get_report(slot.mesh, passed.get()))) return;
    const pdesc_mesh_report report = passed.read();
    for (const int32_t count : {report.loose_vertices, report.welded_vertices})
      claim(count >= 0 && count <= slot.vertices, "a count of vertices is none");
    for (const int32_t count : {report.degenerate_triangles, report.zero_uv_area_triangles, report.flipped_triangles,
                                report.charts, report.parts, report.copied_triangles, report.inward_parts})
      claim(count >= 0 && count <= slot.triangles, "a count of triangles is none");
    for (const int32_t count : {report.nonmanifold_edges, report.boundary_edges, report.seam_edges, report.self_seam_edges,
                                report.unlinked_edges, report.opposed_edges})
      claim(count >= 0 && count <= 3 * slot.triangles, "a count of edges is none");
    claim(report.diagonal >= 0.0f && std::isfinite(report.diagonal) && report.mean_edge >= 0.0f &&
              std::isfinite(report.mean_edge),
          "a length is none");
    std::vector<float> uvs(6 * static_cast<size_t>(slot.triangles), sentinel);
    if (!done(pdesc_mesh_layout(slot.mesh, uvs.data(), slot.triangles))) return;
    for (const float x : uvs) claim(x >= 0.0f && x <= 1.0f, "a place of the layout lies outside of its square");
  }

  void read_buffer(const MeshSlot &slot) {
    const int64_t size = pdesc_mesh_buffer_size(slot.mesh);
    const char *name = any_descriptor(bytes_, false);
    const int64_t count = bytes_.one_in(8) ? bytes_.byte() : size * size * (1 + bytes_.below(4));
    std::vector<float> values(static_cast<size_t>(count), sentinel);
    done(pdesc_mesh_read_buffer(slot.mesh, name, values.data(), count));
  }

  void near_seam(const MeshSlot &slot) {
    const int32_t count = bytes_.one_in(16) ? std::min(slot.vertices, bytes_.whole()) : slot.vertices;
    std::vector<uint8_t> near(static_cast<size_t>(std::max(count, 0)), 0xEE);
    if (!done(pdesc_mesh_near_seam(slot.mesh, static_cast<double>(bytes_.number()), near.data(), count))) return;
    for (const uint8_t bit : near) claim(bit <= 1, "near a seam is neither yes nor no");
  }

  void read_values(const FieldSlot &slot) {
    const char *name = !slot.names.empty() && bytes_.one_in(2) ? slot.names[0].c_str() : any_descriptor(bytes_, bytes_.one_in(2));
    const int32_t count = bytes_.one_in(16) ? std::min(slot.vertices, bytes_.whole()) : slot.vertices;
    std::vector<float> values(3 * static_cast<size_t>(std::max(count, 0)), sentinel);
    std::vector<uint8_t> mask(static_cast<size_t>(std::max(count, 0)));
    done(pdesc_field_values(slot.field, name, bytes_.one_in(32) ? nullptr : values.data(), count));
    done(pdesc_field_seam_error(slot.field, name, values.data(), count));
    done(pdesc_field_mask(slot.field, mask.data(), count));
  }

  void read_map(const FieldSlot &slot) {
    const int64_t size = pdesc_field_map_size(slot.field);
    const char *name = !slot.names.empty() ? slot.names[0].c_str() : any_descriptor(bytes_);
    const int64_t count = bytes_.one_in(8) ? bytes_.byte() : size * size * (bytes_.one_in(2) ? 3 : 1);
    std::vector<float> values(static_cast<size_t>(count), sentinel);
    done(pdesc_field_map(slot.field, name, values.data(), count));
  }

  void read_report(const FieldSlot &slot) {
    pdesc_field_report ours;
    pdesc_field_report_init(&ours);
    Passed<pdesc_field_report> passed(bytes_, ours);
    done(pdesc_field_get_report(slot.field, passed.get()));
    claim(pdesc_field_warnings(slot.field) != nullptr, "warnings are no text");
    claim(pdesc_field_device(slot.field) != nullptr, "a device is no text");
    pdesc_descriptor_info info;
    pdesc_descriptor_info_init(&info);
    Passed<pdesc_descriptor_info> row(bytes_, info);
    done(pdesc_descriptor_get(bytes_.whole(), row.get()));
  }

  // A context with any options: the backends that this target is not about, in a fuzzer only where they are refused.
  void open_another() {
    pdesc_context_options ours;
    pdesc_context_options_init(&ours);
    ours.backend = bytes_.one_in(2) ? PDESC_BACKEND_REFERENCE : bytes_.whole();
    if (ours.backend >= PDESC_BACKEND_AUTO && ours.backend < PDESC_BACKEND_REFERENCE) ours.backend = -1;
    ours.device_index = bytes_.whole();
    ours.threads = bytes_.whole();
    Passed<pdesc_context_options> passed(bytes_, ours);
    const uint32_t size = passed.get()->struct_size;
    if (size >= 8 && size <= 4096 && passed.read().backend != ours.backend) return; // a part of one
    pdesc_context *other = nullptr;
    if (!done(pdesc_context_create(passed.get(), &other))) return;
    pdesc_context_destroy(other);
    claim(pdesc_context_backend(other) == PDESC_BACKEND_AUTO && !*pdesc_context_device(other), "a dead context answers");
  }

  // Handles that were destroyed; skipped where a new one has got the address.
  void use_the_dead() {
    if (dead_mesh_ && dead_mesh_ != meshes_[0].mesh && dead_mesh_ != meshes_[1].mesh) {
      pdesc_mesh_destroy(dead_mesh_);
      MeshSlot slot = meshes_[0];
      slot.mesh = dead_mesh_;
      pdesc_mesh_report report;
      pdesc_mesh_report_init(&report);
      claim(pdesc_mesh_get_report(slot.mesh, &report) == PDESC_ERROR_INVALID_ARGUMENT, "a dead mesh is not refused");
      claim(pdesc_mesh_buffer_size(slot.mesh) == 0, "a dead mesh has buffers");
      near_seam(slot);
      read_buffer(slot);
    }
    if (dead_field_ && dead_field_ != fields_[0].field && dead_field_ != fields_[1].field) {
      pdesc_field_destroy(dead_field_);
      FieldSlot slot = fields_[0];
      slot.field = dead_field_;
      read_values(slot);
      read_map(slot);
      read_report(slot);
    }
  }

  void use_another_kind() {
    auto *as_mesh = reinterpret_cast<pdesc_mesh *>(context_);
    auto *as_field = reinterpret_cast<pdesc_field *>(meshes_[0].mesh);
    pdesc_mesh_destroy(as_mesh);
    pdesc_field_destroy(as_field);
    pdesc_context_destroy(reinterpret_cast<pdesc_context *>(meshes_[1].mesh));
    claim(pdesc_mesh_buffer_size(as_mesh) == 0 && pdesc_field_map_size(as_field) == 0, "a handle of another kind answers");
    claim(*pdesc_field_warnings(as_field) == 0, "a handle of another kind warns");
    claim(*pdesc_field_device(as_field) == 0, "a handle of another kind was computed");
  }

  void destroy(MeshSlot &slot) {
    if (slot.mesh) dead_mesh_ = slot.mesh;
    pdesc_mesh_destroy(slot.mesh);
    slot = {};
  }

  void destroy(FieldSlot &slot) {
    if (slot.field) dead_field_ = slot.field;
    pdesc_field_destroy(slot.field);
    slot = {};
  }

  Bytes &bytes_;
  pdesc_context *context_ = nullptr;
  bool takes_maps_ = true; // surfaces that they divide are limited by memory alone
  std::array<MeshSlot, 2> meshes_;
  std::array<FieldSlot, 2> fields_;
  pdesc_mesh *dead_mesh_ = nullptr;
  pdesc_field *dead_field_ = nullptr;
};

} // namespace
} // namespace paradesc::fuzz

extern "C" int LLVMFuzzerInitialize(int *, char ***) {
  return std::atexit(
      [] { std::fprintf(stderr, "calls of the interface: %lld\n", static_cast<long long>(paradesc::fuzz::calls_made)); });
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  paradesc::fuzz::Bytes bytes(data, size);
  paradesc::fuzz::Session(bytes).run();
  return 0;
}
