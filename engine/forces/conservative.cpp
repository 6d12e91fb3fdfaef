#include "forces/conservative.hpp"

namespace atwood {

template <class S> ConservativeForces<S>::ConservativeForces(const Scene& scene) {
  if (!scene.problem.empty()) {
    refusal_ = "`" + scene.problem + "` has no energy";
    return;
  }
  const Vec3<S> gravity = narrow3<S>(scene.gravity_m_per_s2);
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (scene.bodies[i].fixed || dot(gravity, gravity) == S(0)) continue;
    uniform_.push_back({static_cast<int>(i), S(scene.bodies[i].mass_kg) * gravity});
    central_ = false;
  }
  for (const Force& force : scene.forces) {
    if (!refusal_.empty()) return;
    std::visit([&](const auto& f) { read(f, scene); }, force);
  }
}

template <class S> void ConservativeForces<S>::add_centre(const Vec3<S>& centre) {
  const Vec3<S> apart = centre - centre_;
  if (has_centre_ && dot(apart, apart) != S(0)) central_ = false;
  has_centre_ = true;
  centre_ = centre;
}

// Every fixed or held body that attracts is a centre of force; with two centres angular momentum is not conserved.
template <class S> void ConservativeForces<S>::read(const MutualGravity& force, const Scene& scene) {
  Pairs pairs{force.bodies, {}, S(force.constant_m3_per_kg_s2), S(force.softening_m) * S(force.softening_m)};
  for (const int i : force.bodies) {
    pairs.weight.push_back(S(scene.bodies[i].mass_kg));
    if (scene.bodies[i].fixed || scene.bodies[i].release_s > 0) add_centre(narrow3<S>(scene.bodies[i].position_m));
  }
  pairs_.push_back(std::move(pairs));
}

template <class S> void ConservativeForces<S>::read(const Coulomb& force, const Scene& scene) {
  Pairs pairs{force.bodies, {}, -S(force.constant_N_m2_per_C2), S(0)};
  for (const int i : force.bodies) {
    pairs.weight.push_back(S(scene.bodies[i].charge_C));
    if (scene.bodies[i].fixed || scene.bodies[i].release_s > 0) add_centre(narrow3<S>(scene.bodies[i].position_m));
  }
  pairs_.push_back(std::move(pairs));
}

template <class S> void ConservativeForces<S>::read(const Attractor& force, const Scene& scene) {
  for (const int i : force.bodies)
    attractors_.push_back({i, narrow3<S>(force.center_m), S(force.mu_m3_per_s2) * S(scene.bodies[i].mass_kg)});
  add_centre(narrow3<S>(force.center_m));
}

template <class S> void ConservativeForces<S>::read(const Spring& force, const Scene& scene) {
  if (force.damping_N_s_per_m != 0) refusal_ = "a dashpot takes energy away";
  for (std::size_t k = 0; k < force.points_body_m.size() && k < force.bodies.size(); ++k)
    if (rotates(scene.bodies[force.bodies[k]]) && force.points_body_m[k] != Real3{})
      refusal_ =
          "springs must pull at centres of mass; one pulls at a point of `" + scene.bodies[force.bodies[k]].name + "`";
    else if (force.points_body_m[k] != Real3{}) refusal_ = "springs must pull at centres of mass";
  const bool anchored = force.bodies.size() == 1;
  springs_.push_back({anchored ? -1 : force.bodies[0], force.bodies.back(), narrow3<S>(force.anchor_m),
                      S(force.stiffness_N_per_m), S(force.rest_length_m)});
  if (anchored) add_centre(narrow3<S>(force.anchor_m));
  for (const int i : force.bodies)
    if (scene.bodies[i].fixed || scene.bodies[i].release_s > 0) add_centre(narrow3<S>(scene.bodies[i].position_m));
}

template <class S> void ConservativeForces<S>::read(const Lorentz& force, const Scene& scene) {
  central_ = false;
  for (const int i : force.bodies) {
    const S charge = S(scene.bodies[i].charge_C);
    uniform_.push_back({i, charge * narrow3<S>(force.electric_V_per_m)});
    magnetic_.push_back({i, charge * narrow3<S>(force.magnetic_T)});
  }
}

template <class S> void ConservativeForces<S>::read(const RotatingFrame& force, const Scene& scene) {
  central_ = false;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    if (!scene.bodies[i].fixed)
      frames_.push_back(
          {static_cast<int>(i), S(scene.bodies[i].mass_kg), narrow3<S>(force.angular_velocity_rad_per_s)});
}

template <class S> void ConservativeForces<S>::read(const Potential& force, const Scene&) {
  central_ = false;
  const auto lambda = force.parameters.find("lambda");
  for (const int i : force.bodies)
    henon_heiles_.push_back({i, lambda == force.parameters.end() ? S(1) : S(lambda->second)});
}

template <class S> void ConservativeForces<S>::read(const PointForce& force, const Scene&) {
  central_ = false;
  if (force.point_body_m != Real3{} || !force.on_s.empty())
    refusal_ = "a force at a point of a body, or one that switches, does work";
  uniform_.push_back({force.body, narrow3<S>(force.force_N)});
}

namespace {

template <class S> S henon_heiles_potential(const Vec3<S>& p, S lambda) {
  return (p.x * p.x + p.y * p.y) / S(2) + lambda * (p.x * p.x * p.y - p.y * p.y * p.y / S(3));
}
template <class S> Vec3<S> henon_heiles_force(const Vec3<S>& p, S lambda) {
  return {-(p.x + S(2) * lambda * p.x * p.y), -(p.y + lambda * (p.x * p.x - p.y * p.y)), S(0)};
}

}  // namespace

template <class S> S ConservativeForces<S>::potential_energy(const Motion<S>& motion) const {
  S energy = S(0);
  for (const Uniform& u : uniform_) energy -= dot(u.force_W, motion.p_WB(u.body));
  for (const Central& c : attractors_) energy -= c.strength / norm(motion.p_WB(c.body) - c.centre);
  for (const Pairs& pairs : pairs_)
    for (std::size_t a = 0; a < pairs.bodies.size(); ++a)
      for (std::size_t b = a + 1; b < pairs.bodies.size(); ++b) {
        const Vec3<S> r = motion.p_WB(pairs.bodies[b]) - motion.p_WB(pairs.bodies[a]);
        energy -= pairs.constant * pairs.weight[a] * pairs.weight[b] / real::sqrt(dot(r, r) + pairs.softening2);
      }
  for (const Elastic& s : springs_) {
    const S stretch = norm(motion.p_WB(s.b) - (s.a < 0 ? s.anchor : motion.p_WB(s.a))) - s.rest_length;
    energy += s.stiffness * stretch * stretch / S(2);
  }
  for (const HenonHeiles& p : henon_heiles_) energy += henon_heiles_potential(motion.p_WB(p.body), p.lambda);
  for (const Frame& f : frames_) {
    const Vec3<S> u = cross(f.rate, motion.p_WB(f.body));
    energy -= f.mass * dot(u, u) / S(2);
  }
  return energy;
}

// With d = sqrt(r^2 + s^2): (-1/d' + 1/d) / (d'^2 - d^2) = 1 / (d d' (d + d')).
template <class S>
void ConservativeForces<S>::add_discrete_forces(const Motion<S>& from, const Motion<S>& to, Vec3<S>* force_W) const {
  const S half = S(0.5);
  for (const Uniform& u : uniform_) force_W[u.body] += u.force_W;
  for (const Central& c : attractors_) {
    const Vec3<S> r = from.p_WB(c.body) - c.centre, r_new = to.p_WB(c.body) - c.centre;
    const S d = norm(r), d_new = norm(r_new);
    force_W[c.body] -= (c.strength / (d * d_new * (d + d_new))) * (r + r_new);
  }
  for (const Pairs& pairs : pairs_)
    for (std::size_t a = 0; a < pairs.bodies.size(); ++a)
      for (std::size_t b = a + 1; b < pairs.bodies.size(); ++b) {
        const int i = pairs.bodies[a], j = pairs.bodies[b];
        const Vec3<S> r = from.p_WB(j) - from.p_WB(i), r_new = to.p_WB(j) - to.p_WB(i);
        const S d = real::sqrt(dot(r, r) + pairs.softening2), d_new = real::sqrt(dot(r_new, r_new) + pairs.softening2);
        const Vec3<S> on_i =
            (pairs.constant * pairs.weight[a] * pairs.weight[b] / (d * d_new * (d + d_new))) * (r + r_new);
        force_W[i] += on_i;
        force_W[j] -= on_i;
      }
  for (const Elastic& s : springs_) {
    const Vec3<S> r = from.p_WB(s.b) - (s.a < 0 ? s.anchor : from.p_WB(s.a));
    const Vec3<S> r_new = to.p_WB(s.b) - (s.a < 0 ? s.anchor : to.p_WB(s.a));
    const S quotient = s.rest_length == S(0)
                           ? half * s.stiffness
                           : half * s.stiffness * (S(1) - S(2) * s.rest_length / (norm(r) + norm(r_new)));
    force_W[s.b] -= quotient * (r + r_new);
    if (s.a >= 0) force_W[s.a] += quotient * (r + r_new);
  }
  for (const HenonHeiles& p : henon_heiles_) {
    const Vec3<S> a = from.p_WB(p.body), b = to.p_WB(p.body);
    force_W[p.body] +=
        (S(1) / S(6)) * (henon_heiles_force(a, p.lambda) + S(4) * henon_heiles_force(half * (a + b), p.lambda) +
                         henon_heiles_force(b, p.lambda));
  }
  for (const Magnetic& m : magnetic_)
    force_W[m.body] += cross(half * (from.v_WB(m.body) + to.v_WB(m.body)), m.charge_times_field);
  for (const Frame& f : frames_) {
    const Vec3<S> v = half * (from.v_WB(f.body) + to.v_WB(f.body)), p = half * (from.p_WB(f.body) + to.p_WB(f.body));
    force_W[f.body] -= f.mass * cross(f.rate, v + v + cross(f.rate, p));
  }
}

template class ConservativeForces<float>;
template class ConservativeForces<double>;
template class ConservativeForces<long double>;
template class ConservativeForces<Quad>;

}  // namespace atwood
