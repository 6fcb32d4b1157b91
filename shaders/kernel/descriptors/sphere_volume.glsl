// V_r, paper eq. (6, 7): the part of the ball that lies inside the surface.
#include "kernel/terms/ball.glsl"
struct State { BallTerms terms; };
void descriptor_init(out State state) { ball_init(state.terms); }
void descriptor_add(inout State state, Center center, Neighbor neighbor) { ball_add(state.terms, center, neighbor); }
float descriptor_finish(State state, Center center, Support support) {
  float radius = support.radius;
  return ball_share(state.terms, support) * 4.0 / 3.0 * PI * radius * radius * radius;
}
