// Limits of the descriptors' definitions, the same in C++ and in GLSL.
#ifndef PARADESC_DESCRIPTOR_LIMITS_H
#define PARADESC_DESCRIPTOR_LIMITS_H

// A surface with both |k| r below this is a plane: it has no shape index.
#define PLANE_THRESHOLD 1e-4

#endif
