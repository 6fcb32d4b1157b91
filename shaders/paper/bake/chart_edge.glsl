// A chart-edge line, read from a texture because the stages that draw may not have storage buffers.
#include "shared.h"
layout(binding = UNIT_EDGES) uniform isamplerBuffer edges;
layout(location = LOCATION_BUFFER_SIZE) uniform int buffer_size;

EdgeData edge_at(int edge) { return EdgeData(intBitsToFloat(texelFetch(edges, 2 * edge)), texelFetch(edges, 2 * edge + 1)); }
