// The sums of one set of instructions: compiled once for each, with LANE_WIDTH lanes and under the name KERNEL_TARGET.
#include "engine/cpu/add_samples.h"

#include "engine/cpu/kinds.h"

namespace paradesc::kernels {
inline namespace KERNEL_TARGET {

constexpr int passes = block_lanes / lane_count;

inline Lanes load(const float *from) {
  Lanes lanes;
  __builtin_memcpy(&lanes, from, sizeof lanes);
  return lanes;
}

// A row of a block, and the two that follow it.
inline Vector<3, Lanes> load3(const float *from) { return {load(from), load(from + block_lanes), load(from + 2 * block_lanes)}; }

// A bit for each of these blocks that may have samples in the ball.
inline uint32_t blocks_in_ball(const SampleBlocks &samples, const SumCenter &center, int first) {
  uint32_t in_ball = 0;
  for (int part = 0; part < passes; ++part) {
    const size_t at = static_cast<size_t>(first + part * lane_count);
    const Lanes x = load(samples.middle[0] + at) - center.position[0], y = load(samples.middle[1] + at) - center.position[1],
                z = load(samples.middle[2] + at) - center.position[2];
    const Choices inside = x * x + y * y + z * z < load(samples.limit + at);
    for (int i = 0; i < lane_count; ++i) in_ball |= static_cast<uint32_t>(inside.lane[i] & 1) << (part * lane_count + i);
  }
  return in_ball;
}

template <class Wide> struct Adder {
  Wide kernel;
  typename Wide::Sums sums;
  Lanes along; // of the samples so far: the largest share of the distance that lies along the normal, squared

  // block: from the lanes of this pass on.
  void add(const float *block) {
    const auto row = [&](int index) { return block + index * block_lanes; };
    const Vector<3, Lanes> position = load3(row(SAMPLE_X)), normal = load3(row(SAMPLE_NORMAL_X)),
                           face = load3(row(SAMPLE_FACE_X));
    const Lanes area = load(row(SAMPLE_AREA)), per_side = load(row(SAMPLE_PER_SIDE));
    Vector<4, Lanes> map(0.0f);
    if constexpr (requires { sums.center.value; }) {
      const Vector<3, Lanes> gradient = load3(row(SAMPLE_GRADIENT_X));
      map = {gradient.x, gradient.y, gradient.z, load(row(SAMPLE_VALUE))};
    }
    const Choices far{};
    kernel.add_neighbor(sums, position, normal, face, area, per_side, far, -1.0f, map);
    const Vector<3, Lanes> offset = position - sums.center.position;
    const Lanes square = dot(offset, offset), height = dot(offset, normal);
    const Choices counts = (kernel.params.radius - sqrt(square)) * per_side + 0.5f > 0.0f && area > 0.0f;
    along = max(along, mix(0.0f, height * height / max(square, 1e-30f), counts));
  }
};

using AllLanes = std::array<float, block_lanes>;

// The lanes of one pass go where they belong among all. Returns where the next part's go.
template <class Part> AllLanes *store(const Part &part, int pass, AllLanes *lanes) {
  constexpr size_t count = sizeof(Part) / sizeof(Lanes);
  for (size_t i = 0; i < count; ++i)
    __builtin_memcpy(lanes[i].data() + pass * lane_count, reinterpret_cast<const char *>(&part) + i * sizeof(Lanes),
                     sizeof(Lanes));
  return lanes + count;
}

template <template <class, class> class Kernel>
float add_samples(const EvaluateParams &params, const SampleBlocks &samples, const SumCenter &center, float *sums) {
  using Wide = Kernel<Lanes, Choices>;
  alignas(64) AllLanes lanes[max_sums];
  AllLanes *end = lanes;
  float along = 0.0f;
  for (int pass = 0; pass < passes; ++pass) {
    Adder<Wide> adder{Wide{params}, {}, 0.0f};
    const auto all = [](const float *v) { return Vector<3, Lanes>(v[0], v[1], v[2]); };
    adder.kernel.sums_init(adder.sums, all(center.position), all(center.normal), center.value);
    for (int first = 0; first < samples.count; first += block_lanes)
      for (uint32_t blocks = blocks_in_ball(samples, center, first); blocks; blocks &= blocks - 1) {
        const ptrdiff_t block = samples.block[first + __builtin_ctz(blocks)];
        adder.add(samples.data + samples.stride * block + pass * lane_count);
      }
    end = store(adder.sums.moments, pass, lanes);
    if constexpr (requires { adder.sums.half_ball; }) end = store(adder.sums.half_ball, pass, end);
    end = store(adder.sums.terms, pass, end);
    for (int i = 0; i < lane_count; ++i) along = adder.along.lane[i] > along ? adder.along.lane[i] : along;
  }
  for (const AllLanes *one = lanes; one != end; ++one) *sums++ = sum_of(*one);
  return along;
}

#define JOIN(a, b) a##b
#define NAME_OF(target) JOIN(add_samples_by_kind_of_, target)
extern const AddSamples NAME_OF(KERNEL_TARGET)[sum_kinds];
const AddSamples NAME_OF(KERNEL_TARGET)[sum_kinds] = {add_samples<FitKernel>,
                                                      add_samples<SurfaceKernel>,
                                                      add_samples<SurfaceGeodesicKernel>,
                                                      add_samples<ExtrapolatedKernel>,
                                                      add_samples<ExtrapolatedGeodesicKernel>,
                                                      add_samples<JetKernel>,
                                                      add_samples<JetGeodesicKernel>,
                                                      add_samples<WindowsKernel>,
                                                      add_samples<WindowsGeodesicKernel>};

} // namespace KERNEL_TARGET
} // namespace paradesc::kernels
