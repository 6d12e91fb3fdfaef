#include "dynamics/state.hpp"

#include <algorithm>

#include "dynamics/arithmetic.hpp"

namespace atwood::dynamics {

Layout layout(const Scene& scene) {
  Layout made;
  made.slots.resize(scene.bodies.size());
  if (!scene.problem.empty()) {
    made.size = made.positions = 3;
    made.kinds.assign(3, Kind::position);
    if (!made.slots.empty()) made.slots[0].position = 0;
    return made;
  }
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (scene.bodies[i].fixed) continue;
    made.slots[i].position = made.positions;
    made.positions += 3;
  }
  made.size = 2 * made.positions;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    Slot& slot = made.slots[i];
    if (slot.position < 0) continue;
    slot.velocity = made.positions + slot.position;
    if (!rotates(scene.bodies[i])) continue;
    slot.attitude = made.size;
    slot.rate = made.size + 4;
    made.size += 7;
  }
  made.kinds.resize(made.size);
  for (const Slot& slot : made.slots) {
    const auto fill = [&](int from, int count, Kind kind) {
      if (from >= 0) std::fill_n(made.kinds.begin() + from, count, kind);
    };
    fill(slot.position, 3, Kind::position);
    fill(slot.velocity, 3, Kind::velocity);
    fill(slot.attitude, 4, Kind::attitude);
    fill(slot.rate, 3, Kind::rate);
  }
  return made;
}

namespace {

template <class S> void normalise(S* q) {
  S square = 0;
  for (int k = 0; k < 4; ++k) square += q[k] * q[k];
  const S length = sqrt(square);
  for (int k = 0; k < 4; ++k) q[k] /= length;
}

// Calls move(element of y, value of the sample) for each value of one body; used for both directions.
template <class S, class Move> void each_value(const Slot& slot, S* y, BodySample& body, Move move) {
  for (int k = 0; k < 3; ++k) {
    if (slot.position >= 0) move(y[slot.position + k], body.p_m[k]);
    if (slot.velocity >= 0) move(y[slot.velocity + k], body.v_m_per_s[k]);
    if (slot.rate >= 0) move(y[slot.rate + k], body.w_rad_per_s[k]);
  }
  for (int k = 0; k < 4; ++k)
    if (slot.attitude >= 0) move(y[slot.attitude + k], body.q_wxyz[k]);
}

BodySample initial_sample(const Body& body) {
  BodySample made;
  for (int k = 0; k < 3; ++k) made.p_m[k] = body.position_m[k];
  for (int k = 0; k < 4; ++k) made.q_wxyz[k] = body.orientation_wxyz[k];
  if (body.fixed) return made;
  for (int k = 0; k < 3; ++k) made.v_m_per_s[k] = body.velocity_m_per_s[k];
  if (rotates(body))
    for (int k = 0; k < 3; ++k) made.w_rad_per_s[k] = body.angular_velocity_body_rad_per_s[k];
  return made;
}

}  // namespace

template <class S> std::vector<S> pack(const Scene& scene, const SampleView& sample) {
  const Layout map = layout(scene);
  std::vector<S> y(map.size);
  for (std::size_t i = 0; i < map.slots.size(); ++i) {
    BodySample body = checked(sample.bodies, i);
    each_value(map.slots[i], y.data(), body, [](S& to, const Wide& from) { to = static_cast<S>(from); });
    if (map.slots[i].attitude >= 0) normalise(&y[map.slots[i].attitude]);
  }
  return y;
}

template <class S> std::vector<S> pack(const Scene& scene) {
  Sample initial;
  for (const Body& body : scene.bodies) initial.bodies.push_back(initial_sample(body));
  return pack<S>(scene, initial);
}

template <class S> Sample unpack(const Scene& scene, S t_s, const S* y) {
  const Layout map = layout(scene);
  Sample made;
  made.t_s = t_s;
  for (std::size_t i = 0; i < map.slots.size(); ++i) {
    BodySample body = initial_sample(scene.bodies[i]);
    each_value(map.slots[i], y, body, [](const S& from, Wide& to) { to = from; });
    made.bodies.push_back(body);
  }
  if (scene.problem == "lorenz" && !made.bodies.empty()) {
    const Wide x = y[0], v = y[1], z = y[2];
    made.bodies[0].v_m_per_s = {10 * (v - x), x * (28 - z) - v, x * v - Wide(8) / 3 * z};
  }
  return made;
}

template <class S> Sample unpack_bars(const Scene& scene, S t_s, const S* bar) {
  const Layout map = layout(scene);
  Sample made;
  made.t_s = t_s;
  for (const Slot& slot : map.slots) {
    BodySample body;
    body.q_wxyz = {0, 0, 0, 0};
    each_value(slot, bar, body, [](const S& from, Wide& to) { to = from; });
    made.bodies.push_back(body);
  }
  return made;
}

std::vector<double> switch_times(const Scene& scene, double t_end_s) {
  std::vector<double> times;
  const auto add = [&](double t) {
    if (t > 0 && t < t_end_s) times.push_back(t);
  };
  const auto add_all = [&](const std::vector<Interval>& on_s) {
    for (const Interval& on : on_s) {
      add(on.from_s);
      add(on.to_s);
    }
  };
  for (const Force& force : scene.forces) {
    if (const auto* thruster = std::get_if<Thruster>(&force)) add_all(thruster->on_s);
    if (const auto* push = std::get_if<PointForce>(&force)) add_all(push->on_s);
  }
  for (const JointForce& force : scene.joint_forces)
    if (const auto* torque = std::get_if<JointTorque>(&force)) add_all(torque->on_s);
  for (const Body& body : scene.bodies)
    if (!body.fixed) add(body.release_s);
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  return times;
}

template std::vector<double> pack(const Scene&);
template std::vector<long double> pack(const Scene&);
template std::vector<Wide> pack(const Scene&);
template std::vector<double> pack(const Scene&, const SampleView&);
template std::vector<long double> pack(const Scene&, const SampleView&);
template std::vector<Wide> pack(const Scene&, const SampleView&);
template Sample unpack(const Scene&, double, const double*);
template Sample unpack(const Scene&, long double, const long double*);
template Sample unpack(const Scene&, Wide, const Wide*);
template Sample unpack_bars(const Scene&, double, const double*);
template Sample unpack_bars(const Scene&, Wide, const Wide*);

}  // namespace atwood::dynamics
