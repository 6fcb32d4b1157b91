// The number of this process. A forked process has a different number, and none of the original's threads.
#pragma once

namespace paradesc {

long this_process(); // 0 on systems that do not fork

} // namespace paradesc
