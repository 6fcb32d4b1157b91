// The angle of a direction, with the same bits on every system: the last bits of atan2 depend on the C library.
#pragma once

namespace paradesc {

// The angle in (-pi, pi] from the x axis towards the y axis, to some 1e-15; 0 for the zero vector.
double angle_of(double y, double x);

} // namespace paradesc
