// Height and normal images → displaced points.
#include "bake/surface_maps.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "support/error.h"
#include "support/parallel.h"
#include "support/shown.h"

namespace paradesc {

// ---- The caller's images

static void check_image(const Triangles &triangles, const char *name, int32_t width, int32_t height) {
  if (triangles.input_uv.empty())
    throw Error(PDESC_ERROR_INVALID_OPERATION,
                std::string("The mesh has no UV map, by which the ") + name + " would be looked up; unwrap it first.");
  constexpr int32_t largest = 32768;
  if (width < 1 || height < 1 || width > largest || height > largest)
    throw Error(PDESC_ERROR_INVALID_ARGUMENT, std::string("The ") + name + " is an image of " + std::to_string(width) + " x " +
                                                  std::to_string(height) + " pixels; give one of 1 to " +
                                                  std::to_string(largest) + " a side.");
}

static void check_finite(const float *values, size_t count, size_t channels, const char *name, const char *of) {
  for (size_t i = 0; i < count; ++i)
    if (!std::isfinite(values[i]))
      throw Error(PDESC_ERROR_INVALID_ARGUMENT, std::string("The ") + name + " has a value that is not finite at " + of + " " +
                                                    std::to_string(i / channels) + "; give finite values.");
}

void set_displacement(SurfaceMaps &maps, const Triangles &triangles, const float *heights, int32_t width, int32_t height,
                      double midlevel, double scale) {
  if (heights) {
    check_image(triangles, "displacement", width, height);
    const size_t count = static_cast<size_t>(width) * static_cast<size_t>(height);
    check_finite(heights, count, 1, "displacement", "pixel");
    constexpr double largest = std::numeric_limits<float>::max();
    if (!(std::abs(midlevel) <= largest) || !(std::abs(scale) <= largest))
      throw Error(PDESC_ERROR_INVALID_ARGUMENT, "The midlevel is " + shown(midlevel) + " and the scale " + shown(scale) +
                                                    "; both must be finite in single precision.");
    maps.displacement = Displacement{
        {width, height, std::vector<float>(heights, heights + count)}, static_cast<float>(midlevel), static_cast<float>(scale)};
  } else {
    maps.displacement.reset();
  }
  ++maps.version;
}

void set_normal_map(SurfaceMaps &maps, const Triangles &triangles, const float *rgb, int32_t width, int32_t height,
                    const float *corner_tangents, int32_t corner_count) {
  if (rgb) {
    check_image(triangles, "normal map", width, height);
    if (!corner_tangents)
      throw Error(PDESC_ERROR_INVALID_ARGUMENT,
                  "corner_tangents is NULL; give four floats for each corner with a normal map: the tangent and its sign.");
    if (corner_count != triangles.corner_count)
      throw Error(PDESC_ERROR_INVALID_ARGUMENT, "Tangents of " + std::to_string(corner_count) +
                                                    " corners were given; the mesh has " +
                                                    std::to_string(triangles.corner_count) + ".");
    const size_t count = static_cast<size_t>(width) * static_cast<size_t>(height);
    check_finite(rgb, 3 * count, 3, "normal map", "pixel");
    check_finite(corner_tangents, 4 * static_cast<size_t>(corner_count), 4, "list of tangents", "corner");
    NormalMap map{{width, height, std::vector<vec4>(count)}, {}};
    for (size_t i = 0; i < count; ++i) map.colors.pixels[i] = vec4(rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2], 0.0f);
    for (const int32_t corner : triangles.input_corner) {
      const float *tangent = corner_tangents + 4 * static_cast<ptrdiff_t>(corner);
      map.corner_tangent.emplace_back(tangent[0], tangent[1], tangent[2], tangent[3] < 0.0f ? -1.0f : 1.0f);
    }
    maps.normal_map = std::move(map);
  } else {
    maps.normal_map.reset();
  }
  ++maps.version;
}

// ---- Single positions

template <class Pixel> static Pixel look_up(const Image<Pixel> &image, vec2 uv) {
  const vec2 size(image.width, image.height);
  const vec2 position = (uv - glm::floor(uv)) * size - 0.5f, low = glm::floor(position), t = position - low;
  auto row = [&](int y) {
    const auto first = static_cast<size_t>((y + image.height) % image.height) * static_cast<size_t>(image.width);
    auto pixel = [&](int x) { return image.pixels[first + static_cast<size_t>((x + image.width) % image.width)]; };
    const auto x = static_cast<int>(low.x);
    return pixel(x) * (1.0f - t.x) + pixel(x + 1) * t.x;
  };
  const auto y = static_cast<int>(low.y);
  return row(y) * (1.0f - t.y) + row(y + 1) * t.y;
}

// The height above midlevel and its gradient by (u, v), in the image's own units.
static vec3 look_up_height(const Displacement &map, vec2 uv) {
  const vec2 step = 1.0f / vec2(map.heights.width, map.heights.height);
  auto height = [&](float x, float y) { return look_up(map.heights, uv + vec2(x, y) * step); };
  return vec3(height(0, 0) - map.midlevel, 0.5f * (height(1, 0) - height(-1, 0)) / step.x,
              0.5f * (height(0, 1) - height(0, -1)) / step.y);
}

namespace {

// The formulas, which are compiled into shaders as well.
struct Text {
#include "kernel/displace.glsl"
};

// A triangle as the maps see it: the values of corner 0, and the differences of corners 1 and 2 from these.
struct Patch {
  vec3 position, edge1, edge2;
  vec3 normal, turn1, turn2;
  vec2 uv, way1, way2;
};

// A surface point, and the two edges of its triangle after displacement.
struct MovedPoint {
  SurfacePoint point;
  vec3 edge1, edge2;
};

} // namespace

static Patch patch_of(const Triangles &triangles, const Normals &normals, const BakeSpace &bake_space, int triangle) {
  const SharedArray<vec2> &uvs = triangles.input_uv;
  const auto c = static_cast<size_t>(3 * triangle);
  auto position = [&](size_t i) { return bake_space.to_buffer(triangles.positions[triangles.corner_vertex[i]]); };
  const vec3 p = position(c), n = normals.corner(c);
  return {p,      position(c + 1) - p, position(c + 2) - p, n, normals.corner(c + 1) - n, normals.corner(c + 2) - n,
          uvs[c], uvs[c + 1] - uvs[c], uvs[c + 2] - uvs[c]};
}

static MovedPoint displace(const Patch &patch, const Displacement *map, float scale, float a, float b) {
  const vec3 raw = patch.normal + patch.turn1 * a + patch.turn2 * b;
  const float span = length(raw);
  const vec3 n = span > 0.0f ? raw / span : patch.normal;
  MovedPoint result{{patch.position + patch.edge1 * a + patch.edge2 * b, n, 1.0f}, patch.edge1, patch.edge2};
  if (!map || !(span > 0.0f)) return result;
  const vec3 height = look_up_height(*map, patch.uv + patch.way1 * a + patch.way2 * b) * (map->scale * scale);
  Text text;
  const Text::Displaced moved =
      text.displace(patch.edge1, patch.edge2, text.change_of_edge(patch.turn1, patch.way1, n, span, height),
                    text.change_of_edge(patch.turn2, patch.way2, n, span, height), n);
  result.edge1 = moved.edge1;
  result.edge2 = moved.edge2;
  result.point.position += n * height.x;
  result.point.normal = moved.normal;
  result.point.area_ratio = moved.area_ratio;
  return result;
}

vec3 frame_normal(const Triangles &triangles, const Normals &normals, size_t corner) {
  return triangles.corner_normal.empty() ? normals.corner(corner) : triangles.corner_normal[corner];
}

static vec3 normal_of_map(const NormalMap &map, const Triangles &triangles, const Normals &normals, int triangle, float a,
                          float b, vec3 otherwise) {
  const auto c = static_cast<size_t>(3 * triangle);
  const SharedArray<vec2> &uvs = triangles.input_uv;
  const float rest = 1.0f - a - b;
  const vec3 n = frame_normal(triangles, normals, c) * rest + frame_normal(triangles, normals, c + 1) * a +
                 frame_normal(triangles, normals, c + 2) * b;
  const vec4 tangent = map.corner_tangent[c] * rest + map.corner_tangent[c + 1] * a + map.corner_tangent[c + 2] * b;
  const vec3 bitangent = map.corner_tangent[c].w * cross(n, vec3(tangent));
  const vec4 color = look_up(map.colors, uvs[c] * rest + uvs[c + 1] * a + uvs[c + 2] * b) * 2.0f - 1.0f;
  return Text().unit_or(vec3(tangent) * color.x + bitangent * color.y + n * color.z, otherwise);
}

SurfacePoint DisplacedSurface::at(int triangle, float a, float b) const {
  const Displacement *map = maps_.displacement ? &*maps_.displacement : nullptr;
  const auto scale = static_cast<float>(bake_space_.scale);
  SurfacePoint point = displace(patch_of(triangles_, normals_, bake_space_, triangle), map, scale, a, b).point;
  if (maps_.normal_map) point.normal = normal_of_map(*maps_.normal_map, triangles_, normals_, triangle, a, b, point.normal);
  return point;
}

// The largest factor by which lengths in the plane of the edges shrink: the inverse root of the smaller eigenvalue of the second
// metric relative to the first. Its 99th percentile is the paper's maximum expected distortion (section 3.4).
static float shrinkage_of(vec3 a1, vec3 a2, vec3 b1, vec3 b2) {
  const dvec3 before(dot(a1, a1), dot(a1, a2), dot(a2, a2)), after(dot(b1, b1), dot(b1, b2), dot(b2, b2));
  const double determinant = before.x * before.z - before.y * before.y;
  if (!(determinant > 1e-6 * before.x * before.z)) return 1.0f; // a sliver says nothing about the surface
  const double trace = (before.z * after.x - 2.0 * before.y * after.y + before.x * after.z) / determinant;
  const double product = (after.x * after.z - after.y * after.y) / determinant;
  const double smaller = 0.5 * (trace - std::sqrt(std::max(trace * trace - 4.0 * product, 0.0)));
  if (std::isnan(smaller)) return 1.0f; // squared lengths overflow a float
  return static_cast<float>(1.0 / std::sqrt(std::max(smaller, 1.0 / 16.0)));
}

SurfacePoint DisplacedSurface::at_corner(int corner, vec3 normal, float &shrinkage) const {
  const int triangle = corner / 3, index = corner % 3;
  const float a = index == 1 ? 1.0f : 0.0f, b = index == 2 ? 1.0f : 0.0f;
  const Displacement *map = maps_.displacement ? &*maps_.displacement : nullptr;
  Patch patch = patch_of(triangles_, normals_, bake_space_, triangle);
  const vec3 change = normal - normals_.corner(static_cast<size_t>(corner));
  if (index == 0) {
    patch.normal += change;
    patch.turn1 -= change;
    patch.turn2 -= change;
  } else {
    (index == 1 ? patch.turn1 : patch.turn2) += change;
  }
  const MovedPoint displaced = displace(patch, map, static_cast<float>(bake_space_.scale), a, b);
  shrinkage = shrinkage_of(patch.edge1, patch.edge2, displaced.edge1, displaced.edge2);
  SurfacePoint point = displaced.point;
  if (maps_.normal_map) point.normal = normal_of_map(*maps_.normal_map, triangles_, normals_, triangle, a, b, point.normal);
  return point;
}

// ---- Points

// The 99th percentile instead of the maximum, which creases and slivers of real meshes make arbitrarily large.
static float percentile_99(std::vector<float> &shrinkage) {
  const auto percentile = shrinkage.begin() + static_cast<ptrdiff_t>(shrinkage.size() * 99 / 100);
  std::nth_element(shrinkage.begin(), percentile, shrinkage.end());
  return std::clamp(*percentile, 1.0f, 4.0f);
}

DisplacedPoints displace_points(const SurfaceMaps &maps, const Triangles &triangles, const HalfEdges &half_edges,
                                const Normals &normals, const BakeSpace &bake_space, int threads) {
  const DisplacedSurface surface(maps, triangles, normals, bake_space);
  const auto corners = static_cast<size_t>(3 * triangles.triangle_count);
  std::vector<SurfacePoint> displaced(corners);
  std::vector<float> shrinkage(corners, 1.0f);
  parallel_blocks(triangles.triangle_count, threads, 1024, [&](int begin, int end) {
    for (int corner = 3 * begin; corner < 3 * end; ++corner) {
      const auto c = static_cast<size_t>(corner);
      if (half_edges.corner_point[c] < 0) continue;
      displaced[c] = surface.at_corner(corner, normals.point[half_edges.corner_point[c]], shrinkage[c]);
    }
  });
  const auto points = static_cast<size_t>(half_edges.point_count);
  DisplacedPoints result;
  std::vector<vec3> offset(points, vec3(0.0f)), sum(points, vec3(0.0f));
  std::vector<float> weight(points, 0.0f);
  auto base = [&](size_t point) { return bake_space.to_buffer(triangles.positions[half_edges.point_vertex[point]]); };
  for (size_t c = 0; c < corners; ++c) {
    checkpoint_at(c);
    if (half_edges.corner_point[c] < 0) continue;
    const auto point = static_cast<size_t>(half_edges.corner_point[c]);
    const auto angle = static_cast<float>(surface_angle(triangles, static_cast<int>(c)));
    offset[point] += angle * (displaced[c].position - base(point));
    sum[point] += angle * displaced[c].normal;
    weight[point] += angle;
  }
  for (size_t point = 0; point < points; ++point) {
    checkpoint_at(point);
    result.position.push_back(base(point) + offset[point] / std::max(weight[point], 1e-20f));
    result.normal.push_back(Text().unit_or(sum[point], normals.point[point]));
  }
  result.shrinkage = percentile_99(shrinkage);
  return result;
}

} // namespace paradesc
