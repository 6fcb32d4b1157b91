// grad f as a vector in object space, of the least-squares quadratic: what operators on gradients read as a map.
#include "kernel/terms/jet.glsl"
struct State { JetTerms terms; };
void descriptor_init(out State state) { jet_init(state.terms); }
void descriptor_add(inout State state, Center center, Neighbor neighbor) { jet_add(state.terms, neighbor); }
vec3 descriptor_finish(State state, Center center, Support support) {
  return center.tangents * jet_finish(state.terms).plane.yz / support.radius;
}
