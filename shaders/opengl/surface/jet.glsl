// Heights of neighbors over a plane → moments → the gradient of a jet, as in mesh/jets.cpp.
//
// Normal equations are in blocks: cubic terms C, quadratic terms Q, and L with both linear terms and then the heights. Everything
// is in doubles, since normal equations square rounding errors; and without loops, so that everything stays in registers.
const double least_pivot = 1e-5LF;

// Sums of u^(degree - k) v^k over the neighbors; `more` has the sums beyond a vector's four numbers.
dvec3 sum2;
dvec4 sum3, sum4, sum5, sum6;
double more4;
dvec2 more5;
dvec3 more6;
// The same sums weighted by w, and the sum of w^2.
dvec2 sum_w1;
dvec3 sum_w2;
dvec4 sum_w3;
double sum_ww;

void begin_moments() {
  sum2 = more6 = sum_w2 = dvec3(0.0LF);
  sum3 = sum4 = sum5 = sum6 = sum_w3 = dvec4(0.0LF);
  more5 = sum_w1 = dvec2(0.0LF);
  more4 = sum_ww = 0.0LF;
}

void add_height(double u, double v, double w) {
  dvec3 power2 = dvec3(u * u, u * v, v * v);
  dvec4 power3 = dvec4(power2 * u, power2.z * v), power4 = power3 * u;
  double last4 = power3.w * v;
  dvec4 power5 = power4 * u;
  dvec2 last5 = dvec2(last4 * u, last4 * v);
  sum2 += power2;
  sum3 += power3;
  sum4 += power4;
  more4 += last4;
  sum5 += power5;
  more5 += last5;
  sum6 += power5 * u;
  more6 += dvec3(last5 * u, last5.y * v);
  sum_w1 += dvec2(u, v) * w;
  sum_w2 += power2 * w;
  sum_w3 += power3 * w;
  sum_ww += w * w;
}

// Blocks of the symmetric matrix; the first letter names their columns.
dmat4 block_cc;
dmat4x3 block_cq, block_cl;
dmat3 block_qq, block_ql, block_ll;
bool determined; // the neighbors determine everything eliminated so far

// Factors that scale columns to unit length. A zero column gets 0 and gives no pivot.
dvec4 scale_c;
dvec3 scale_q, scale_l;

double inverse_root(double v) { return v > 0.0LF ? 1.0LF / sqrt(v) : 0.0LF; }

void scale_columns() {
  scale_c = dvec4(inverse_root(sum6.x), inverse_root(sum6.z), inverse_root(more6.x), inverse_root(more6.z));
  scale_q = dvec3(inverse_root(sum4.x), inverse_root(sum4.z), inverse_root(more4));
  scale_l = dvec3(inverse_root(sum2.x), inverse_root(sum2.z), 1.0LF);
}

void eliminate_row(dvec3 q, dvec3 l, double inverse) {
  block_qq -= outerProduct(q, q) * inverse;
  block_ql -= outerProduct(l, q) * inverse;
  block_ll -= outerProduct(l, l) * inverse;
}

double inverse_of(double pivot) {
  determined = determined && pivot > least_pivot;
  return determined ? 1.0LF / pivot : 0.0LF;
}

void eliminate_cubic(const int k) {
  dvec4 c = block_cc[k];
  dvec3 q = block_cq[k], l = block_cl[k];
  double inverse = inverse_of(c[k]);
  block_cc -= outerProduct(c, c) * inverse;
  block_cq -= outerProduct(q, c) * inverse;
  block_cl -= outerProduct(l, c) * inverse;
  eliminate_row(q, l, inverse);
}

void eliminate_quadratic(const int k) {
  dvec3 q = block_qq[k];
  eliminate_row(q, block_ql[k], inverse_of(q[k]));
}

struct JetGradient {
  dvec2 slope;
  double residual; // sum of squares
  bool exists;
};

// Solves the remaining blocks. Higher orders are eliminated first, so that the last two pivots tell how well the neighbors
// determine the gradient alone.
JetGradient solve_gradient() {
  eliminate_quadratic(0);
  eliminate_quadratic(1);
  eliminate_quadratic(2);
  dvec3 u = block_ll[0];
  double inverse_u = inverse_of(u.x);
  block_ll -= outerProduct(u, u) * inverse_u;
  dvec3 v = block_ll[1];
  double inverse_v = inverse_of(v.y), slope = v.z * inverse_v;
  return JetGradient(dvec2((u.z - u.y * slope) * inverse_u, slope) * scale_l.xy, max(block_ll[2].z - v.z * slope, 0.0LF), determined);
}

void begin_quadratic() {
  dmat3 qq = dmat3(sum4.xyz, sum4.yzw, dvec3(sum4.zw, more4));
  dmat3 ql = dmat3(dvec3(sum3.xy, sum_w2.x), dvec3(sum3.yz, sum_w2.y), dvec3(sum3.zw, sum_w2.z));
  dmat3 ll = dmat3(dvec3(sum2.xy, sum_w1.x), dvec3(sum2.yz, sum_w1.y), dvec3(sum_w1, sum_ww));
  block_qq = matrixCompMult(qq, outerProduct(scale_q, scale_q));
  block_ql = matrixCompMult(ql, outerProduct(scale_l, scale_q));
  block_ll = matrixCompMult(ll, outerProduct(scale_l, scale_l));
  determined = true;
}

void begin_cubic() {
  dmat4 cc = dmat4(sum6, dvec4(sum6.yzw, more6.x), dvec4(sum6.zw, more6.xy), dvec4(sum6.w, more6));
  dmat4x3 cq = dmat4x3(sum5.xyz, sum5.yzw, dvec3(sum5.zw, more5.x), dvec3(sum5.w, more5));
  dmat4x3 cl = dmat4x3(dvec3(sum4.xy, sum_w3.x), dvec3(sum4.yz, sum_w3.y), dvec3(sum4.zw, sum_w3.z), dvec3(sum4.w, more4, sum_w3.w));
  block_cc = matrixCompMult(cc, outerProduct(scale_c, scale_c));
  block_cq = matrixCompMult(cq, outerProduct(scale_q, scale_c));
  block_cl = matrixCompMult(cl, outerProduct(scale_l, scale_c));
}

JetGradient solve_cubic() {
  begin_quadratic();
  begin_cubic();
  eliminate_cubic(0);
  eliminate_cubic(1);
  eliminate_cubic(2);
  eliminate_cubic(3);
  return solve_gradient();
}

// Fits a jet to `count` neighbors; returns false if they do not determine it. Cubic terms take part as far as they explain more
// than noise would. noise: the variance of the heights around the jet.
bool fit_gradient(int count, out dvec2 gradient, out double noise) {
  const double least_gain = 3.0LF;
  const int cubic_terms = 4, quadratic_columns = 5, spare_neighbors = 2, columns = quadratic_columns + cubic_terms;
  scale_columns();
  begin_quadratic();
  JetGradient quadratic = solve_gradient();
  gradient = quadratic.slope;
  noise = quadratic.residual / double(count - quadratic_columns);
  if (count < quadratic_columns + spare_neighbors || !quadratic.exists) return false;
  if (count < columns + spare_neighbors) return true;
  JetGradient cubic = solve_cubic();
  if (!cubic.exists) return true;
  noise = cubic.residual / double(count - columns);
  double gain = (quadratic.residual - cubic.residual) / double(cubic_terms);
  if (gain > least_gain * noise) gradient += (1.0LF - least_gain * noise / gain) * (cubic.slope - gradient);
  return true;
}
