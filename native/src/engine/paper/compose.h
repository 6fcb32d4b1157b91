// Requested descriptors → GLSL that composes their kernels into one program.
#pragma once

#include <span>
#include <string>

namespace paradesc {

// terms.glsl: the sums that these descriptors need, each of them once. integral: includes those of the curvatures.
std::string compose_terms(std::span<const int> descriptors, bool integral);

// descriptors.glsl: how descriptors follow from sums. STORE_DESCRIPTORS is for main(): the results buffer is declared later.
std::string compose_descriptors(std::span<const int> descriptors);

} // namespace paradesc
