// A pattern over the enlarged ellipse (paper 3.4, 4.1); each sample is carried across the seams by itself.
void sample_neighborhood(inout Sums sums, SamplingEllipse ellipse) {
  int i = params.begin_sample;
  for (; i < params.end_sample; ++i) {
    PatternSample goal = pattern_sample(sample_number(i), ellipse.rotation, ellipse.index);
    March march = march_to(ellipse, goal);
    if (march.outcome == FOUND)
      add_sample(sums, ellipse, goal, march.to, march.chart, area_factor(march));
    else if (march.outcome == LOST && goal.inside)
      sums.moments.missing_area += ellipse.area_space * goal.stretch * goal.stretch;
    else if (hits_boundary(march, sums.center))
      sums.moments.hits_boundary += 1.0;
  }
  miss_rest(sums, params.end_sample - i, params.samples);
}
