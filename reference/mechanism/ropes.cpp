// The length of a rope on each side of its pulleys.
//
// With rho(th) the unit vector from the axle to the tangent point and d = axis x rho the direction of the rope there,
// the point of the last body is x = axle + r rho + l d, that of the first x = axle + r rho - l d (l: the free length).
// Then
//   L = l + r th (last), l - r th (first)
// is the length up to a constant, its gradient in x is e = d (last), -d (first), and (e . v)' = e . a + |v_perp|^2 / l.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "mechanism/model.hpp"

namespace atwood::mechanism {

namespace {

template <class S> struct Side {
  S length{}, free{}, free_rate{}, theta{};
  Triple<S> e{};
  S gamma{};
};

template <class S>
Side<S> side_of(const RopeEnd<S>& end, bool last, const Triple<S>& x, const Triple<S>& v, double reference) {
  Side<S> made;
  const Triple<S> from_axle = x - end.axle;
  S& free = made.free;
  if (!(end.radius > 0)) {
    free = made.length = dynamics::sqrt(dot(from_axle, from_axle));
    made.e = (S(1) / free) * from_axle;
    made.free_rate = dot(made.e, v);
  } else {
    const S x1 = dot(end.b1, from_axle), x2 = dot(end.b2, from_axle), sign = last ? 1 : -1;
    free = dynamics::sqrt(x1 * x1 + x2 * x2 - end.radius * end.radius);
    made.theta = nearest_branch<S>(dynamics::atan2(x2, x1) - sign * dynamics::atan2(free, end.radius), reference);
    const S c = dynamics::cos(made.theta), s = dynamics::sin(made.theta);
    made.e = sign * (c * end.b2 - s * end.b1);
    made.length = free + sign * end.radius * made.theta;
    made.free_rate = (x1 * dot(end.b1, v) + x2 * dot(end.b2, v)) / free;
  }
  const S along = dot(made.e, v);
  made.gamma = (dot(v, v) - along * along) / free;
  return made;
}

// The side's part in the row of body b (or a).
template <class S> void attach(Row<S>& row, bool last, const Triple<S>& e, const Triple<S>& r) {
  (last ? row.lb : row.la) += e;
  (last ? row.ab : row.aa) += cross(r, e);
}

template <class S> struct Ends {
  Triple<S> r[2], x[2], v[2], centripetal[2];
  Ends(const RopeModel<S>& rope, const std::vector<Motion<S>>& motions) {
    for (int k = 0; k < 2; ++k) {
      const Motion<S>& body = motions[k == 0 ? rope.a : rope.b];
      r[k] = rotate(body.q, k == 0 ? rope.point_a : rope.point_b);
      x[k] = body.p + r[k];
      v[k] = body.v + cross(body.w, r[k]);
      centripetal[k] = cross(body.w, cross(body.w, r[k]));
    }
  }
};

}  // namespace

template <class S>
void add_rope_rows(const Model<S>& model, int index, const std::vector<Motion<S>>& motions, const S& s,
                   const Memory& memory, std::vector<Row<S>>& rows) {
  const RopeModel<S>& rope = model.ropes[index];
  const Ends<S> at(rope, motions);
  Row<S> row;
  row.a = rope.a;
  row.b = rope.b;
  row.tension_of = index;
  if (rope.first.straight) {
    const Triple<S> d = at.x[1] - at.x[0], v = at.v[1] - at.v[0];
    const S length = dynamics::sqrt(dot(d, d));
    const Triple<S> e = (S(1) / length) * d;
    attach(row, true, e, at.r[1]);
    attach<S>(row, false, S(-1) * e, at.r[0]);
    const S along = dot(e, v);
    row.gamma = (dot(v, v) - along * along) / length + dot(e, at.centripetal[1] - at.centripetal[0]);
    row.residual = length - rope.length_a;
    rows.push_back(row);
    return;
  }
  const Side<S> first = side_of(rope.first, false, at.x[0], at.v[0], memory.ropes[index][0]);
  const Side<S> last = side_of(rope.last, true, at.x[1], at.v[1], memory.ropes[index][1]);
  attach(row, false, first.e, at.r[0]);
  const S gamma_first = first.gamma + dot(first.e, at.centripetal[0]);
  const S gamma_last = last.gamma + dot(last.e, at.centripetal[1]);
  if (!(rope.inertia > 0)) {
    attach(row, true, last.e, at.r[1]);
    row.gamma = gamma_first + gamma_last;
    row.residual = (first.length - rope.length_a) + (last.length - rope.length_b);
    rows.push_back(row);
    return;
  }
  row.rope = index;
  row.cp = 1;
  row.gamma = gamma_first;
  row.residual = first.length - rope.length_a + s;
  rows.push_back(row);
  Row<S> second;
  second.a = rope.a;
  second.b = rope.b;
  attach(second, true, last.e, at.r[1]);
  second.rope = index;
  second.cp = -1;
  second.gamma = gamma_last;
  second.residual = last.length - rope.length_b - s;
  rows.push_back(second);
}

template <class S>
std::array<S, 2> rope_lengths(const Model<S>& model, int index, const std::vector<Motion<S>>& motions,
                              const Memory& memory) {
  const RopeModel<S>& rope = model.ropes[index];
  const Ends<S> at(rope, motions);
  if (rope.first.straight) {
    const Triple<S> d = at.x[1] - at.x[0];
    return {dynamics::sqrt(dot(d, d)), S(0)};
  }
  return {side_of(rope.first, false, at.x[0], at.v[0], memory.ropes[index][0]).length,
          side_of(rope.last, true, at.x[1], at.v[1], memory.ropes[index][1]).length};
}

namespace {
// Between two pulleys the rope lies on a common tangent. From the earlier centre to the later one, with d the rope's
// direction, l its length, n the axis of pulley i and R the radii (negative for an axis opposite to n):
//   v = l d - (R_later - R_earlier) d x n,   so   d = (l v - (R_later - R_earlier) n x v) / v^2,   v^2 = l^2 + (...)^2
// The angle of the tangent point rho = d x n on pulley i, whose neighbour is k.
template <class S> S tangent_angle(const Rope& rope, const RopeEnd<S>& end, std::size_t i, std::size_t k) {
  const Triple<S> centre = dynamics::widen<S>(rope.over[i].axle_m), other = dynamics::widen<S>(rope.over[k].axle_m);
  const bool onward = k > i;
  const Triple<S> v = onward ? other - centre : centre - other;
  const Triple<S> its_axis = dynamics::widen<S>(rope.over[k].axis);
  const S r_i = S(rope.over[i].radius_m), r_k = S(rope.over[k].radius_m) * S(dot(its_axis, end.axis) < 0 ? -1 : 1);
  const S apart = onward ? r_k - r_i : r_i - r_k, square = dot(v, v);
  const Triple<S> d = (1 / square) * (dynamics::sqrt(square - apart * apart) * v - apart * cross(end.axis, v));
  const Triple<S> rho = cross(d, end.axis);
  return dynamics::atan2(dot(rho, end.b2), dot(rho, end.b1));
}
}  // namespace

template <class S> void begin_ropes(Model<S>& model, const std::vector<Motion<S>>& motions, const Memory& memory) {
  const double turn = 2 * std::numbers::pi;
  for (std::size_t k = 0; k < model.ropes.size(); ++k) {
    RopeModel<S>& rope = model.ropes[k];
    const std::array<S, 2> lengths = rope_lengths(model, static_cast<int>(k), motions, memory);
    rope.length_a = lengths[0];
    rope.length_b = lengths[1];
    const Rope& given = model.scene->ropes[k];
    if (rope.first.straight) continue;
    const std::size_t last = given.over.size() - 1;
    rope.one_pulley = last == 0;
    rope.onward_first = rope.inward_last = S(0);
    if (!rope.one_pulley && rope.first.radius > 0) rope.onward_first = tangent_angle(given, rope.first, 0, 1);
    if (!rope.one_pulley && rope.last.radius > 0) rope.inward_last = tangent_angle(given, rope.last, last, last - 1);
    const RopeMargins<S> now = rope_margins(model, static_cast<int>(k), motions, memory);
    const auto whole_turns = [&](const S& angle) {
      const double turns = std::floor((static_cast<double>(angle) + turn / 8) / turn);
      return S(turns) * 2 * dynamics::atan2(S(0), S(-1));
    };
    if (rope.first.radius > 0) rope.onward_first -= whole_turns(now.covered_rad[0]);
    if (rope.last.radius > 0) rope.inward_last += whole_turns(now.covered_rad[1]);
  }
}

template <class S>
RopeMargins<S> rope_margins(const Model<S>& model, int index, const std::vector<Motion<S>>& motions,
                            const Memory& memory) {
  const RopeModel<S>& rope = model.ropes[index];
  const Ends<S> at(rope, motions);
  RopeMargins<S> made;
  if (rope.first.straight) {
    const Triple<S> d = at.x[1] - at.x[0];
    made.free_m.fill(dynamics::sqrt(dot(d, d)));
    made.closing_m_per_s.fill(dot(d, at.v[0] - at.v[1]) / made.free_m[0]);
    return made;
  }
  const Side<S> first = side_of(rope.first, false, at.x[0], at.v[0], memory.ropes[index][0]);
  const Side<S> last = side_of(rope.last, true, at.x[1], at.v[1], memory.ropes[index][1]);
  made.free_m = {first.free, last.free};
  made.closing_m_per_s = {-first.free_rate, -last.free_rate};
  const S onward = rope.one_pulley ? last.theta : S(0), inward = rope.one_pulley ? first.theta : S(0);
  if (rope.first.radius > 0) made.covered_rad[0] = onward + rope.onward_first - first.theta;
  if (rope.last.radius > 0) made.covered_rad[1] = last.theta - inward - rope.inward_last;
  return made;
}

template <class S> S off_pulley_planes(const Model<S>& model, const std::vector<Motion<S>>& motions) {
  S largest{};
  for (const RopeModel<S>& rope : model.ropes) {
    const Ends<S> at(rope, motions);
    for (int k = 0; k < 2; ++k) {
      const RopeEnd<S>& end = k == 0 ? rope.first : rope.last;
      if (end.straight || !(end.radius > 0)) continue;
      largest = std::max(largest, dynamics::magnitude(dot(end.axis, at.x[k] - end.axle)));
    }
  }
  return largest;
}

template <class S> void remember(const Model<S>& model, const std::vector<Motion<S>>& motions, Memory& memory) {
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const std::array<S, 4> q = coordinates(model, static_cast<int>(j), motions, memory);
    for (int k = 0; k < 4; ++k) memory.joints[j][k] = static_cast<double>(q[k]);
  }
  for (std::size_t k = 0; k < model.ropes.size(); ++k) {
    const RopeModel<S>& rope = model.ropes[k];
    if (rope.first.straight) continue;
    const Ends<S> at(rope, motions);
    memory.ropes[k] = {static_cast<double>(side_of(rope.first, false, at.x[0], at.v[0], memory.ropes[k][0]).theta),
                       static_cast<double>(side_of(rope.last, true, at.x[1], at.v[1], memory.ropes[k][1]).theta)};
  }
}

#define ATWOOD_ROPES(S)                                                                                       \
  template void add_rope_rows(const Model<S>&, int, const std::vector<Motion<S>>&, const S&, const Memory&,   \
                              std::vector<Row<S>>&);                                                          \
  template std::array<S, 2> rope_lengths(const Model<S>&, int, const std::vector<Motion<S>>&, const Memory&); \
  template void begin_ropes(Model<S>&, const std::vector<Motion<S>>&, const Memory&);                         \
  template RopeMargins<S> rope_margins(const Model<S>&, int, const std::vector<Motion<S>>&, const Memory&);   \
  template S off_pulley_planes(const Model<S>&, const std::vector<Motion<S>>&);                               \
  template void remember(const Model<S>&, const std::vector<Motion<S>>&, Memory&);
ATWOOD_ROPES(double)
ATWOOD_ROPES(long double)
ATWOOD_ROPES(__float128)
#undef ATWOOD_ROPES

}  // namespace atwood::mechanism
