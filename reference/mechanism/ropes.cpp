// The length of a rope on each side of its pulleys.
//
// With rho(th) the unit vector from the axle to the tangent point and d = axis x rho the direction of the rope there, the
// point of the last body is x = axle + r rho + l d, that of the first x = axle + r rho - l d (l: the free length). Then
//   L = l + r th (last), l - r th (first)
// is the length up to a constant, its gradient in x is e = d (last), -d (first), and (e . v)' = e . a + |v_perp|^2 / l.
#include <algorithm>
#include <cmath>

#include "mechanism/model.hpp"

namespace atwood::mechanism {

namespace {

template <class S> struct Side {
  S length{}, theta{};
  Triple<S> e{};
  S gamma{};
};

template <class S> S nearest(const S& angle, double reference) {
  const S turn = 2 * dynamics::atan2(S(0), S(-1));
  return angle + S(std::round((reference - static_cast<double>(angle)) / static_cast<double>(turn))) * turn;
}

template <class S>
Side<S> side_of(const RopeEnd<S>& end, bool last, const Triple<S>& x, const Triple<S>& v, double reference) {
  Side<S> made;
  const Triple<S> from_axle = x - end.axle;
  S free{};
  if (!(end.radius > 0)) {
    free = made.length = dynamics::sqrt(dot(from_axle, from_axle));
    made.e = (S(1) / free) * from_axle;
  } else {
    const S x1 = dot(end.b1, from_axle), x2 = dot(end.b2, from_axle), sign = last ? 1 : -1;
    free = dynamics::sqrt(x1 * x1 + x2 * x2 - end.radius * end.radius);
    made.theta = nearest<S>(dynamics::atan2(x2, x1) - sign * dynamics::atan2(free, end.radius), reference);
    const S c = dynamics::cos(made.theta), s = dynamics::sin(made.theta);
    made.e = sign * (c * end.b2 - s * end.b1);
    made.length = free + sign * end.radius * made.theta;
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
  template S off_pulley_planes(const Model<S>&, const std::vector<Motion<S>>&);                               \
  template void remember(const Model<S>&, const std::vector<Motion<S>>&, Memory&);
ATWOOD_ROPES(double)
ATWOOD_ROPES(long double)
ATWOOD_ROPES(__float128)
#undef ATWOOD_ROPES

}  // namespace atwood::mechanism
