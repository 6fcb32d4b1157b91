// A pattern over the enlarged ellipse (paper 3.4, 4.1), each sample carried over the seams by itself.
void sample_neighborhood(inout Sums sums, Place place) {
  int i = params.begin_sample;
  for (; i < params.end_sample; ++i) {
    PatternPlace goal = pattern_place(sample_number(i), place.rotation, place.index);
    March march = march_to(place, goal);
    if (march.outcome == FOUND)
      add_sample(sums, place, goal, march.to, march.chart, area_factor(march));
    else if (march.outcome == LOST && goal.inside)
      sums.moments.missing_area += place.area_space * goal.stretch * goal.stretch;
    else if (hits_boundary(march, sums.center))
      sums.moments.hits_boundary += 1.0;
  }
  miss_rest(sums, params.end_sample - i, params.samples);
}
