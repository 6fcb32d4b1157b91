// Triangle ∩ disc as a chain of segments and arcs; tables of Gauss-Legendre rules on [0, 1].
#include "mesh/quadrature.h"

#include <algorithm>

#include "support/angle.h"

namespace paradesc {
namespace {

// A chord shorter than this share of the disc's radius only grazes the disc; the part that it cuts off is rounding.
constexpr double grazing = 1e-6;

struct Chord {
  double begin, end;  // along the edge, in [0, 1]
  bool enters, exits; // at the circle, not at a corner
};

// Finds the part of a + t (b - a) within the disc; returns false if there is none.
bool clip_edge(dvec2 a, dvec2 b, double radius, Chord &chord) {
  const dvec2 direction = b - a;
  const double length2 = glm::dot(direction, direction);
  if (!(length2 > 0)) return false;
  const double foot = -glm::dot(a, direction) / length2;
  const double distance = cross(a, direction);
  const double half2 = (radius * radius - distance * distance / length2) / length2;
  if (!(half2 > 0)) return false;
  const double half = std::sqrt(half2);
  chord = {std::max(foot - half, 0.0), std::min(foot + half, 1.0), foot - half > 0, foot + half < 1};
  const bool grazes = chord.enters && chord.exits && 2 * half * std::sqrt(length2) < grazing * radius;
  return chord.begin < chord.end && !grazes;
}

double counter_clockwise_angle(dvec2 from, dvec2 to) {
  const double angle = angle_of(cross(from, to), glm::dot(from, to));
  return angle < 0 ? angle + 2 * pi : angle;
}

void add_arc(DiscRegion &region, dvec2 from, dvec2 to) {
  const double angle = counter_clockwise_angle(from, to);
  // A whole turn between two ends that almost coincide is rounding: a real one lacks at least a chord.
  if (!(angle > 0) || angle > 2 * pi - 0.9 * grazing) return;
  region.pieces[region.count++] = {from, to, angle_of(from.y, from.x), angle};
}

bool holds_origin(const std::array<dvec2, 3> &corners) {
  for (size_t i = 0; i < 3; ++i)
    if (cross(corners[i], corners[(i + 1) % 3]) < 0) return false;
  return true;
}

constexpr std::array<double, 2> nodes_2{0.21132486540518711, 0.78867513459481287};
constexpr std::array<double, 2> weights_2{0.5, 0.5};
constexpr std::array<double, 3> nodes_3{0.11270166537925831, 0.5, 0.8872983346207417};
constexpr std::array<double, 3> weights_3{0.27777777777777779, 0.44444444444444442, 0.27777777777777779};
constexpr std::array<double, 4> nodes_4{0.069431844202973714, 0.33000947820757187, 0.66999052179242813, 0.93056815579702634};
constexpr std::array<double, 4> weights_4{0.17392742256872692, 0.32607257743127305, 0.32607257743127305, 0.17392742256872692};
constexpr std::array<double, 6> nodes_6{0.033765242898423989, 0.16939530676686773, 0.38069040695840156,
                                        0.61930959304159849,  0.83060469323313224, 0.96623475710157603};
constexpr std::array<double, 6> weights_6{0.085662246189585178, 0.1803807865240693, 0.23395696728634552,
                                          0.23395696728634552,  0.1803807865240693, 0.085662246189585178};
constexpr std::array<double, 8> nodes_8{0.019855071751231884, 0.10166676129318664, 0.2372337950418355,  0.40828267875217511,
                                        0.59171732124782495,  0.7627662049581645,  0.89833323870681336, 0.98014492824876809};
constexpr std::array<double, 8> weights_8{0.050614268145188129, 0.11119051722668724, 0.15685332293894363, 0.181341891689181,
                                          0.181341891689181,    0.15685332293894363, 0.11119051722668724, 0.050614268145188129};
constexpr std::array<double, 12> nodes_12{0.0092196828766403748, 0.047941371814762573, 0.11504866290284765, 0.20634102285669129,
                                          0.31608425050090988,   0.43738329574426554,  0.56261670425573451, 0.68391574949909006,
                                          0.79365897714330869,   0.88495133709715235,  0.95205862818523745, 0.99078031712335968};
constexpr std::array<double, 12> weights_12{0.023587668193255914, 0.053469662997659213, 0.080039164271673111,
                                            0.10158371336153296,  0.1167462682691774,   0.12457352290670139,
                                            0.12457352290670139,  0.1167462682691774,   0.10158371336153296,
                                            0.080039164271673111, 0.053469662997659213, 0.023587668193255914};

} // namespace

DiscRegion clip_by_disc(const std::array<dvec2, 3> &corners, double radius) {
  DiscRegion region;
  region.radius = radius;
  dvec2 first(0), last(0);
  size_t first_edge = 0, last_edge = 0;
  bool first_enters = false, last_exits = false;
  for (size_t i = 0; i < 3; ++i) {
    const dvec2 a = corners[i], b = corners[(i + 1) % 3];
    Chord chord;
    if (!clip_edge(a, b, radius, chord)) continue;
    const dvec2 begin = a + chord.begin * (b - a);
    if (region.count == 0) {
      first = begin;
      first_edge = i;
      first_enters = chord.enters;
    } else if (last_exits || chord.enters || last_edge + 1 != i) {
      add_arc(region, last, begin);
    }
    last = chord.exits ? a + chord.end * (b - a) : b;
    last_edge = i;
    last_exits = chord.exits;
    region.pieces[region.count++] = {begin, last};
  }
  if (region.count > 0 && (last_exits || first_enters || (last_edge + 1) % 3 != first_edge)) add_arc(region, last, first);
  if (region.count == 0 && holds_origin(corners)) region.pieces[region.count++] = {{radius, 0}, {radius, 0}, 0, 2 * pi};
  return region;
}

dvec2 nearest_to_origin(const std::array<dvec2, 3> &corners) {
  if (holds_origin(corners)) return dvec2(0);
  dvec2 nearest = corners[0];
  for (size_t i = 0; i < 3; ++i) {
    const dvec2 a = corners[i], edge = corners[(i + 1) % 3] - a;
    const double length2 = glm::dot(edge, edge);
    const double t = length2 > 0 ? std::clamp(-glm::dot(a, edge) / length2, 0.0, 1.0) : 0;
    const dvec2 foot = t < 1 ? a + t * edge : corners[(i + 1) % 3];
    if (glm::dot(foot, foot) < glm::dot(nearest, nearest)) nearest = foot;
  }
  return nearest;
}

GaussRule gauss_rule(int points) {
  switch (points) {
  case 2:
    return {nodes_2, weights_2};
  case 3:
    return {nodes_3, weights_3};
  case 4:
    return {nodes_4, weights_4};
  case 6:
    return {nodes_6, weights_6};
  case 8:
    return {nodes_8, weights_8};
  default:
    return {nodes_12, weights_12};
  }
}

} // namespace paradesc
