// The parameters of one dispatch over centers.
#include "shared.h"
layout(std140, binding = BLOCK_EVALUATE) uniform Evaluate { EvaluateParams params; };
