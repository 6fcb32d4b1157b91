// The Laplace-Beltrami operator of f: the trace of the least-squares quadratic's Hessian.
#include "kernel/terms/jet.glsl"
struct State { JetTerms terms; };
void descriptor_init(out State state) { jet_init(state.terms); }
void descriptor_add(inout State state, Center center, Neighbor neighbor) { jet_add(state.terms, neighbor); }
float descriptor_finish(State state, Center center, Support support) {
  vec3 quadratic = jet_finish(state.terms).quadratic;
  return 2.0 * (quadratic.x + quadratic.z) / (support.radius * support.radius);
}
