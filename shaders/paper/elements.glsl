// A dispatch over elements [first, last) of a list, one per invocation.
#include "device.glsl"
#include "shared.h"
layout(local_size_x = GROUP_SIZE) in;
layout(location = LOCATION_FIRST) uniform int first;
layout(location = LOCATION_LAST) uniform int last;

int own_element() { return first + int(gl_GlobalInvocationID.x); }
