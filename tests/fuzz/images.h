// Bytes → images over a UV map, and gutters of images.
#pragma once

#include "bytes.h"

namespace paradesc::fuzz {

// Values on triangles of any coordinates, drawn and given a gutter.
void draw_image(Bytes &bytes);

// An image with a few texels of any value.
void fill_gutter(Bytes &bytes);

} // namespace paradesc::fuzz
