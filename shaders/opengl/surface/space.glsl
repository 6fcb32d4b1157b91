// From the units that the mesh was given in to those of the buffers: less a center, times a scale.
layout(std140, binding = BLOCK_SPACE) uniform Space { dvec4 center_and_scale; };
