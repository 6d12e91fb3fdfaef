#include "dynamics/rates.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <stdexcept>

#include "dynamics/arithmetic.hpp"
#include "dynamics/eigen_quad.hpp"

namespace atwood::dynamics {

namespace {

// The state of every body of the scene, including fixed and held ones, and the loads summed so far.
template <class S> struct BodyStates {
  S t_s{};
  std::vector<Triple<S>> p_WB, v_WB, w_WB_B;
  std::vector<std::array<S, 4>> q_WB;
  std::vector<Triple<S>> acceleration_W;  // of forces that are proportional to mass
  std::vector<Triple<S>> force_W, torque_B;
};

double parameter(const Potential& potential, const char* name, double otherwise) {
  const auto found = potential.parameters.find(name);
  return found == potential.parameters.end() ? otherwise : found->second;
}

// ---- one function per force: adds its loads ---------------------------------------------------------------------

// a_i = sum_j G m_j (p_j - p_i) / (r^2 + eps^2)^(3/2)
template <class S> void add(const MutualGravity& gravity, const Scene& scene, BodyStates<S>& now) {
  const S G = gravity.constant_m3_per_kg_s2, softening = gravity.softening_m;
  const S softening2 = softening * softening;
  for (std::size_t i = 0; i < gravity.bodies.size(); ++i)
    for (std::size_t j = i + 1; j < gravity.bodies.size(); ++j) {
      const int a = gravity.bodies[i], b = gravity.bodies[j];
      const Triple<S> r = now.p_WB[b] - now.p_WB[a];
      const S inverse = rsqrt(dot(r, r) + softening2);
      const Triple<S> pull = (G * inverse * inverse * inverse) * r;
      now.acceleration_W[a] += S(scene.bodies[b].mass_kg) * pull;
      now.acceleration_W[b] -= S(scene.bodies[a].mass_kg) * pull;
    }
}

template <class S> void add(const Attractor& attractor, const Scene&, BodyStates<S>& now) {
  const Triple<S> center = widen<S>(attractor.center_m);
  for (const int i : attractor.bodies) {
    const Triple<S> r = now.p_WB[i] - center;
    const S inverse = rsqrt(dot(r, r));
    now.acceleration_W[i] -= (S(attractor.mu_m3_per_s2) * inverse * inverse * inverse) * r;
  }
}

template <class S> void add(const LinearDrag& drag, const Scene&, BodyStates<S>& now) {
  for (const int i : drag.bodies) {
    now.force_W[i] -= S(drag.coefficient_kg_per_s) * (now.v_WB[i] - widen<S>(drag.wind_m_per_s));
    now.torque_B[i] -= S(drag.angular_coefficient_N_m_s) * now.w_WB_B[i];
  }
}

template <class S> void add(const QuadraticDrag& drag, const Scene&, BodyStates<S>& now) {
  const S half = S(drag.density_kg_per_m3) * S(drag.drag_coefficient) * S(drag.area_m2) / 2;
  for (const int i : drag.bodies) {
    const Triple<S> u = now.v_WB[i] - widen<S>(drag.wind_m_per_s);
    now.force_W[i] -= (half * sqrt(dot(u, u))) * u;
    now.torque_B[i] -= S(drag.angular_coefficient_N_m_s) * now.w_WB_B[i];
  }
}

// A force at a point of the body, with its moment about the centre of mass.
template <class S>
void add_point_force(BodyStates<S>& now, int body, const Triple<S>& point_B, const Triple<S>& force_W) {
  now.force_W[body] += force_W;
  now.torque_B[body] += cross(point_B, rotate_back(now.q_WB[body], force_W));
}

// Along d = x_b - x_a (length L): pulls a towards b with k (L - L0) + c dL/dt, dL/dt = d . (v_b - v_a) / L.
// Without a rest length the elastic part k d needs no division; through L = 0 the damped motion goes along u itself.
template <class S> void add(const Spring& spring, const Scene&, BodyStates<S>& now) {
  Triple<S> point_B[2]{}, x[2]{}, v[2]{};
  for (std::size_t k = 0; k < spring.bodies.size() && k < 2; ++k) {
    const int i = spring.bodies[k];
    if (k < spring.points_body_m.size()) point_B[k] = widen<S>(spring.points_body_m[k]);
    x[k] = now.p_WB[i] + rotate(now.q_WB[i], point_B[k]);
    v[k] = now.v_WB[i] + rotate(now.q_WB[i], cross(now.w_WB_B[i], point_B[k]));
  }
  const bool anchored = spring.bodies.size() < 2;
  if (anchored) x[1] = widen<S>(spring.anchor_m);
  const Triple<S> d = x[1] - x[0], u = v[1] - v[0];
  const S length2 = dot(d, d);
  Triple<S> force_W = S(spring.stiffness_N_per_m) * d;
  if (length2 > 0) {
    const S along = S(spring.damping_N_s_per_m) * dot(d, u) / length2;
    force_W += along * d;
    if (spring.rest_length_m != 0)
      force_W -= (S(spring.stiffness_N_per_m) * S(spring.rest_length_m) * rsqrt(length2)) * d;
  } else {
    force_W += S(spring.damping_N_s_per_m) * u;
  }
  add_point_force(now, spring.bodies[0], point_B[0], force_W);
  if (!anchored) add_point_force(now, spring.bodies[1], point_B[1], S(-1) * force_W);
}

template <class S> void add(const Drive& drive, const Scene&, BodyStates<S>& now) {
  const S phase = S(drive.angular_frequency_rad_per_s) * now.t_s + S(drive.phase_rad);
  for (const int i : drive.bodies) now.force_W[i] += cos(phase) * widen<S>(drive.force_N);
}

template <class S> void add(const Lorentz& field, const Scene& scene, BodyStates<S>& now) {
  for (const int i : field.bodies)
    now.force_W[i] += S(scene.bodies[i].charge_C) *
                      (widen<S>(field.electric_V_per_m) + cross(now.v_WB[i], widen<S>(field.magnetic_T)));
}

template <class S> void add(const Coulomb& coulomb, const Scene& scene, BodyStates<S>& now) {
  for (std::size_t i = 0; i < coulomb.bodies.size(); ++i)
    for (std::size_t j = i + 1; j < coulomb.bodies.size(); ++j) {
      const int a = coulomb.bodies[i], b = coulomb.bodies[j];
      const Triple<S> r = now.p_WB[b] - now.p_WB[a];
      const S inverse = rsqrt(dot(r, r));
      const S charges = S(scene.bodies[a].charge_C) * S(scene.bodies[b].charge_C);
      const Triple<S> apart = (S(coulomb.constant_N_m2_per_C2) * charges * inverse * inverse * inverse) * r;
      now.force_W[b] += apart;
      now.force_W[a] -= apart;
    }
}

template <class S> void add(const Thruster& thruster, const Scene&, BodyStates<S>& now) {
  const Triple<S> force_B = S(thruster.thrust_N) * widen<S>(thruster.direction_body);
  now.force_W[thruster.body] += rotate(now.q_WB[thruster.body], force_B);
  now.torque_B[thruster.body] += cross(widen<S>(thruster.point_body_m), force_B);
}

template <class S> void add(const PointForce& force, const Scene&, BodyStates<S>& now) {
  add_point_force(now, force.body, widen<S>(force.point_body_m), widen<S>(force.force_N));
}

// a = -2 W x v - W x (W x r), on every point mass.
template <class S> void add(const RotatingFrame& frame, const Scene& scene, BodyStates<S>& now) {
  const Triple<S> W = widen<S>(frame.angular_velocity_rad_per_s);
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    if (!rotates(scene.bodies[i])) now.acceleration_W[i] -= cross(W, S(2) * now.v_WB[i] + cross(W, now.p_WB[i]));
}

// V = 1/2 (x^2 + y^2) + lambda (x^2 y - y^3 / 3)
template <class S> void add(const Potential& potential, const Scene&, BodyStates<S>& now) {
  const S lambda = parameter(potential, "lambda", 1);
  for (const int i : potential.bodies) {
    const S x = now.p_WB[i][0], y = now.p_WB[i][1];
    now.force_W[i] -= Triple<S>{x + 2 * lambda * x * y, y + lambda * (x * x - y * y), S(0)};
  }
}

const std::vector<Interval>* switched(const Force& force) {
  if (const auto* thruster = std::get_if<Thruster>(&force)) return &thruster->on_s;
  if (const auto* push = std::get_if<PointForce>(&force)) return &push->on_s;
  return nullptr;
}

bool is_on(const Force& force, double t_s) {
  const std::vector<Interval>* on_s = switched(force);
  if (on_s == nullptr || on_s->empty()) return true;
  return std::any_of(on_s->begin(), on_s->end(), [&](const Interval& on) { return on.from_s <= t_s && t_s < on.to_s; });
}

bool is_diagonal(const Real33& m) { return m[1] == 0 && m[2] == 0 && m[3] == 0 && m[5] == 0 && m[6] == 0 && m[7] == 0; }

}  // namespace

std::string unsupported(const Scene& scene) {
  if (!scene.problem.empty())
    return scene.problem == "lorenz" ? "" : "no equations for the problem `" + scene.problem + "`";
  for (const Force& force : scene.forces)
    if (const auto* potential = std::get_if<Potential>(&force); potential && potential->name != "henon-heiles")
      return "no equations for the potential `" + potential->name + "`";
  for (const Body& body : scene.bodies)
    if (!body.fixed && !(body.mass_kg > 0)) return "body `" + body.name + "` is mobile and has no mass";
  return "";
}

template <class S> struct Dynamics<S>::Parts {
  Scene scene;
  Layout map;
  std::vector<double> switches;
  std::vector<std::vector<char>> held, on;  // [interval][body], [interval][force]
  std::vector<Matrix<S>> inertia, inverse_inertia;
  std::vector<char> diagonal;
  std::vector<Triple<S>> fixed_p;
  std::vector<std::array<S, 4>> fixed_q;
  struct HeldOnPlane {
    int body;
    Triple<S> normal;
  };
  std::vector<HeldOnPlane> held_on_plane;

  Parts(const Scene& given, double t_end_s) : scene(given), map(dynamics::layout(given)) {
    if (const std::string why = unsupported(scene); !why.empty()) throw std::invalid_argument(why);
    switches = dynamics::switch_times(scene, t_end_s);
    for (std::size_t k = 0; k <= switches.size(); ++k) {
      const double from = k == 0 ? 0 : switches[k - 1], to = k == switches.size() ? t_end_s : switches[k];
      const double middle = from + (to - from) / 2;
      std::vector<char>& held_now = held.emplace_back();
      for (const Body& body : scene.bodies) held_now.push_back(body.fixed || body.release_s > middle);
      std::vector<char>& on_now = on.emplace_back();
      for (const Force& force : scene.forces) on_now.push_back(is_on(force, middle));
    }
    for (const Body& body : scene.bodies) build_body(body);
  }

  void build_body(const Body& body) {
    Matrix<S>& I = inertia.emplace_back();
    Matrix<S>& J = inverse_inertia.emplace_back();
    diagonal.push_back(is_diagonal(body.inertia_kg_m2));
    using Inertia = Eigen::Matrix<Wide, 3, 3, Eigen::RowMajor>;
    Matrix<Wide> given{}, exact{};
    std::copy(body.inertia_kg_m2.begin(), body.inertia_kg_m2.end(), given.begin());
    if (rotates(body)) Inertia::Map(exact.data()) = Inertia::Map(given.data()).inverse();
    for (int k = 0; k < 9; ++k) {
      I[k] = body.inertia_kg_m2[k];
      J[k] = static_cast<S>(exact[k]);
    }
    fixed_p.push_back(widen<S>(body.position_m));
    std::array<S, 4>& q = fixed_q.emplace_back();
    S square = 0;
    for (int k = 0; k < 4; ++k) {
      q[k] = body.orientation_wxyz[k];
      square += q[k] * q[k];
    }
    for (S& part : q) part /= sqrt(square);
  }

  void place(BodyStates<S>& now, const S* y, int interval) const {
    const std::size_t n = scene.bodies.size();
    now.p_WB.assign(fixed_p.begin(), fixed_p.end());
    now.q_WB.assign(fixed_q.begin(), fixed_q.end());
    now.v_WB.assign(n, {});
    now.w_WB_B.assign(n, {});
    now.acceleration_W.assign(n, widen<S>(scene.gravity_m_per_s2));
    now.force_W.assign(n, {});
    now.torque_B.assign(n, {});
    for (std::size_t i = 0; i < n; ++i) {
      const Slot& slot = map.slots[i];
      if (slot.position < 0) continue;
      now.p_WB[i] = read3(y + slot.position);
      if (slot.attitude >= 0) std::copy_n(y + slot.attitude, 4, now.q_WB[i].begin());
      if (held[interval][i]) continue;  // at rest until its release, whatever its initial velocity
      now.v_WB[i] = read3(y + slot.velocity);
      if (slot.rate >= 0) now.w_WB_B[i] = read3(y + slot.rate);
    }
  }

  // q' = 1/2 q (0, w); w' = I^-1 (torque - w x I w)
  void turn(const BodyStates<S>& now, std::size_t i, S* dydt) const {
    const Slot& slot = map.slots[i];
    const std::array<S, 4>& q = now.q_WB[i];
    const Triple<S>& w = now.w_WB_B[i];
    const S half = S(0.5);
    dydt[slot.attitude] = -half * (q[1] * w[0] + q[2] * w[1] + q[3] * w[2]);
    dydt[slot.attitude + 1] = half * (q[0] * w[0] + q[2] * w[2] - q[3] * w[1]);
    dydt[slot.attitude + 2] = half * (q[0] * w[1] + q[3] * w[0] - q[1] * w[2]);
    dydt[slot.attitude + 3] = half * (q[0] * w[2] + q[1] * w[1] - q[2] * w[0]);
    const Matrix<S>& I = inertia[i];
    if (diagonal[i]) {  // Euler's equations about the principal axes
      for (int k = 0; k < 3; ++k) {
        const int l = (k + 1) % 3, m = (k + 2) % 3;
        dydt[slot.rate + k] = (now.torque_B[i][k] + (I[4 * l] - I[4 * m]) * w[l] * w[m]) * inverse_inertia[i][4 * k];
      }
      return;
    }
    const Triple<S> change = multiply(inverse_inertia[i], now.torque_B[i] - cross(w, multiply(I, w)));
    std::copy_n(change.begin(), 3, dydt + slot.rate);
  }

  void lorenz(const S* y, S* dydt) const {
    dydt[0] = 10 * (y[1] - y[0]);
    dydt[1] = y[0] * (28 - y[2]) - y[1];
    dydt[2] = y[0] * y[1] - 8 * y[2] / 3;
  }

  void rate(S t_s, const S* y, S* dydt, int interval) const {
    if (!scene.problem.empty()) return lorenz(y, dydt);
    static thread_local BodyStates<S> now;
    now.t_s = t_s;
    place(now, y, interval);
    for (std::size_t k = 0; k < scene.forces.size(); ++k)
      if (on[interval][k]) std::visit([&](const auto& force) { add(force, scene, now); }, scene.forces[k]);
    for (const HeldOnPlane& held_body : held_on_plane) {  // the reaction of the plane cancels the acceleration into it
      Triple<S>& a = now.acceleration_W[held_body.body];
      const S mass = scene.bodies[held_body.body].mass_kg;
      const S into = dot(a, held_body.normal) + dot(now.force_W[held_body.body], held_body.normal) / mass;
      if (into < 0) a -= into * held_body.normal;
    }
    std::fill_n(dydt, map.size, S(0));
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      const Slot& slot = map.slots[i];
      if (slot.position < 0 || held[interval][i]) continue;
      const S inverse_mass = 1 / S(scene.bodies[i].mass_kg);
      for (int k = 0; k < 3; ++k) {
        dydt[slot.position + k] = now.v_WB[i][k];
        dydt[slot.velocity + k] = now.acceleration_W[i][k] + now.force_W[i][k] * inverse_mass;
      }
      if (slot.attitude >= 0) turn(now, i, dydt);
    }
  }
};

template <class S>
Dynamics<S>::Dynamics(const Scene& scene, double t_end_s) : parts_(std::make_unique<Parts>(scene, t_end_s)) {}
template <class S> Dynamics<S>::~Dynamics() = default;
template <class S> Dynamics<S>::Dynamics(Dynamics&&) noexcept = default;
template <class S> int Dynamics<S>::size() const { return parts_->map.size; }
template <class S> const Layout& Dynamics<S>::layout() const { return parts_->map; }
template <class S> const std::vector<double>& Dynamics<S>::switch_times() const { return parts_->switches; }
template <class S> int Dynamics<S>::interval_at(double t_s) const {
  const std::vector<double>& times = parts_->switches;
  return static_cast<int>(std::upper_bound(times.begin(), times.end(), t_s) - times.begin());
}
template <class S> void Dynamics<S>::rate(S t_s, const S* y, S* dydt, int interval) const {
  parts_->rate(t_s, y, dydt, interval);
}
template <class S> void Dynamics<S>::hold_on_plane(int body, const Real3& normal) {
  const Triple<S> n = widen<S>(normal);
  parts_->held_on_plane.push_back({body, rsqrt(dot(n, n)) * n});
}

template <class S> void Dynamics<S>::release_from_plane(int body) {
  std::erase_if(parts_->held_on_plane, [&](const auto& held) { return held.body == body; });
}

template class Dynamics<double>;
template class Dynamics<long double>;
template class Dynamics<Wide>;

}  // namespace atwood::dynamics
