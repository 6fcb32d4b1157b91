// |grad f|, of the least-squares quadratic.
#include "kernel/terms/jet.glsl"
struct State { JetTerms terms; };
void descriptor_init(out State state) { jet_init(state.terms); }
void descriptor_add(inout State state, Center center, Neighbor neighbor) { jet_add(state.terms, neighbor); }
float descriptor_finish(State state, Center center, Support support) {
  return length(jet_finish(state.terms).plane.yz) / support.radius;
}
