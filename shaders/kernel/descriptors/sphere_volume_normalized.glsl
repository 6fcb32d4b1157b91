// V_r/(4 pi r^3/3), paper eq. (7): 0.5 on a plane.
#include "kernel/terms/ball.glsl"
struct State { BallTerms terms; };
void descriptor_init(out State state) { ball_init(state.terms); }
void descriptor_add(inout State state, Center center, Neighbor neighbor) { ball_add(state.terms, center, neighbor); }
float descriptor_finish(State state, Center center, Support support) { return ball_share(state.terms, support); }
