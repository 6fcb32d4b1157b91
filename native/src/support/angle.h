// The angle of a direction, with the same bits on every system: the C library's atan2 differs from one to the next in its last
// bits.
#pragma once

namespace paradesc {

// In (-pi, pi], from the axis of x to that of y, to some 1e-15; 0 where there is no direction.
double angle_of(double y, double x);

} // namespace paradesc
