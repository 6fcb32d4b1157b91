// Baked buffers → values in units of the positions (paper Fig. 1).
#include <cmath>
#include <limits>

#include "engine/paper/texture_space.h"

namespace paradesc {

static constexpr float nan = std::numeric_limits<float>::quiet_NaN();

// Positions or normals of texels; none outside of charts.
static ReadBuffer vectors(const std::vector<vec4> &texels, const std::vector<int32_t> &ids, dvec3 center, double scale) {
  ReadBuffer read{0, 3, {}};
  for (size_t i = 0; i < texels.size(); ++i)
    for (int k = 0; k < 3; ++k)
      read.values.push_back(ids[2 * i] < 0 ? nan : static_cast<float>(static_cast<double>(texels[i][k]) / scale + center[k]));
  return read;
}

// sigma_u, sigma_v in units of the positions per u or v, theta_e, area element.
static ReadBuffer distortions(const std::vector<vec4> &texels, const std::vector<int32_t> &ids, float scale) {
  ReadBuffer read{0, 4, {}};
  for (size_t i = 0; i < texels.size(); ++i) {
    const vec4 value = texels[i] / vec4(scale, scale, 1.0f, scale * scale);
    for (int k = 0; k < 4; ++k) read.values.push_back(ids[2 * i] < 0 ? nan : value[k]);
  }
  return read;
}

static ReadBuffer chart_numbers(const std::vector<int32_t> &ids) {
  ReadBuffer read;
  for (size_t i = 0; i < ids.size(); i += 2) read.values.push_back(static_cast<float>(ids[i]));
  return read;
}

// The chart behind the first seam of the texel's own chart that runs through the texel.
static ReadBuffer neighbor_charts(const std::vector<int32_t> &ids, const BorderGrid &grid, const Charts &charts) {
  ReadBuffer read;
  for (size_t i = 0; i < ids.size() / 2; ++i) {
    float found = -1.0f;
    const int32_t edges = -std::min(grid.cells[2 * i], 0), first = grid.cells[2 * i + 1];
    for (int32_t k = first; found < 0.0f && k < first + edges; ++k) {
      const Border &border = charts.borders[grid.list[2 * static_cast<size_t>(k)]];
      if (border.chart == ids[2 * i] && border.kind == BorderKind::seam && border.twin >= 0)
        found = static_cast<float>(charts.borders[border.twin].chart);
    }
    read.values.push_back(found);
  }
  return read;
}

ReadBuffer TextureSpace::read_buffer(const std::string &name, const Atlas &atlas) {
  if (!baked_.key() || baked_.key()->layout.atlas.atlas != atlas.version) return {};
  const BorderGrid *grid = grid_.find(baked_.key()->layout.atlas);
  if (!grid) return {}; // a computation with other buffers ended before it baked them
  const BakeSpace &space = baked_.value();
  const GeometryBuffer &buffer = *device_->buffer;
  ReadBuffer read;
  gl_->run([&](const Gl &, ProgramCache &programs) {
    const std::vector<int32_t> ids = buffer.read_ids();
    if (name == "position")
      read = vectors(buffer.read_position(), ids, space.center, space.scale);
    else if (name == "normal")
      read = vectors(buffer.read_normal(), ids, dvec3(0.0), 1.0);
    else if (name == "distortion")
      read = distortions(buffer.read_distortion(programs), ids, static_cast<float>(space.scale));
    else if (name == "chart")
      read = chart_numbers(ids);
    else if (name == "neighbor")
      read = neighbor_charts(ids, *grid, atlas.charts);
    else
      throw Error(PDESC_ERROR_INVALID_ARGUMENT,
                  "There is no buffer '" + name + "'; choose position, normal, chart, neighbor or distortion.");
  });
  read.size = buffer.size();
  return read;
}

} // namespace paradesc
