// EA (paper eq. 13, 14): the area of the surface within the neighborhood.
#include "kernel/terms/area.glsl"
struct State { AreaTerms terms; };
void descriptor_init(out State state) { area_init(state.terms); }
void descriptor_add(inout State state, Center center, Neighbor neighbor) { area_add(state.terms, center, neighbor); }
float descriptor_finish(State state, Center center, Support support) {
  return area_finish(state.terms, support.area / support.scale, support);
}
