// Atwood's machine: two bodies that hang straight down from the ends of a rope over pulleys. The rope moves by s from
// the first body to the second, and with the inertias I and radii r of the pulleys
//   (m1 + m2 + sum I / r^2) s'' = (m2 - m1) g,   tension m1 (g + s'') at the first body,   pulleys turn by s / r
// G. Atwood, A Treatise on the Rectilinear Motion and Rotation of Bodies (1784).
#include "closed_form/mechanism.hpp"

namespace atwood::closed_form {

namespace {

template <class S> struct Machine {
  std::array<std::size_t, 2> body{};
  S speed{}, acceleration{}, tension{};
};

// Where the rope leaves the pulley towards the first body (which = 0), or the second.
template <class S> Vec<S> tangent_point(const Pulley& pulley, const Vec<S>& up, int which) {
  const Vec<S> out = cross(up, unit<S>(pulley.axis));
  return vec<S>(pulley.axle_m) + S(which == 0 ? pulley.radius_m : -pulley.radius_m) * out;
}

template <class S>
std::string build(const Scene& scene, const Rope& rope, const Vec<S>& up, S g, S t_end, Machine<S>& made) {
  const std::string name = "the rope `" + rope.name + "`";
  if (rope.over.empty() || rope.bodies[0] == rope.bodies[1])
    return name + " does not run over a pulley between two bodies";
  std::array<S, 2> room{}, mass{};
  for (int which = 0; which < 2; ++which) {
    const auto k = static_cast<std::size_t>(which);
    made.body[k] = static_cast<std::size_t>(rope.bodies[k]);
    const Body& body = scene.bodies[made.body[k]];
    if (body.fixed) return "`" + body.name + "` is fixed";
    const Pulley& pulley = which == 0 ? rope.over.front() : rope.over.back();
    if (pulley.radius_m > 0 && dot(unit<S>(pulley.axis), up) != 0)
      return "a pulley of " + name + " has no horizontal axle";
    const Pose<S> start = initial_pose<S>(body);
    const Vec<S> point = start.p_WB + rotate(start.q_WB, vec<S>(rope.points_body_m[k])),
                 to_pulley = tangent_point(pulley, up, which) - point;
    if (!is_zero(cross(to_pulley, up)) || !(dot(to_pulley, up) > 0))
      return "`" + body.name + "` does not hang straight below " + name;
    if (!is_zero(cross(point - start.p_WB, up)))
      return name + " does not pull at the vertical line of `" + body.name + "`";
    if (!is_zero(start.w_WB_B) || !is_zero(cross(start.v_WB, up)))
      return "`" + body.name + "` does not move straight up or down";
    room[k] = dot(to_pulley, up);
    mass[k] = body.mass_kg;
    const S rate = which == 0 ? dot(start.v_WB, up) : -dot(start.v_WB, up);
    if (which == 0) made.speed = rate;
    else if (rate != made.speed) return name + " would change its length: its ends do not move at the same speed";
  }
  S total = mass[0] + mass[1];
  for (const Pulley& pulley : rope.over) {
    if (pulley.inertia_kg_m2 == 0) continue;
    if (!(pulley.radius_m > 0)) return "a pulley of " + name + " has inertia and no radius";
    total += S(pulley.inertia_kg_m2) / (S(pulley.radius_m) * S(pulley.radius_m));
  }
  made.acceleration = (mass[1] - mass[0]) * g / total;
  made.tension = mass[0] * (g + made.acceleration);
  // Up to the end and at the turn of the motion, if there is one before it, both ends stay below their pulleys.
  S turn = made.acceleration != 0 ? -made.speed / made.acceleration : S(0);
  if (!(turn > 0 && turn < t_end)) turn = 0;
  for (const S t : {turn, t_end}) {
    const S s = t * (made.speed + made.acceleration * t / 2);
    if (!(s < room[0] && -s < room[1])) return "an end of " + name + " reaches its pulley";
  }
  return "";
}

template <class S> Motion<S> solve_atwood_machine(const Scenario& scenario, const std::vector<S>& t_s) {
  const Scene& scene = scenario.scene;
  Motion<S> motion;
  const Vec<S> gravity = vec<S>(scene.gravity_m_per_s2);
  const S g = norm(gravity);
  motion.refusal = possible_contact(scene);
  if (motion.refusal.empty() && (scene.ropes.empty() || !(g > 0))) motion.refusal = "expected a rope and gravity";
  if (!motion.refusal.empty()) return motion;
  const Vec<S> up{-gravity[0] / g, -gravity[1] / g, -gravity[2] / g};  // exactly a unit vector along an axis
  std::vector<Machine<S>> machines(scene.ropes.size());
  std::vector<int> ropes(scene.bodies.size(), 0);
  for (std::size_t r = 0; r < machines.size(); ++r) {
    motion.refusal = build(scene, scene.ropes[r], up, g, S(scenario.t_end_s), machines[r]);
    if (!motion.refusal.empty()) return motion;
    for (const std::size_t body : machines[r].body) ++ropes[body];
  }
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    if (!scene.bodies[i].fixed && ropes[i] != 1)
      motion.refusal = "`" + scene.bodies[i].name + "` does not hang from one rope";
  if (!motion.refusal.empty()) return motion;
  for (const S& t : t_s) {
    auto& poses = motion.poses.emplace_back();
    auto& states = motion.ropes.emplace_back();
    for (const Body& body : scene.bodies) poses.push_back(initial_pose<S>(body));
    for (std::size_t r = 0; r < machines.size(); ++r) {
      const Machine<S>& m = machines[r];
      const S s = t * (m.speed + m.acceleration * t / 2), u = m.speed + m.acceleration * t;
      for (std::size_t k = 0; k < 2; ++k) {
        const S side = k == 0 ? 1 : -1;
        poses[m.body[k]].p_WB = poses[m.body[k]].p_WB + (side * s) * up;
        poses[m.body[k]].v_WB = (side * u) * up;
      }
      RopeState<S>& state = states.emplace_back();
      state.tension_N = m.tension;
      for (const Pulley& pulley : scene.ropes[r].over)
        state.pulley_angle_rad.push_back(S(pulley.angle_rad) + (pulley.radius_m > 0 ? s / S(pulley.radius_m) : S(0)));
    }
  }
  return motion;
}

}  // namespace

Solution atwood_machine() {
  return {"atwood-machine", "two bodies on a rope over pulleys, Atwood, A Treatise on the Rectilinear Motion (1784)",
          feature::uniform_gravity | feature::rope | feature::pulley | feature::pulley_inertia,
          solve_atwood_machine<Narrow>, solve_atwood_machine<Wide>};
}

}  // namespace atwood::closed_form
