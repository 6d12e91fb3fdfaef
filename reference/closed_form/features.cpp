#include "closed_form/features.hpp"

#include "closed_form/solution.hpp"

namespace atwood::closed_form {

namespace {

class Reader {
 public:
  explicit Reader(const Scenario& scenario) {
    // Frames and the ladders of particles determine the steps of engines and not the motion.
    const auto& [id, title, claim, source, tags, t_end_s, steps, samples, frame_ends_s, spacings_m, sound_speeds, scene,
                 truth, invariants, path, notes] = scenario;
    read(scene);
  }
  std::vector<Present> present;

 private:
  void add(Feature feature, std::string what) { present.push_back({feature, std::move(what)}); }

  void read(const Scene& scene) {
    const auto& [problem, gravity_m_per_s2, simultaneous_impacts, materials, pairs, bodies, forces, joints, ropes,
                 joint_forces, domain, fluids, fluid_boundaries, probes] = scene;
    for (const Joint& joint : joints) read(joint);
    for (const Rope& rope : ropes) read(rope);
    for (const JointForce& force : joint_forces) read(force, joints);
    for (const Fluid& fluid : fluids) add(feature::invalid, "the fluid `" + fluid.name + "`");
    if (!problem.empty()) add(feature::bare_problem, "the bare problem `" + problem + "`");
    if (gravity_m_per_s2 != Real3{}) add(feature::uniform_gravity, "uniform gravity");
    for (const Force& force : forces) {
      for (std::size_t i = 0; i < bodies.size(); ++i)
        if (!bodies[i].fixed && acts_on(force, static_cast<int>(i))) {
          read(force, force_on_body(scene, force, static_cast<int>(i)));
          break;
        }
    }
    for (const Body& body : bodies) read(body);
    std::size_t touchable = 0;
    for (std::size_t i = 0; i < bodies.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (bodies[i].shape.index() != 0 && bodies[j].shape.index() != 0 && !(bodies[i].fixed && bodies[j].fixed)) {
          ++touchable;
          read(pair_law(scene, static_cast<int>(j), static_cast<int>(i)), bodies[j].name, bodies[i].name);
        }
    if (touchable > 1 && simultaneous_impacts != SimultaneousImpacts::unspecified)
      add(feature::convention, "the convention for simultaneous impacts");
  }

  void read(const Body& body) {
    // Inertia, positions and charges are numbers that every solution reads; shapes are read as pairs.
    const auto& [name, mass_kg, inertia_kg_m2, material, shape, position_m, orientation_wxyz, velocity_m_per_s,
                 angular_velocity, charge_C, fixed, release_s] = body;
    const std::string quoted = "`" + name + "`";
    if (fixed) {
      if (velocity_m_per_s != Real3{} || angular_velocity != Real3{})
        add(feature::moving_fixed_body, "the motion of " + quoted + ", which is fixed,");
      return;
    }
    if (release_s != 0) add(feature::late_release, "the late release of " + quoted);
    if (angular_velocity != Real3{}) add(feature::spin, "the spin of " + quoted);
    if (std::holds_alternative<Plane>(shape)) add(feature::invalid, "the free plane " + quoted);
    if (!(mass_kg > 0)) add(feature::invalid, "the mass of " + quoted);
    if (!rotates(body) && angular_velocity != Real3{}) add(feature::invalid, "the spin of the point mass " + quoted);
  }

  void read(const Joint& joint) {
    // Places, axes, the start and the numbers of a stop are read by every solution that covers joints. `assemble` and
    // `hold` determined the start and have no effect after it.
    const auto& [name, kind, parent, child, anchors, axis, axes, frame, coordinates, rates, limits, driven_rate,
                 closes_loop, assemble, hold] = joint;
    static constexpr Feature features[] = {feature::fixed_joint,       feature::hinge,           feature::slider,
                                           feature::cylindrical_joint, feature::universal_joint, feature::ball_joint};
    const std::string what = "the joint `" + name + "`";
    add(features[static_cast<std::size_t>(kind)], what);
    if (closes_loop) add(feature::loop, what + ", which closes a loop,");
    if (limits) add(feature::joint_limits, "a limit of " + what);
    if (driven_rate) add(feature::driven_joint, "the prescribed motion of " + what);
  }

  void read(const Rope& rope) {
    const auto& [name, bodies, points, over] = rope;
    add(feature::rope, "the rope `" + name + "`");
    for (const Pulley& pulley : over) {
      const auto& [axle, axis, radius_m, inertia, angle] = pulley;
      add(feature::pulley, "a pulley of the rope `" + name + "`");
      if (inertia != 0) add(feature::pulley_inertia, "the inertia of a pulley of the rope `" + name + "`");
    }
  }

  void read(const JointForce& force, const std::vector<Joint>& joints) {
    if (const auto* spring = std::get_if<JointSpring>(&force)) {
      const auto& [joint, coordinate, stiffness, rest, damping] = *spring;
      const std::string at = " at the joint `" + joints.at(static_cast<std::size_t>(joint)).name + "`";
      if (stiffness != 0) add(feature::joint_stiffness, "the spring" + at);
      if (damping != 0) add(feature::joint_damping, "the damping" + at);
      return;
    }
    const auto& [joint, coordinate, torque, frequency, phase, on_s] = std::get<JointTorque>(force);
    const std::string at = "the torque at the joint `" + joints.at(static_cast<std::size_t>(joint)).name + "`";
    add(feature::joint_torque, at);
    if (frequency != 0) add(feature::oscillating_torque, "the oscillation of " + at);
    if (!on_s.empty()) add(feature::switched_torque, "the switching of " + at);
  }

  void read(const PairLaw& law, const std::string& one, const std::string& other) {
    const auto& [a, b, restitution, mu, rolling, contact_law, stiffness, damping, pull, modulus, hertz_damping] = law;
    const std::string between = " between `" + one + "` and `" + other + "`";
    add(feature::touching_shapes, "contact" + between + ", which have shapes and could touch,");
    if (mu != 0) add(feature::friction, "friction" + between);
    if (rolling != 0) add(feature::rolling_friction, "rolling friction" + between);
    if (contact_law == ContactLaw::linear) add(feature::linear_contact, "the contact law `linear`" + between);
    if (contact_law == ContactLaw::hertz) add(feature::hertz_contact, "the contact law `hertz`" + between);
    if (!(restitution >= 0 && restitution <= 1) || !(mu >= 0) || !(stiffness >= 0) || !(damping >= 0) ||
        !(modulus >= 0) || !(hertz_damping >= 0))
      add(feature::invalid, "the law" + between);
  }

  void read(const Force& force, const std::string& what) {
    std::visit([&](const auto& given) { read_kind(given, what); }, force);
  }
  void read_kind(const MutualGravity& given, const std::string& what) {
    [[maybe_unused]] const auto& [bodies, constant, softening_m] = given;
    add(feature::mutual_gravity, what);
    if (softening_m != 0) add(feature::softening, "softening in " + what);
  }
  void read_kind(const Attractor& given, const std::string& what) {
    [[maybe_unused]] const auto& [bodies, center_m, mu] = given;
    add(feature::attractor, what);
  }
  void read_kind(const LinearDrag& given, const std::string& what) {
    [[maybe_unused]] const auto& [bodies, coefficient, wind, angular] = given;
    add(feature::linear_drag_force, what);
    if (angular != 0) add(feature::angular_drag, "angular drag in " + what);
  }
  void read_kind(const QuadraticDrag& given, const std::string& what) {
    [[maybe_unused]] const auto& [bodies, density, coefficient, area, wind, angular] = given;
    add(feature::quadratic_drag_force, what);
    if (angular != 0) add(feature::angular_drag, "angular drag in " + what);
  }
  void read_kind(const Spring& given, const std::string& what) {
    [[maybe_unused]] const auto& [bodies, anchor, stiffness, damping, rest_length, points] = given;
    add(feature::spring, what);
    if (bodies.size() != 1) add(feature::two_body_spring, what + " and another body");
    for (const Real3& point : points)
      if (point != Real3{}) add(feature::offset_spring, what + ", attached to a point other than its centre,");
  }
  void read_kind(const Drive& given, const std::string& what) {
    [[maybe_unused]] const auto& [bodies, force_N, frequency, phase] = given;
    add(feature::drive, what);
  }
  void read_kind(const Lorentz& given, const std::string& what) {
    [[maybe_unused]] const auto& [bodies, electric, magnetic] = given;
    add(feature::lorentz_force, what);
  }
  void read_kind(const Coulomb& given, const std::string& what) {
    [[maybe_unused]] const auto& [bodies, constant] = given;
    add(feature::coulomb, what);
  }
  void read_kind(const Thruster& given, const std::string& what) {
    [[maybe_unused]] const auto& [body, point, direction, thrust, on_s] = given;
    add(feature::thruster, what);
  }
  void read_kind(const PointForce& given, const std::string& what) {
    [[maybe_unused]] const auto& [body, point, force_N, on_s] = given;
    add(feature::point_force, what);
  }
  void read_kind(const RotatingFrame& given, const std::string& what) {
    [[maybe_unused]] const auto& [angular_velocity] = given;
    add(feature::rotating_frame, what);
  }
  void read_kind(const Potential& given, const std::string& what) {
    [[maybe_unused]] const auto& [bodies, name, parameters] = given;
    add(feature::potential, what);
  }
};

}  // namespace

std::vector<Present> features_of(const Scenario& scenario) { return Reader(scenario).present; }

std::string first_uncovered(const Scenario& scenario, Features covered) {
  for (const Present& each : features_of(scenario))
    if ((each.feature & covered) == 0) return each.what + " is not covered";
  return "";
}

}  // namespace atwood::closed_form
