// GA (paper eq. 11 to 14): the area of the surface within r along it.
#include "kernel/terms/area.glsl"
struct State { AreaTerms terms; };
void descriptor_init(out State state) { area_init(state.terms); }
void descriptor_add(inout State state, Center center, Neighbor neighbor) { area_add(state.terms, center, neighbor); }
float descriptor_finish(State state, Center center, Support support) {
  return support.area > 0.0 ? area_finish(state.terms, state.terms.inside, support) : NOT_A_NUMBER;
}
