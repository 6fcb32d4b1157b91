// The map from the caller's units to those of the buffers: subtract a center, multiply by a scale.
layout(std140, binding = BLOCK_SPACE) uniform Space { dvec4 center_and_scale; };
