// Limits of the descriptors' definitions, the same in C++ and in GLSL.
#ifndef PARADESC_DESCRIPTOR_LIMITS_H
#define PARADESC_DESCRIPTOR_LIMITS_H

// A surface with both |k| r below this is a plane: it has no shape index.
#define PLANE_THRESHOLD 1e-4

// Vectors are turned between tangent planes by at most about 170 degrees: divisors 1 + cos are at least this.
#define LEAST_TURN 0.015

// Gaussian windows end at this many sigma.
#define WINDOW_RADIUS 2.0

// The narrower window of a difference of Gaussians has sigma over this.
#define GAUSSIANS_RATIO 1.6

// Least determinants, per area and in units of r, for which samples determine a quadratic: a full disk has 1/16 and 1/6912, a
// quarter about 1/200 and 1e-8.
#define JET_LEAST_PLANE 1e-4
#define JET_LEAST_QUADRATIC 1e-10

// The control variate fades out where the second moments of a neighborhood deviate from a flat disk's by more than this share.
#define DISK_DEVIATION 0.1

// Curvature passes over to that of the solid as a crease comes nearer than this many radii, and is the solid's once the crease
// meets the ball.
#define CREASE_REACH 1.25

// The area, in areas of a vertex, by which normals blur neighborhoods, for fitted normals and means of faces alike; and the share
// of the noise of heights that counts, since fits follow a noisy vertex. Both were measured with noise of 0.02 to 0.3 edges in
// balls of 2 to 12 % of tori and ellipsoids.
#define BLUR_OF_NORMALS 3.0
#define NOISE_SHARE 0.3

#endif
