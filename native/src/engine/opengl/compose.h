// Descriptors asked for → GLSL that composes their kernels into one program.
#pragma once

#include <span>
#include <string>

namespace paradesc {

// terms.glsl: what is added up for these descriptors, each of it once. integral: for the curvatures as well.
std::string compose_terms(std::span<const int> descriptors, bool integral);

// descriptors.glsl: how they finish. STORE_DESCRIPTORS is for main(): the results buffer is declared after this text.
std::string compose_descriptors(std::span<const int> descriptors);

} // namespace paradesc
