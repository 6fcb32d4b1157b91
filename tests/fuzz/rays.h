// Bytes → rays against a surface, and values at what they meet.
#pragma once

#include "bytes.h"

namespace paradesc::fuzz {

// A few triangles and rays of any coordinates.
void cast_rays(Bytes &bytes);

} // namespace paradesc::fuzz
