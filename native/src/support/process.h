// The number of this process: one that was forked from another has another, and none of its threads.
#pragma once

namespace paradesc {

long this_process(); // 0 on systems that do not fork

} // namespace paradesc
