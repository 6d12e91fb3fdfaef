// A force fixed in the body whose moment lies along a principal axis, the body spinning about that axis:
//   w = w0 + alpha t, theta = theta0 + w0 t + alpha t^2 / 2,   m v' = m g + R(theta) F
// so the velocity is a Fresnel integral of exp(i theta). J. M. Longuski, J. Guidance 14 (1991) 1145. Thrusters that
// turn on and off split the time; on each piece alpha and F are constant. The integrals
//   J1 = int_0^t exp(i theta(s)) ds,   J2 = int_0^t (t - s) exp(i theta(s)) ds
// are taken by 16 Gauss points on panels over which theta changes by less than 1 rad: the rule's error,
// h^33 (16!)^4 / (33 (32!)^3) ~ 1e-55 for exp(i s), is below the round-off of quad.
#include <algorithm>

#include "closed_form/gauss.hpp"
#include "closed_form/solution.hpp"

namespace atwood::closed_form {

namespace {

constexpr double kMaxTurning = 1e6;  // rad

template <class S> struct Phase { S re1{}, im1{}, re2{}, im2{}; };  // J1, J2

template <class S> Phase<S> integrate(S theta0, S w0, S alpha, S t) {
  static const GaussRule<S> rule = gauss_rule<S>(16);
  const S most = magnitude(w0) + magnitude(alpha) * t;
  const auto panels = static_cast<std::int64_t>(most * t) + 1;  // bounded by kMaxTurning
  const S h = t / panels;
  Phase<S> sum;
  for (std::int64_t k = 0; k < panels; ++k)
    for (std::size_t j = 0; j < rule.node.size(); ++j) {
      const S s = (k + rule.node[j]) * h, theta = theta0 + s * (w0 + alpha * s / 2);
      const S re = h * rule.weight[j] * cos(theta), im = h * rule.weight[j] * sin(theta);
      sum.re1 += re;
      sum.im1 += im;
      sum.re2 += (t - s) * re;
      sum.im2 += (t - s) * im;
    }
  return sum;
}

template <class S> struct Piece {  // between two switches
  S from{}, alpha{}, theta{}, w{};
  Vec<S> force_B{}, p{}, v{};
};

template <class S> struct Ship {
  Vec<S> axis_B{0, 0, 1}, g{};
  Quat<S> q0{1, 0, 0, 0};
  S mass{};
  std::vector<Piece<S>> pieces;

  Pose<S> at(const Piece<S>& piece, S t) const {
    const Phase<S> J = integrate(piece.theta, piece.w, piece.alpha, t);
    const Vec<S> along = dot(piece.force_B, axis_B) * axis_B, across = piece.force_B - along,
                 side = cross(axis_B, across);
    const Vec<S> first = rotate(q0, t * along + J.re1 * across + J.im1 * side);
    const Vec<S> second = rotate(q0, (t * t / 2) * along + J.re2 * across + J.im2 * side);
    Pose<S> now;
    now.v_WB = piece.v + t * g + (1 / mass) * first;
    now.p_WB = piece.p + t * piece.v + (t * t / 2) * g + (1 / mass) * second;
    now.w_WB_B = (piece.w + piece.alpha * t) * axis_B;
    now.q_WB = q0 * turn(axis_B, piece.theta + t * (piece.w + piece.alpha * t / 2));
    return now;
  }
};

bool is_on(const Thruster& thruster, double t_s) {
  return thruster.on_s.empty() || std::any_of(thruster.on_s.begin(), thruster.on_s.end(),
                                              [&](const Interval& on) { return on.from_s <= t_s && t_s < on.to_s; });
}

std::vector<double> switches(const std::vector<const Thruster*>& thrusters, double t_end_s) {
  std::vector<double> times{0};
  for (const Thruster* thruster : thrusters)
    for (const Interval& on : thruster->on_s)
      for (const double t : {on.from_s, on.to_s})
        if (t > 0 && t < t_end_s) times.push_back(t);
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  return times;
}

template <class S> bool parallel(const Vec<S>& a, const Vec<S>& b) {
  return norm(cross(a, b)) <= 8 * unit_round_off<S>() * norm(a) * norm(b);
}

template <class S> Vec<S> multiply(const Real33& m, const Vec<S>& v) {
  return {S(m[0]) * v[0] + S(m[1]) * v[1] + S(m[2]) * v[2], S(m[3]) * v[0] + S(m[4]) * v[1] + S(m[5]) * v[2],
          S(m[6]) * v[0] + S(m[7]) * v[1] + S(m[8]) * v[2]};
}

// Exactly: about the middle axis any orthogonal component grows.
template <class S> bool keeps_axis(const Body& body, const Vec<S>& axis) {
  const Real33& I = body.inertia_kg_m2;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    if (I[3 * i + j] != 0 || I[3 * j + i] != 0) return false;
    if (I[4 * i] != I[4 * j] && axis[i] != 0 && axis[j] != 0) return false;
  }
  return true;
}

template <class S> std::string build(const Scene& scene, int index, double t_end_s, Ship<S>& ship) {
  const Body& body = scene.bodies[index];
  const std::string name = "`" + body.name + "`";
  std::vector<const Thruster*> thrusters;
  for (const Force& force : scene.forces) {
    if (!acts_on(force, index)) continue;
    if (!std::holds_alternative<Thruster>(force)) return force_on_body(scene, force, index) + " is not covered";
    thrusters.push_back(&std::get<Thruster>(force));
  }
  if (body.release_s > 0) return name + " has a later release, which is not covered";
  const Pose<S> start = initial_pose<S>(body);
  const std::vector<double> times = switches(thrusters, t_end_s);
  Vec<S> axis = start.w_WB_B;
  std::vector<Vec<S>> torques;
  for (std::size_t k = 0; k < times.size(); ++k) {
    const double to = k + 1 < times.size() ? times[k + 1] : t_end_s;
    Piece<S> piece;
    piece.from = times[k];
    Vec<S> torque{};
    for (const Thruster* thruster : thrusters)
      if (is_on(*thruster, times[k] + (to - times[k]) / 2)) {
        const Vec<S> push = S(thruster->thrust_N) * vec<S>(thruster->direction_body);
        piece.force_B = piece.force_B + push;
        torque = torque + cross(vec<S>(thruster->point_body_m), push);
      }
    if (is_zero(axis)) axis = torque;
    torques.push_back(torque);
    ship.pieces.push_back(piece);
  }
  ship.q0 = start.q_WB;
  ship.mass = body.mass_kg;
  ship.g = vec<S>(scene.gravity_m_per_s2);
  S moment = 1;
  if (!is_zero(axis)) {
    if (!rotates(body)) return name + " is a point mass with a moment on it";
    ship.axis_B = (1 / norm(axis)) * axis;
    const Vec<S> Iw = multiply(body.inertia_kg_m2, ship.axis_B);
    if (!keeps_axis(body, ship.axis_B) || !parallel(ship.axis_B, Iw))
      return name + " does not spin about a principal axis, or the moment is not along one";
    moment = dot(ship.axis_B, Iw);
  }
  Pose<S> now = start;
  S theta = 0;
  for (std::size_t k = 0; k < ship.pieces.size(); ++k) {
    Piece<S>& piece = ship.pieces[k];
    for (int i = 0; i < 3; ++i)
      if (ship.axis_B[i] == 0 && torques[k][i] != 0) return "a moment on " + name + " is not along its axis of spin";
    if (!parallel(ship.axis_B, torques[k])) return "a moment on " + name + " is not along its axis of spin";
    piece.alpha = dot(ship.axis_B, torques[k]) / moment;
    piece.theta = theta;
    piece.w = dot(now.w_WB_B, ship.axis_B);
    piece.p = now.p_WB;
    piece.v = now.v_WB;
    if (k + 1 == ship.pieces.size()) {
      const S last = S(t_end_s) - piece.from;
      if (magnitude(piece.w) * last + magnitude(piece.alpha) * last * last > S(kMaxTurning))
        return name + " turns by more than 1e6 rad";
      break;
    }
    const S length = ship.pieces[k + 1].from - piece.from;
    if (magnitude(piece.w) * length + magnitude(piece.alpha) * length * length > S(kMaxTurning))
      return name + " turns by more than 1e6 rad";
    now = ship.at(piece, length);
    theta += length * (piece.w + piece.alpha * length / 2);
  }
  return "";
}

template <class S> Motion<S> solve_axis_torque(const Scenario& scenario, const std::vector<S>& t_s) {
  const Scene& scene = scenario.scene;
  Motion<S> motion;
  motion.refusal = possible_contact(scene);
  motion.poses.assign(t_s.size(), std::vector<Pose<S>>(scene.bodies.size()));
  for (std::size_t i = 0; i < scene.bodies.size() && motion.refusal.empty(); ++i) {
    const Pose<S> start = initial_pose<S>(scene.bodies[i]);
    for (auto& poses : motion.poses) poses[i] = start;
    if (scene.bodies[i].fixed) continue;
    Ship<S> ship;
    motion.refusal = build(scene, static_cast<int>(i), scenario.t_end_s, ship);
    if (!motion.refusal.empty()) break;
    for (std::size_t k = 1; k < t_s.size(); ++k) {
      const Piece<S>* piece = &ship.pieces.front();
      for (const Piece<S>& next : ship.pieces)
        if (next.from <= t_s[k]) piece = &next;
      motion.poses[k][i] = ship.at(*piece, t_s[k] - piece->from);
    }
  }
  return motion;
}

}  // namespace

Solution axis_torque() {
  return {
      "axis-torque",
      "body-fixed force with its moment along a principal axis: uniform angular acceleration and Fresnel integrals, "
      "Longuski, J. Guidance 14 (1991) 1145",
      feature::uniform_gravity | feature::spin | feature::thruster, solve_axis_torque<Narrow>, solve_axis_torque<Wide>};
}

}  // namespace atwood::closed_form
