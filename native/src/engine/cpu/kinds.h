// Every kind of sum as a kernel: add_samples.cpp compiles them for lanes, finish.cpp for floats.
//
// No include guard: each file includes it under its own KERNEL_TARGET.
#define KERNEL FitKernel // the shape operator alone
#include "engine/cpu/kind.h"

#define KERNEL SurfaceKernel
#define SURFACE 1
#include "engine/cpu/kind.h"

#define KERNEL SurfaceGeodesicKernel
#define SURFACE 1
#define GEODESIC_BALL 1
#include "engine/cpu/kind.h"

#define KERNEL ExtrapolatedKernel
#define SURFACE 1
#define EXTRAPOLATED 1
#include "engine/cpu/kind.h"

#define KERNEL ExtrapolatedGeodesicKernel
#define SURFACE 1
#define EXTRAPOLATED 1
#define GEODESIC_BALL 1
#include "engine/cpu/kind.h"

#define KERNEL JetKernel
#define JET 1
#include "engine/cpu/kind.h"

#define KERNEL JetGeodesicKernel
#define JET 1
#define GEODESIC_BALL 1
#include "engine/cpu/kind.h"

#define KERNEL WindowsKernel
#define WINDOWS 1
#include "engine/cpu/kind.h"

#define KERNEL WindowsGeodesicKernel
#define WINDOWS 1
#define GEODESIC_BALL 1
#include "engine/cpu/kind.h"

// These add up what SurfaceKernel and SurfaceGeodesicKernel do, and finish by the integrals.
#define KERNEL IntegralKernel
#define SURFACE 1
#define INTEGRAL 1
#include "engine/cpu/kind.h"

#define KERNEL IntegralGeodesicKernel
#define SURFACE 1
#define INTEGRAL 1
#define GEODESIC_BALL 1
#include "engine/cpu/kind.h"
