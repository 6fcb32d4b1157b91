// Defines a kernel for every kind of sum. add_samples.cpp compiles them for lanes, and finish.cpp for floats.
//
// There is no include guard: each file includes this one under its own KERNEL_TARGET.
#define KERNEL FitKernel // shape operator only
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

// These add the same sums as SurfaceKernel and SurfaceGeodesicKernel, but curvatures follow from the integral invariants.
#define KERNEL IntegralKernel
#define SURFACE 1
#define INTEGRAL 1
#include "engine/cpu/kind.h"

#define KERNEL IntegralGeodesicKernel
#define SURFACE 1
#define INTEGRAL 1
#define GEODESIC_BALL 1
#include "engine/cpu/kind.h"
