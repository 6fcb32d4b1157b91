// What one dispatch over centers is told.
#include "shared.h"
layout(std140, binding = BLOCK_EVALUATE) uniform Evaluate { EvaluateParams params; };
