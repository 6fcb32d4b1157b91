// A mesh and options → the engine that computes them: under AUTO the processor, or the software device if only that one can.
#pragma once

#include <string>

#include "compute/mesh.h"

namespace paradesc {

// Lists the requested options that only texture space supports, for a sentence: "half floats and baked buffers"; "" if there are
// none.
std::string texture_space_needs(const pdesc_options &options);

// The backend that computes with these options. Opens no device.
int32_t backend_for(const Context &context, const pdesc_options &options);

// Gives the mesh the engine that computes, and a session. Throws Error(UNSUPPORTED) if there is none.
void take_engine(Mesh &mesh, const pdesc_options &options);

// Throws Error for requests beyond the abilities of the mesh's engine.
void refuse_beyond_abilities(const Mesh &mesh, const pdesc_options &options);

} // namespace paradesc
