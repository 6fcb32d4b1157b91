// A mesh and options → the engine that computes them: under AUTO the processor, or the software device where only that can.
#pragma once

#include <string>

#include "compute/mesh.h"

namespace paradesc {

// What of a computation belongs to texture space alone, for a sentence: "half floats and seam errors"; "" if nothing does.
std::string texture_space_needs(const pdesc_options &options);

// The backend that computes with these options; no device is opened for it.
int32_t backend_for(const Context &context, const pdesc_options &options);

// Gives the mesh the engine, with a session, that computes. Throws Error(UNSUPPORTED) where there is none.
void take_engine(Mesh &mesh, const pdesc_options &options);

// Throws Error for what the mesh's engine cannot do.
void refuse_beyond_abilities(const Mesh &mesh, const pdesc_options &options);

} // namespace paradesc
