// The paper's method at seams (4.1): the whole pattern is sampled on the center's own chart, and again on every chart that
// samples left for, around the center carried there (by the map of the seam edge instead of eq. 2 and 3). A sample counts on the
// chart whose pass it belongs to. A visit is a chart entered by one seam; if several seams led to a chart, the nearest center has
// a position.

// Each invocation of the dispatch has a region of MAX_VISITS visits; visit 0 is the center's own chart. They are in a buffer,
// because llvmpipe miscompiles local arrays whose index is not constant.
layout(std430, binding = BINDING_VISITS) restrict buffer Visits { VisitData visits[]; };
layout(std430, binding = BINDING_SEAMS) readonly restrict buffer Seams { int seams[]; };

int first_visit;
int visit_count;
bool marking;

// Records the chart that a march has reached.
void mark(March march, int edge) {
  if (!marking || march.jumps > params.max_jumps) return;
  int seam = seams[edge];
  float crossing = length(march.from - march.origin);
  vec4 linear = vec4(march.linear[0], march.linear[1]);
  int same_chart = -1;
  for (int k = first_visit; k < first_visit + visit_count; ++k) {
    if (visits[k].chart != march.chart) continue;
    same_chart = k;
    if (visits[k].seam != seam) continue;
    if (crossing >= visits[k].crossing) return;
    visits[k].linear = linear;
    visits[k].center = march.origin;
    visits[k].crossing = crossing;
    return;
  }
  if (visit_count == MAX_VISITS) return;
  int added = first_visit + visit_count++;
  int next = added;
  if (same_chart >= 0) {
    next = visits[same_chart].next;
    visits[same_chart].next = added;
  }
  visits[added] = VisitData(linear, march.origin, march.chart, seam, next, crossing, vec2(0.0));
}

// A position on a visit's chart → coordinates in the unit disk of the visit.
vec2 to_disk(int visit, mat2 axes, vec2 position) {
  vec4 m = visits[visit].linear;
  return inverse(mat2(m.xy, m.zw) * axes) * (position - visits[visit].center);
}

// Returns whether no other visit of the same chart has a center nearer to the position; `away` is the distance from this visit's
// center.
bool is_nearest(int visit, mat2 axes, vec2 position, float away) {
  int other = visits[visit].next;
  for (int k = 0; k < MAX_VISITS && other != visit; ++k) {
    float distance = length(to_disk(other, axes, position));
    if (distance < away || (distance == away && other < visit)) return false;
    other = visits[other].next;
  }
  return true;
}

// Returns whether a position lies on a chart: either its texel's center does and no border separates them, or neither holds.
bool on_chart(vec2 position, int chart) {
  if (any(lessThan(position, vec2(0.0))) || any(greaterThanEqual(position, vec2(buffer_size)))) return false;
  ivec2 texel = ivec2(position);
  ivec2 id = texelFetch(ids, texel, 0).xy;
  bool inside = id.x == chart && id.y >= 0;
  ivec2 cell = texelFetch(border, texel, 0).xy;
  vec2 middle = vec2(texel) + 0.5;
  for (int i = 0; i < -cell.x; ++i) {
    ivec2 entry = texelFetch(border_list, cell.y + i).xy;
    if (entry.y != chart) continue;
    vec4 uv = texelFetch(border_uv, entry.x) * float(buffer_size);
    vec2 way = position - middle, edge = uv.zw - uv.xy;
    if ((cross_product(way, uv.xy - middle) > 0.0) == (cross_product(way, uv.zw - middle) > 0.0)) continue;
    if ((cross_product(edge, middle - uv.xy) > 0.0) != (cross_product(edge, position - uv.xy) > 0.0)) inside = !inside;
  }
  return inside;
}

// Fills the list of visits from the samples. Returns true if one of them left the chart.
bool mark_charts(inout Sums sums, SamplingEllipse ellipse) {
  if (params.begin_sample == 0) {
    visit_count = 1;
    visits[first_visit] = VisitData(vec4(1.0, 0.0, 0.0, 1.0), ellipse.center, ellipse.chart, -1, first_visit, 0.0, vec2(0.0));
  }
  marking = true;
  bool left = false;
  for (int i = params.begin_sample; i < params.end_sample; ++i) {
    March march = march_to(ellipse, pattern_sample(i, ellipse.rotation, ellipse.index));
    left = left || march.jumps > 0 || march.outcome == LOST;
    if (hits_boundary(march, sums.center)) sums.moments.hits_boundary += 1.0;
  }
  marking = false;
  return left;
}

// Returns whether the pattern of some visit contains the end of a sample's own march.
bool is_visited(March march, SamplingEllipse ellipse) {
  for (int k = first_visit; k < first_visit + visit_count; ++k) {
    if (visits[k].chart != march.chart) continue;
    vec2 disk = to_disk(k, ellipse.axes, march.to);
    if (length(disk) <= stretch_along(disk, ellipse.index)) return true;
  }
  return false;
}

void sample_visit(inout Sums sums, SamplingEllipse ellipse, int visit, inout int taken) {
  vec4 m = visits[visit].linear;
  mat2 axes = mat2(m.xy, m.zw) * ellipse.axes;
  vec2 center = visits[visit].center;
  int chart = visits[visit].chart;
  float factor = abs(m.x * m.w - m.y * m.z);
  for (int i = params.begin_sample; i < params.end_sample; ++i, ++taken) {
    PatternSample goal = pattern_sample(sample_number(i), ellipse.rotation, ellipse.index);
    vec2 there = center + axes * goal.disk;
    if (on_chart(there, chart) && is_nearest(visit, ellipse.axes, there, length(goal.disk)))
      add_sample(sums, ellipse, goal, there, chart, factor);
  }
}

// left: whether any samples left the center's chart.
void sample_neighborhood(inout Sums sums, SamplingEllipse ellipse, bool left) {
  int taken = 0, all = visit_count * (params.end_sample - params.begin_sample);
  for (int k = first_visit; k < first_visit + visit_count; ++k) sample_visit(sums, ellipse, k, taken);
  // Adds samples whose own march leads to charts that were not visited, or nowhere.
  int i = params.begin_sample;
  for (; left && i < params.end_sample; ++i) {
    PatternSample goal = pattern_sample(sample_number(i), ellipse.rotation, ellipse.index);
    if (!goal.inside) continue;
    March march = march_to(ellipse, goal);
    if (march.outcome == LOST || (march.outcome == FOUND && march.jumps > 0 && !is_visited(march, ellipse)))
      sums.moments.missing_area += ellipse.area_space * goal.stretch * goal.stretch;
  }
  miss_rest(sums, all - taken, all / max(params.end_sample - params.begin_sample, 1) * params.samples);
  if (left) miss_rest(sums, params.end_sample - i, params.samples);
}
