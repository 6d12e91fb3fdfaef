#include "dynamics/invariants.hpp"

#include <algorithm>

#include "dynamics/arithmetic.hpp"
#include "dynamics/contacts.hpp"
#include "dynamics/joint_energy.hpp"
#include "dynamics/swinging_atwood.hpp"
#include "scene/contact_laws.hpp"

namespace atwood::dynamics {

namespace {

Wide3 zero3() { return {0, 0, 0}; }
Wide mass(const Scene& scene, int body) { return scene.bodies[body].mass_kg; }

// ---- potential energy, one function a force ---------------------------------------------------------------------
Wide potential(const MutualGravity& gravity, const Scene& scene, const SampleView& sample) {
  Wide sum = 0;
  const Wide softening = gravity.softening_m;
  for (std::size_t i = 0; i < gravity.bodies.size(); ++i)
    for (std::size_t j = i + 1; j < gravity.bodies.size(); ++j) {
      const int a = gravity.bodies[i], b = gravity.bodies[j];
      const Wide3 r = sample.bodies[b].p_m - sample.bodies[a].p_m;
      sum -= Wide(gravity.constant_m3_per_kg_s2) * mass(scene, a) * mass(scene, b) /
             sqrt(dot(r, r) + softening * softening);
    }
  return sum;
}

Wide potential(const Attractor& attractor, const Scene& scene, const SampleView& sample) {
  Wide sum = 0;
  for (const int i : attractor.bodies)
    if (!scene.bodies[i].fixed)
      sum -=
          Wide(attractor.mu_m3_per_s2) * mass(scene, i) / norm(sample.bodies[i].p_m - widen<Wide>(attractor.center_m));
  return sum;
}

Wide3 world_point(const Spring& spring, const SampleView& sample, std::size_t end) {
  if (end >= spring.bodies.size()) return widen<Wide>(spring.anchor_m);
  const BodySample& body = sample.bodies[spring.bodies[end]];
  if (end >= spring.points_body_m.size()) return body.p_m;
  return body.p_m + rotate(body.q_wxyz, widen<Wide>(spring.points_body_m[end]));
}

Wide potential(const Spring& spring, const Scene&, const SampleView& sample) {
  const Wide stretch =
      norm(world_point(spring, sample, 1) - world_point(spring, sample, 0)) - Wide(spring.rest_length_m);
  return Wide(spring.stiffness_N_per_m) * stretch * stretch / 2;
}

Wide potential(const Lorentz& field, const Scene& scene, const SampleView& sample) {
  Wide sum = 0;
  for (const int i : field.bodies)
    if (!scene.bodies[i].fixed)
      sum -= Wide(scene.bodies[i].charge_C) * dot(widen<Wide>(field.electric_V_per_m), sample.bodies[i].p_m);
  return sum;
}

Wide potential(const Coulomb& coulomb, const Scene& scene, const SampleView& sample) {
  Wide sum = 0;
  for (std::size_t i = 0; i < coulomb.bodies.size(); ++i)
    for (std::size_t j = i + 1; j < coulomb.bodies.size(); ++j) {
      const int a = coulomb.bodies[i], b = coulomb.bodies[j];
      sum += Wide(coulomb.constant_N_m2_per_C2) * Wide(scene.bodies[a].charge_C) * Wide(scene.bodies[b].charge_C) /
             norm(sample.bodies[b].p_m - sample.bodies[a].p_m);
    }
  return sum;
}

// A force fixed in the world at a point x fixed in the body does the work F . dx.
Wide potential(const PointForce& force, const Scene&, const SampleView& sample) {
  if (!force.on_s.empty()) return 0;
  const BodySample& body = sample.bodies[force.body];
  return -dot(widen<Wide>(force.force_N), body.p_m + rotate(body.q_wxyz, widen<Wide>(force.point_body_m)));
}

Wide potential(const RotatingFrame& frame, const Scene& scene, const SampleView& sample) {
  Wide sum = 0;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (scene.bodies[i].fixed || rotates(scene.bodies[i])) continue;
    const Wide3 across = cross(widen<Wide>(frame.angular_velocity_rad_per_s), sample.bodies[i].p_m);
    sum -= mass(scene, static_cast<int>(i)) * dot(across, across) / 2;
  }
  return sum;
}

Wide potential(const Potential& field, const Scene&, const SampleView& sample) {
  const auto found = field.parameters.find("lambda");
  const Wide lambda = found == field.parameters.end() ? 1 : found->second;
  Wide sum = 0;
  for (const int i : field.bodies) {
    const Wide x = sample.bodies[i].p_m[0], y = sample.bodies[i].p_m[1];
    sum += (x * x + y * y) / 2 + lambda * (x * x * y - y * y * y / 3);
  }
  return sum;
}

Wide potential(const LinearDrag&, const Scene&, const SampleView&) { return 0; }
Wide potential(const QuadraticDrag&, const Scene&, const SampleView&) { return 0; }
Wide potential(const Drive&, const Scene&, const SampleView&) { return 0; }
Wide potential(const Thruster&, const Scene&, const SampleView&) { return 0; }

Wide3 spin_W(const Body& body, const BodySample& sample) {  // R I w
  if (!rotates(body)) return zero3();
  Matrix<Wide> inertia;
  std::copy(body.inertia_kg_m2.begin(), body.inertia_kg_m2.end(), inertia.begin());
  return rotate(sample.q_wxyz, multiply(inertia, sample.w_rad_per_s));
}

}  // namespace

Energy energy(const Scene& scene, const SampleView& sample) {
  Energy made;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    if (body.fixed) continue;
    const BodySample& at = sample.bodies[i];
    made.kinetic_J += Wide(body.mass_kg) * dot(at.v_m_per_s, at.v_m_per_s) / 2;
    if (rotates(body)) made.kinetic_J += dot(rotate(at.q_wxyz, at.w_rad_per_s), spin_W(body, at)) / 2;
    made.potential_J -= Wide(body.mass_kg) * dot(widen<Wide>(scene.gravity_m_per_s2), at.p_m);
  }
  for (const Force& force : scene.forces)
    made.potential_J += std::visit([&](const auto& f) { return potential(f, scene, sample); }, force);
  made.kinetic_J += pulleys_kinetic_J(scene, sample);
  made.potential_J += joint_potential_J(scene, sample);
  return made;
}

Wide3 momentum(const Scene& scene, const SampleView& sample) {
  Wide3 sum = zero3();
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    if (!scene.bodies[i].fixed) sum += mass(scene, static_cast<int>(i)) * sample.bodies[i].v_m_per_s;
  return sum;
}

Wide3 angular_momentum(const Scene& scene, const SampleView& sample) {
  Wide3 sum = zero3();
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (scene.bodies[i].fixed) continue;
    const BodySample& at = sample.bodies[i];
    sum += mass(scene, static_cast<int>(i)) * cross(at.p_m, at.v_m_per_s) + spin_W(scene.bodies[i], at);
  }
  return sum;
}

// L about the centre of mass c: L_origin - c x P.
Wide3 angular_momentum_about_center(const Scene& scene, const SampleView& sample) {
  const Wide3 center = center_of_mass(scene, sample);
  Wide3 sum = zero3();
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {  // arms from c first: no cancellation of large terms
    if (scene.bodies[i].fixed) continue;
    const BodySample& at = sample.bodies[i];
    sum += mass(scene, static_cast<int>(i)) * cross(at.p_m - center, at.v_m_per_s) + spin_W(scene.bodies[i], at);
  }
  return sum;
}

Wide total_mass_kg(const Scene& scene) {
  Wide sum = 0;
  for (const Body& body : scene.bodies)
    if (!body.fixed) sum += Wide(body.mass_kg);
  return sum;
}

Wide3 center_of_mass(const Scene& scene, const SampleView& sample) {
  const Wide total = total_mass_kg(scene);
  if (total == 0) return zero3();
  Wide3 sum = zero3();
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    if (!scene.bodies[i].fixed) sum += mass(scene, static_cast<int>(i)) * sample.bodies[i].p_m;
  return (1 / total) * sum;
}

Wide3 laplace_runge_lenz(const Scene& scene, const SampleView& sample, int body) {
  const auto vector = [](const Wide3& r, const Wide3& v, Wide mu) {
    return cross(v, cross(r, v)) - (mu / norm(r)) * r;
  };
  for (const Force& force : scene.forces) {
    const auto* center = std::get_if<Attractor>(&force);
    if (center == nullptr || std::find(center->bodies.begin(), center->bodies.end(), body) == center->bodies.end())
      continue;
    return vector(sample.bodies[body].p_m - widen<Wide>(center->center_m), sample.bodies[body].v_m_per_s,
                  center->mu_m3_per_s2);
  }
  for (const Force& force : scene.forces) {
    const auto* gravity = std::get_if<MutualGravity>(&force);
    if (gravity == nullptr || gravity->bodies.size() != 2 || body != 1) continue;
    const BodySample &a = sample.bodies[gravity->bodies[0]], &b = sample.bodies[gravity->bodies[1]];
    const Wide mu =
        Wide(gravity->constant_m3_per_kg_s2) * (mass(scene, gravity->bodies[0]) + mass(scene, gravity->bodies[1]));
    return vector(b.p_m - a.p_m, b.v_m_per_s - a.v_m_per_s, mu);
  }
  return zero3();
}

Wide magnetic_moment(const Scene& scene, const SampleView& sample, int body) {
  for (const Force& force : scene.forces) {
    const auto* field = std::get_if<Lorentz>(&force);
    if (field == nullptr || std::find(field->bodies.begin(), field->bodies.end(), body) == field->bodies.end())
      continue;
    const Wide3 B = widen<Wide>(field->magnetic_T), E = widen<Wide>(field->electric_V_per_m);
    const Wide B2 = dot(B, B);
    if (B2 == 0) return 0;
    const Wide3& v = sample.bodies[body].v_m_per_s;
    const Wide3 across = v - (dot(v, B) / B2) * B - (1 / B2) * cross(E, B);
    return mass(scene, body) * dot(across, across) / (2 * sqrt(B2));
  }
  return 0;
}

namespace {

constexpr Real3 kZero{};

// What a scene's forces do to the invariants: each field is a reason why some quantity is not conserved.
struct ForceProperties {
  bool dissipates = false;     // energy is not conserved
  bool external = false;       // a force from outside the bodies that is not uniform gravity
  bool off_origin = false;     // ... and is not central about the origin either
  bool exerts_torque = false;  // changes the angular momentum about the centre of mass
  int attractors = 0, magnets = 0, others = 0;
};

bool any_fixed(const Scene& scene, const std::vector<int>& bodies) {
  return std::any_of(bodies.begin(), bodies.end(), [&](int i) { return scene.bodies[i].fixed; });
}

void add_external_force(ForceProperties& c) { c.external = c.off_origin = c.exerts_torque = true; }

void add_force(ForceProperties& c, const Scene& scene, const Force& force) {
  if (const auto* gravity = std::get_if<MutualGravity>(&force)) {
    if (any_fixed(scene, gravity->bodies)) add_external_force(c);
    ++c.others;
  } else if (const auto* coulomb = std::get_if<Coulomb>(&force)) {
    if (any_fixed(scene, coulomb->bodies)) add_external_force(c);
    ++c.others;
  } else if (const auto* attractor = std::get_if<Attractor>(&force)) {
    const bool central = attractor->center_m == kZero;
    c.external = c.exerts_torque = true;
    c.off_origin |= !central;
    ++c.attractors;
  } else if (const auto* spring = std::get_if<Spring>(&force)) {
    c.dissipates |= spring->damping_N_s_per_m != 0;
    if (spring->bodies.size() < 2 || any_fixed(scene, spring->bodies)) {
      const bool central = spring->bodies.size() == 1 && spring->anchor_m == kZero;
      c.external = c.exerts_torque = true;
      c.off_origin |= !central;
    }
    ++c.others;
  } else if (const auto* field = std::get_if<Lorentz>(&force)) {
    const bool neutral =
        std::all_of(field->bodies.begin(), field->bodies.end(), [&](int i) { return scene.bodies[i].charge_C == 0; });
    if (!neutral) add_external_force(c);
    ++c.magnets;
  } else if (const auto* push = std::get_if<PointForce>(&force)) {
    c.dissipates |= !push->on_s.empty();
    add_external_force(c);
    ++c.others;
  } else {  // drags, drive, thruster: not conservative; rotating frame, potentials: conservative external force
    c.dissipates |= !std::holds_alternative<RotatingFrame>(force) && !std::holds_alternative<Potential>(force);
    add_external_force(c);
    ++c.others;
  }
}

bool dissipates_energy(const PairLaw& law) {
  return law.restitution != 1 || law.friction != 0 || law.contact_law != ContactLaw::rigid;
}

}  // namespace

bool conserves(const Scene& scene, std::string_view quantity) {
  if (!scene.problem.empty()) return false;
  ForceProperties c;
  for (const Force& force : scene.forces) add_force(c, scene, force);
  const JointProperties joints = joint_properties(scene);
  c.dissipates |= joints.works;
  if (joints.hold_to_world) add_external_force(c);
  const bool uniform_gravity = scene.gravity_m_per_s2 != kZero;
  const bool touches = contacts_possible(scene), lossy = std::ranges::any_of(laws_in_play(scene), dissipates_energy);
  bool fixed_shape = false, later_release = false;
  for (const Body& body : scene.bodies) {
    fixed_shape |= touches && body.fixed && body.shape.index() != 0;
    later_release |= !body.fixed && body.release_s > 0;
  }

  if (quantity == "swinging-atwood") return is_swinging_atwood_machine(scene);
  if (quantity == "energy") return !c.dissipates && !lossy;
  if (quantity == "jacobi-constant") {
    const bool turning = std::any_of(scene.forces.begin(), scene.forces.end(),
                                     [](const Force& f) { return std::holds_alternative<RotatingFrame>(f); });
    return turning && !c.dissipates && !lossy;
  }
  if (quantity == "momentum" || quantity == "center-of-mass")
    return !c.external && !uniform_gravity && !fixed_shape && !later_release;
  if (quantity == "angular-momentum") return !c.off_origin && !uniform_gravity && !fixed_shape && !later_release;
  if (quantity == "angular-momentum-center") return !c.exerts_torque && !fixed_shape && !later_release;
  if (touches || uniform_gravity || later_release) return false;
  if (quantity == "magnetic-moment") return c.magnets == 1 && c.attractors == 0 && c.others == 0;
  if (quantity == "laplace-runge-lenz") {
    if (c.attractors == 1) return c.magnets == 0 && c.others == 0;
    if (scene.forces.size() != 1 || scene.bodies.size() != 2) return false;
    const auto* gravity = std::get_if<MutualGravity>(&scene.forces[0]);
    return gravity != nullptr && gravity->bodies.size() == 2 && gravity->softening_m == 0 && !c.external;
  }
  return false;
}

}  // namespace atwood::dynamics
