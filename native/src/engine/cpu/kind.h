// Defines one kernel of engine/cpu/kinds.h. KERNEL is its name, and the features that it needs are defined as 1.
#ifndef SURFACE
#define SURFACE 0
#endif
#ifndef JET
#define JET 0
#endif
#ifndef WINDOWS
#define WINDOWS 0
#endif
#ifndef INTEGRAL
#define INTEGRAL 0
#endif
#ifndef EXTRAPOLATED
#define EXTRAPOLATED 0
#endif
#ifndef GEODESIC_BALL
#define GEODESIC_BALL 0
#endif
#define WIDE_NEIGHBORS // The caller of add_weighted() supplies the means.
#define FACES 0
#define VARIATE 0 // Triangles and clusters leave next to no noise.
#define MAP (JET || WINDOWS)
#define TERMS_AREA SURFACE
#define TERMS_BALL SURFACE
#define TERMS_BENDING SURFACE
#define TERMS_JET JET
#define TERMS_GAUSSIANS WINDOWS
#define TERMS_TENSOR WINDOWS
#include "engine/kernels/kernels.h"
#undef KERNEL
#undef SURFACE
#undef JET
#undef WINDOWS
#undef INTEGRAL
#undef EXTRAPOLATED
#undef GEODESIC_BALL
#undef WIDE_NEIGHBORS
#undef FACES
#undef VARIATE
#undef MAP
