// Moments of triangles, and the triangle that has the moments of a cluster.
#include "engine/cpu/pieces.h"

#include <algorithm>
#include <cmath>

#include "engine/cpu/nine_places.h"

namespace paradesc {

// In the coordinates (a, b), the corners are at (-2 sqrt(2), 0) and (sqrt(2), +-sqrt(6)).
Sample sample_of_triangle(const vec3 *corners, const vec3 *normals) {
  const vec3 edge = corners[1] - corners[0], other = corners[2] - corners[0], plane = cross(edge, other);
  Sample sample;
  sample.position = corners[0] + (edge + other) * (1.0f / 3.0f);
  sample.along[0] = (edge + other) * 0.11785113f; // 1 / (6 sqrt(2))
  sample.along[1] = (edge - other) * 0.20412415f; // 1 / (2 sqrt(6))
  const float twice_area = length(plane);
  sample.area = 0.5f * twice_area;
  if (twice_area > 0.0f) sample.face = plane / twice_area;
  for (const auto &[weight, twelfths] : nine_places) {
    const vec3 n = twelfths * unit_or(weight[0] * normals[0] + weight[1] * normals[1] + weight[2] * normals[2], normals[0]);
    sample.normal += n;
    sample.normal_along[0] += (weight[1] + weight[2] - 2.0f * weight[0]) * n;
    sample.normal_along[1] += (weight[1] - weight[2]) * n;
  }
  sample.normal /= 12.0f; // equal normals keep their length
  sample.normal_along[0] *= 0.11785113f;
  sample.normal_along[1] *= 0.20412415f;
  return sample;
}

void ClusterSums::add(const Sample &triangle) {
  const vec3 gap = triangle.position - origin_;
  mat3 variance = glm::outerProduct(gap, gap), normal_variance = glm::outerProduct(triangle.normal, gap);
  for (int k = 0; k < 2; ++k) {
    variance += glm::outerProduct(triangle.along[k], triangle.along[k]);
    normal_variance += glm::outerProduct(triangle.normal_along[k], triangle.along[k]);
  }
  sums_.area += triangle.area;
  sums_.position += triangle.area * gap;
  sums_.normal += triangle.area * triangle.normal;
  sums_.face += triangle.area * triangle.face;
  sums_.noise += triangle.area * triangle.noise;
  sums_.facet += triangle.area * triangle.area;
  sums_.variance += triangle.area * variance;
  sums_.normal_variance += triangle.area * normal_variance;
}

Cluster ClusterSums::cluster() const {
  Cluster whole = sums_;
  const float share = sums_.area > 0.0f ? 1.0f / sums_.area : 0.0f;
  const vec3 gap = sums_.position * share;
  whole.position = origin_ + gap;
  whole.normal *= share;
  whole.face *= share;
  whole.noise *= share;
  whole.facet *= share;
  whole.variance = sums_.variance * share - glm::outerProduct(gap, gap);
  whole.normal_variance = sums_.normal_variance * share - glm::outerProduct(whole.normal, gap);
  return whole;
}

// Chooses two directions in the plane of the mean face: the first captures all variation along it, the second the remaining
// variation.
Sample sample_of(const Cluster &cluster) {
  Sample sample;
  sample.position = cluster.position;
  sample.normal = cluster.normal;
  sample.face = cluster.face;
  sample.area = cluster.area;
  sample.noise = cluster.noise;
  sample.facet = cluster.facet;
  const vec3 n = unit_or(cluster.face, vec3(0.0f, 0.0f, 1.0f));
  const vec3 first = tangent_of(n), second = cross(n, first);
  const vec3 of_first = cluster.variance * first;
  const float xx = dot(first, of_first), xy = dot(second, of_first);
  if (!(xx > 0.0f)) return sample;
  const float a = std::sqrt(xx), b = xy / a, rest = dot(second, cluster.variance * second) - b * b;
  sample.along[0] = a * first + b * second;
  sample.normal_along[0] = cluster.normal_variance * first / a;
  if (!(rest > 1e-6f * xx)) return sample;
  const float c = std::sqrt(rest);
  sample.along[1] = c * second;
  sample.normal_along[1] = (cluster.normal_variance * second - (b / a) * (cluster.normal_variance * first)) / c;
  return sample;
}

} // namespace paradesc
