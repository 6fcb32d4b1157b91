// The unit tangent along which the shape operator bends by k2. A direction has two signs: the largest component is positive.
DESCRIPTOR_WITHOUT_STATE
vec3 descriptor_finish(State state, Center center, Support support) { return positive_direction(support.directions[1]); }
