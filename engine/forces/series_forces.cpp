#include "forces/series_forces.hpp"

namespace atwood {
namespace {

template <class S> void add_cross(const Vec3<S>& u, S factor, Vec3<S> (&row)[3]) {  // row += factor [u x]
  row[0] += factor * Vec3<S>{S(0), -u.z, u.y};
  row[1] += factor * Vec3<S>{u.z, S(0), -u.x};
  row[2] += factor * Vec3<S>{-u.y, u.x, S(0)};
}

template <class S> void add_multiple(S factor, Vec3<S> (&row)[3]) {
  row[0].x += factor;
  row[1].y += factor;
  row[2].z += factor;
}

template <class S> S per_mass(const Body& body) { return body.fixed ? S(0) : S(1) / S(body.mass_kg); }

// A point mass stays on a line through the anchor if it starts there with a velocity along the line and all forces act
// along it; a dashpot, which acts along the spring, then opposes the whole velocity.
bool stays_on_line(const Scene& scene, int body, const Real3& anchor) {
  const Body& bob = scene.bodies[body];
  const Vec3<double> line = narrow3<double>(bob.position_m) - narrow3<double>(anchor);
  const auto along = [&](const Real3& v) {
    const Vec3<double> across = cross(line, narrow3<double>(v));
    return dot(across, across) == 0;
  };
  if (rotates(bob) || dot(line, line) == 0 || !along(bob.velocity_m_per_s) || !along(scene.gravity_m_per_s2))
    return false;
  for (const Force& force : scene.forces) {
    if (const auto* spring = std::get_if<Spring>(&force)) {
      if (spring->bodies.size() > 1 || spring->anchor_m != anchor) return false;
    } else if (const auto* drive = std::get_if<Drive>(&force)) {
      if (!along(drive->force_N)) return false;
    } else {
      return false;
    }
  }
  return true;
}

bool at_centre(const Real3& point) { return point == Real3{}; }

}  // namespace

template <class S> SeriesForces<S>::SeriesForces(const Scene& scene) {
  if (!scene.problem.empty()) return;
  if (static_cast<int>(scene.bodies.size()) > kMaxSeriesBodies) {
    refusal = "more than " + std::to_string(kMaxSeriesBodies) + " bodies";
    return;
  }
  linear.resize(scene.bodies.size());
  for (Linear& law : linear) law.constant = narrow3<S>(scene.gravity_m_per_s2);
  for (const Force& force : scene.forces) {
    if (refusal.empty()) std::visit([&](const auto& f) { read(f, scene); }, force);
  }
}

template <class S> void SeriesForces<S>::read(const MutualGravity& force, const Scene& scene) {
  const S G = S(force.constant_m3_per_kg_s2), softening2 = S(force.softening_m) * S(force.softening_m);
  for (std::size_t i = 0; i < force.bodies.size(); ++i)
    for (std::size_t j = i + 1; j < force.bodies.size(); ++j) {
      const int a = force.bodies[i], b = force.bodies[j];
      inverse_square.push_back({a, b, {}, G * S(scene.bodies[b].mass_kg), -G * S(scene.bodies[a].mass_kg), softening2});
    }
}

template <class S> void SeriesForces<S>::read(const Attractor& force, const Scene&) {
  for (const int body : force.bodies)
    inverse_square.push_back({-1, body, narrow3<S>(force.center_m), S(0), -S(force.mu_m3_per_s2), S(0)});
}

template <class S> void SeriesForces<S>::read(const Coulomb& force, const Scene& scene) {
  for (std::size_t i = 0; i < force.bodies.size(); ++i)
    for (std::size_t j = i + 1; j < force.bodies.size(); ++j) {
      const Body &a = scene.bodies[force.bodies[i]], &b = scene.bodies[force.bodies[j]];
      const S product = S(force.constant_N_m2_per_C2) * S(a.charge_C) * S(b.charge_C);
      inverse_square.push_back(
          {force.bodies[i], force.bodies[j], {}, -product * per_mass<S>(a), product * per_mass<S>(b), S(0)});
    }
}

template <class S> void SeriesForces<S>::read(const LinearDrag& force, const Scene& scene) {
  for (const int body : force.bodies) {
    const S rate = S(force.coefficient_kg_per_s) * per_mass<S>(scene.bodies[body]);
    linear[body].constant += rate * narrow3<S>(force.wind_m_per_s);
    add_multiple(-rate, linear[body].of_velocity);
    linear[body].angular_drag += S(force.angular_coefficient_N_m_s);
    linear[body].none = false;
  }
}

// q (E + v x B) / m: v x B = -[B x] v.
template <class S> void SeriesForces<S>::read(const Lorentz& force, const Scene& scene) {
  for (const int body : force.bodies) {
    const S ratio = S(scene.bodies[body].charge_C) * per_mass<S>(scene.bodies[body]);
    linear[body].constant += ratio * narrow3<S>(force.electric_V_per_m);
    add_cross(narrow3<S>(force.magnetic_T), -ratio, linear[body].of_velocity);
    linear[body].none = false;
  }
}

// -2 W x v - W x (W x r) = -2 W x v + (W.W) r - (W.r) W
template <class S> void SeriesForces<S>::read(const RotatingFrame& force, const Scene& scene) {
  const Vec3<S> W = narrow3<S>(force.angular_velocity_rad_per_s);
  for (std::size_t body = 0; body < scene.bodies.size(); ++body) {
    if (scene.bodies[body].fixed) continue;
    Linear& law = linear[body];
    add_cross(W, S(-2), law.of_velocity);
    add_multiple(dot(W, W), law.of_position);
    law.of_position[0] -= W.x * W;
    law.of_position[1] -= W.y * W;
    law.of_position[2] -= W.z * W;
    law.none = false;
  }
}

template <class S> void SeriesForces<S>::read(const Spring& force, const Scene& scene) {
  if (force.rest_length_m != 0) refusal = "a spring with a rest length (spring)";
  const bool damped = force.damping_N_s_per_m != 0;
  if (damped && (force.bodies.size() > 1 || !stays_on_line(scene, force.bodies[0], force.anchor_m)))
    refusal = "a dashpot off a line (spring)";
  for (const Real3& point : force.points_body_m)
    if (!at_centre(point)) refusal = "a spring off the centre of mass (spring)";
  if (!refusal.empty()) return;
  const S stiffness = S(force.stiffness_N_per_m);
  if (force.bodies.size() == 1) {
    const int body = force.bodies[0];
    const S rate = stiffness * per_mass<S>(scene.bodies[body]);
    linear[body].constant += rate * narrow3<S>(force.anchor_m);
    add_multiple(-rate, linear[body].of_position);
    add_multiple(-S(force.damping_N_s_per_m) * per_mass<S>(scene.bodies[body]), linear[body].of_velocity);
    linear[body].none = false;
  } else {
    const int a = force.bodies[0], b = force.bodies[1];
    links.push_back({a, b, stiffness * per_mass<S>(scene.bodies[a]), -stiffness * per_mass<S>(scene.bodies[b])});
  }
}

template <class S> void SeriesForces<S>::read(const Drive& force, const Scene& scene) {
  for (const int body : force.bodies)
    oscillating.push_back({body, per_mass<S>(scene.bodies[body]) * narrow3<S>(force.force_N),
                           S(force.angular_frequency_rad_per_s), S(force.phase_rad)});
}

template <class S> void SeriesForces<S>::read(const PointForce& force, const Scene& scene) {
  if (!at_centre(force.point_body_m)) refusal = "a torque in body axes of a force in world axes (point-force)";
  if (!force.on_s.empty()) refusal = "a force that switches (point-force)";
  linear[force.body].constant += per_mass<S>(scene.bodies[force.body]) * narrow3<S>(force.force_N);
}

template <class S> void SeriesForces<S>::read(const Potential& force, const Scene& scene) {
  if (force.name != "henon-heiles") {
    refusal = "potential `" + force.name + "`";
    return;
  }
  const auto lambda = force.parameters.find("lambda");
  for (const int body : force.bodies) {
    const S rate = per_mass<S>(scene.bodies[body]);
    linear[body].of_position[0].x -= rate;
    linear[body].of_position[1].y -= rate;
    linear[body].none = false;
    quadratic.push_back({body, rate * (lambda == force.parameters.end() ? S(1) : S(lambda->second))});
  }
}

template struct SeriesForces<float>;
template struct SeriesForces<double>;
template struct SeriesForces<long double>;
template struct SeriesForces<Quad>;

}  // namespace atwood
