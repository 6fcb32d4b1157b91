// The instruction sets for which some files are compiled, each under its own name for KERNEL_TARGET: engine/cpu/add_samples and
// ball_sums, engine/creases/face_sums, mesh/jets (CMakeLists.txt).
#pragma once

namespace paradesc {

enum class Instructions { baseline, avx2, avx512 };

// The widest set that this processor has.
Instructions widest_instructions();

} // namespace paradesc
