// Lists the samples of blocks of patches in parallel.
#include "engine/cpu/patch_samples.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "support/parallel.h"

namespace paradesc {

static constexpr float least_area = 1e-30f; // its reciprocal is a finite float

SampledTriangle SampledSurface::triangle(int32_t place) const {
  const int32_t index = patches.triangle[place];
  SampledTriangle triangle{};
  for (int32_t k = 0; k < 3; ++k) {
    for (int axis = 0; axis < 3; ++axis)
      triangle.position[k][axis] = surface.arrays().position[axis][patches.corner[3 * place + k]];
    triangle.normal[k] = mesh.normals.corner(static_cast<size_t>(3 * index + k));
    if (map) triangle.map[k] = (*map)[mesh.half_edges.corner_point[3 * index + k]];
  }
  triangle.noise = static_cast<float>(mesh.space.scale * mesh.space.scale) * mesh.normals.noise_of(index);
  return triangle;
}

Sample SampledSurface::cluster(int32_t index) const { return sample_of(surface.cluster(index)); }

// Uses the edge midpoints of the cluster's triangles, over which the product of two linear functions has its mean.
SampleMap SampledSurface::map_of_cluster(int32_t index, const Sample &sample) const {
  const float u = dot(sample.along[0], sample.along[0]), v = dot(sample.along[1], sample.along[1]),
              uv = dot(sample.along[0], sample.along[1]), determinant = u * v - uv * uv;
  const bool is_line = !(determinant > 1e-6f * u * v);
  const vec3 to_first =
      is_line ? sample.along[0] / std::max(u, 1e-30f) : (v * sample.along[0] - uv * sample.along[1]) / determinant;
  const vec3 to_second = is_line ? vec3(0.0f) : (u * sample.along[1] - uv * sample.along[0]) / determinant;
  const auto place = [&](int32_t corner) { return mesh.space.to_buffer(mesh.triangles.position(corner)); };
  vec4 mean(0.0f), first_sum(0.0f), second_sum(0.0f);
  vec2 places(0.0f);
  float area = 0.0f;
  for (int32_t i = patches.member_begin[index]; i < patches.member_begin[index + 1]; ++i) {
    const int32_t first = 3 * patches.member[i];
    const vec3 a = place(first);
    const float part = length(cross(place(first + 1) - a, place(first + 2) - a)) * (1.0f / 3.0f);
    area += 3.0f * part;
    for (int32_t corner = first; corner < first + 3; ++corner) {
      const int32_t next = next_corner(corner);
      const auto at = [&](int32_t c) { return (*map)[mesh.half_edges.corner_point[c]]; };
      const vec4 value = part * 0.5f * (at(corner) + at(next));
      const vec3 gap = 0.5f * (place(corner) + place(next)) - sample.position;
      const vec2 along(dot(gap, to_first), dot(gap, to_second));
      mean += value;
      first_sum += value * along.x;
      second_sum += value * along.y;
      places += part * along;
    }
  }
  if (!(area > 0.0f)) return {};
  mean /= area;
  return flat(mean, (first_sum - mean * places.x) / area, (second_sum - mean * places.y) / area);
}

static float area_of(const SampledTriangle &triangle) {
  return 0.5f * length(cross(triangle.position[1] - triangle.position[0], triangle.position[2] - triangle.position[0]));
}

// Calls use() for each triangle of some patches that is summed one by one.
template <class Use>
static void for_each_sampled(const SampledSurface &surface, SampledTriangles which, int32_t first_patch, int32_t last_patch,
                             const Use &use) {
  const PatchArrays &arrays = surface.surface.arrays();
  for (int32_t patch = first_patch; patch < last_patch; ++patch) {
    if (which == SampledTriangles::large && arrays.has_listed[patch] == 0) continue;
    for (int32_t t = arrays.triangle_begin[patch]; t < arrays.triangle_begin[patch + 1]; ++t) {
      if (which == SampledTriangles::large && arrays.rim[t].area > 0.0f) continue;
      const SampledTriangle triangle = surface.triangle(t);
      if (area_of(triangle) > least_area) use(t, triangle);
    }
  }
}

double count_samples(const SampledSurface &surface, const SampleLimit &limit, SampledTriangles which) {
  const Blocks blocks{surface.patches.patches(), patches_of_block};
  std::vector<double> counts(static_cast<size_t>(blocks.number()), 0.0);
  parallel_blocks(blocks.number(), surface.threads, 1, [&](int block, int) {
    for_each_sampled(surface, which, blocks.begin(block), blocks.end(block), [&](int32_t, const SampledTriangle &triangle) {
      const float samples = count_samples(triangle, limit).samples;
      if (samples <= max_stored_samples) counts[block] += static_cast<double>(samples);
    });
  });
  double count = surface.patches.clusters();
  for (const double of_block : counts) count += of_block;
  return count;
}

// Lets the first sample of each run tell how far the run reaches.
static void measure_runs(std::span<FlatSample> samples) {
  for (size_t begin = 0; begin < samples.size(); begin += samples_of_run) {
    FlatSample &first = samples[begin];
    for (const FlatSample &sample : samples.subspan(begin, std::min<size_t>(samples_of_run, samples.size() - begin))) {
      float square = 0.0f;
      for (int axis = 0; axis < 3; ++axis) {
        const float gap = sample.position[axis] - first.position[axis];
        square += gap * gap;
      }
      first.run_reach = std::max(first.run_reach, std::sqrt(square) + sample.reach);
    }
  }
}

static void add_triangle(const SampledTriangle &triangle, const SampleLimit &limit, bool has_map, SampleList &list) {
  const SampleCount count = count_samples(triangle, limit);
  if (count.samples > max_stored_samples) return;
  if (!count.is_small) {
    const size_t first = list.sample.size();
    divide_triangle(triangle, limit, {}, has_map, list);
    return measure_runs(std::span(list.sample).subspan(first));
  }
  list.sample.push_back(flat(sample_of(triangle), false));
  if (has_map) list.map.push_back(map_of_triangle(triangle.map));
}

static void add_patch(const SampledSurface &surface, const SampleLimit &limit, SampledTriangles which, int32_t patch,
                      SampleBlock &block) {
  const auto end = [&](int32_t item) {
    block.item.push_back(item);
    block.first.push_back(static_cast<int32_t>(block.list.sample.size()));
  };
  for_each_sampled(surface, which, patch, patch + 1, [&](int32_t t, const SampledTriangle &triangle) {
    add_triangle(triangle, limit, surface.map != nullptr, block.list);
    end(t);
  });
  for (int32_t k = surface.patches.cluster_begin[patch]; k < surface.patches.cluster_begin[patch + 1]; ++k) {
    const Sample sample = surface.cluster(k);
    if (!(sample.area > least_area)) continue;
    block.list.sample.push_back(flat(sample, true));
    if (surface.map) block.list.map.push_back(surface.map_of_cluster(k, sample));
    end(~k);
  }
  block.begin.push_back(static_cast<int32_t>(block.item.size()));
}

PatchSamples list_samples(const SampledSurface &surface, const SampleLimit &limit, SampledTriangles which) {
  const Blocks blocks{surface.patches.patches(), patches_of_block};
  PatchSamples samples(static_cast<size_t>(blocks.number()));
  parallel_blocks(blocks.number(), surface.threads, 1, [&](int index, int) {
    SampleBlock block;
    for (int32_t patch = blocks.begin(index); patch < blocks.end(index); ++patch) add_patch(surface, limit, which, patch, block);
    block.list.sample.shrink_to_fit();
    block.list.map.shrink_to_fit();
    samples[index] = std::move(block);
  });
  return samples;
}

} // namespace paradesc
