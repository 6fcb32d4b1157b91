// Limits of the descriptors' definitions, the same in C++ and in GLSL.
#ifndef PARADESC_DESCRIPTOR_LIMITS_H
#define PARADESC_DESCRIPTOR_LIMITS_H

// A surface with both |k| r below this is a plane: it has no shape index.
#define PLANE_THRESHOLD 1e-4

// Vectors are turned from one tangent plane into another by at most about 170 degrees: less than this of 1 + cos is not divided
// by.
#define LEAST_TURN 0.015

// Gaussian windows end at this many sigma.
#define WINDOW_RADIUS 2.0

// The narrower window of a difference of Gaussians has sigma over this.
#define GAUSSIANS_RATIO 1.6

// Least determinants, per area and in units of r, of what determines a quadratic: 1/16 and 1/6912 on a full disk, some 1/200 and
// 1e-8 on a quarter.
#define JET_LEAST_PLANE 1e-4
#define JET_LEAST_QUADRATIC 1e-10

// Curvature goes over to that of the solid from where a crease comes nearer than this many radii, and is there where it meets the
// ball.
#define CREASE_REACH 1.25

// By how much normals blur neighborhoods, fitted ones and means of faces alike, in areas of a vertex; and the share of the noise of
// heights that counts, since fits go through a noisy vertex themselves. Both by noise of 0.02 to 0.3 edges in balls of 2 to 12 % of tori
// and ellipsoids.
#define BLUR_OF_NORMALS 3.0
#define NOISE_SHARE 0.3

#endif
