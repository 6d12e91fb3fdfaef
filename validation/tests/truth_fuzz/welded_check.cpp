#include "welded_check.hpp"

#include <algorithm>

#include "extrapolation.hpp"

namespace atwood::fuzz {
namespace {

struct Weld {
  std::vector<std::size_t> parts;  // bodies, the base first
  std::vector<Long4> turn;         // of each, in the base's axes
  std::vector<Long3> place;        // of each from the centre of mass, in the base's axes
  Long mass = 0;
  std::array<Long, 9> inertia{};  // about the centre of mass, in the base's axes
};

// `base` and what is welded to it. Places are from the base's centre until the centre of mass is known.
Weld welded_to(const Scene& scene, std::size_t base) {
  Weld made{{base}, {{1, 0, 0, 0}}, {{}}, scene.bodies[base].mass_kg, {}};
  for (std::size_t k = 0; k < made.parts.size(); ++k)
    for (const Joint& joint : scene.joints) {
      if (joint.parent != static_cast<int>(made.parts[k])) continue;
      const Long4 q = product(made.turn[k], normalised(joint.frame_wxyz));
      made.parts.push_back(static_cast<std::size_t>(joint.child));
      made.place.push_back(made.place[k] + turned(made.turn[k], at_anchor(joint, 0)) - turned(q, at_anchor(joint, 1)));
      made.turn.push_back(q);
      made.mass += scene.bodies[made.parts.back()].mass_kg;
    }
  Long3 centre{};
  for (std::size_t k = 0; k < made.parts.size(); ++k)
    centre = centre + scene.bodies[made.parts[k]].mass_kg / made.mass * made.place[k];
  for (std::size_t k = 0; k < made.parts.size(); ++k) {
    const Long3 d = made.place[k] = made.place[k] - centre;
    const Body& body = scene.bodies[made.parts[k]];
    for (std::size_t j = 0; j < 3; ++j) {
      Long3 axis{};
      axis[j] = 1;
      const Long3 own = turned(made.turn[k], times(body.inertia_kg_m2, turned_back(made.turn[k], axis)));
      const Long3 shifted = Long(body.mass_kg) * (dot(d, d) * axis - d[j] * d);
      for (std::size_t i = 0; i < 3; ++i) made.inertia[3 * i + j] += own[i] + shifted[i];
    }
  }
  return made;
}

// Writes the samples of the assembly's bodies and joints; false: the integration needs too many steps.
bool move_weld(const Scene& scene, const Weld& weld, const std::vector<Long>& times_s, int digits, Checked& made) {
  const LongBody base = start_of(scene.bodies[weld.parts[0]]);
  const std::array<Long, 9> yields = inverse(weld.inertia);
  const auto change = [&](const Long3& w) { return times(yields, cross(times(weld.inertia, w), w)); };
  const auto f = [&](const Long&, const State& y, State& dydt) {
    const Long3 w{y[4], y[5], y[6]}, dw = change(w);
    const Long4 half = product({y[0], y[1], y[2], y[3]}, {0, w[0] / 2, w[1] / 2, w[2] / 2});
    for (std::size_t c = 0; c < 4; ++c) dydt[c] = half[c];
    for (std::size_t c = 0; c < 3; ++c) dydt[4 + c] = dw[c];
  };
  State start(base.q.begin(), base.q.end());
  start.insert(start.end(), base.w.begin(), base.w.end());
  const std::vector<State> path = solve(f, start, {0, 0, 0, 0, 1, 1, 1}, times_s, digits);
  const Long3 g = widened(scene.gravity_m_per_s2), to_centre = Long(-1) * weld.place[0];
  const Long3 p0 = base.p + turned(base.q, to_centre), v0 = base.v + turned(base.q, cross(base.w, to_centre));
  for (std::size_t k = 0; k < path.size(); ++k) {
    const State& y = path[k];
    const Long4 q{y[0], y[1], y[2], y[3]};
    const Long3 w{y[4], y[5], y[6]}, dw = change(w);
    const Long t = times_s[k];
    // Of each part: the force and the moment about its centre that its motion needs, in the base's axes.
    std::vector<Long3> force, moment;
    for (std::size_t i = 0; i < weld.parts.size(); ++i) {
      const Body& body = scene.bodies[weld.parts[i]];
      const Long3& r = weld.place[i];
      const Long3 own_w = turned_back(weld.turn[i], w), own_dw = turned_back(weld.turn[i], dw);
      made.values[k][weld.parts[i]] = {p0 + t * v0 + t * t / 2 * g + turned(q, r), product(q, weld.turn[i]),
                                       v0 + t * g + turned(q, cross(w, r)), own_w};
      force.push_back(Long(body.mass_kg) * (cross(dw, r) + cross(w, cross(w, r))));
      moment.push_back(
          turned(weld.turn[i], times(body.inertia_kg_m2, own_dw) + cross(own_w, times(body.inertia_kg_m2, own_w))));
    }
    for (std::size_t j = 0; j < scene.joints.size(); ++j) {
      const Joint& joint = scene.joints[j];
      // The joint carries its child and all that is welded on behind it.
      std::vector<bool> behind(weld.parts.size());
      Long3 anchor{}, carried{}, torque{};
      for (std::size_t i = 1; i < weld.parts.size(); ++i) {
        for (const Joint& other : scene.joints)
          if (other.child == static_cast<int>(weld.parts[i]))
            for (std::size_t h = 0; h < i; ++h)
              if (behind[h] && other.parent == static_cast<int>(weld.parts[h])) behind[i] = true;
        if (joint.child != static_cast<int>(weld.parts[i])) continue;
        behind[i] = true;
        anchor = weld.place[i] + turned(weld.turn[i], at_anchor(joint, 1));
      }
      for (std::size_t i = 0; i < weld.parts.size(); ++i) {
        if (!behind[i]) continue;
        carried = carried + force[i];
        torque = torque + moment[i] + cross(weld.place[i] - anchor, force[i]);
      }
      if (std::find(behind.begin(), behind.end(), true) == behind.end()) continue;  // of another assembly
      made.joints[k][j].force = turned(q, carried);
      made.joints[k][j].torque = turned(q, torque);
    }
  }
  return !path.empty();
}

Checked weld(const Scenario& scenario, std::int64_t samples, int digits) {
  const Scene& scene = scenario.scene;
  const std::vector<Long> times_s = sample_times(scenario.t_end_s, samples);
  Checked made = of_starts(scenario, samples);
  made.reactions = true;
  made.joints.assign(times_s.size(), std::vector<LongJoint>(scene.joints.size()));
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const bool placed = std::any_of(scene.joints.begin(), scene.joints.end(),
                                    [&](const Joint& joint) { return joint.child == static_cast<int>(i); });
    if (!placed && !move_weld(scene, welded_to(scene, i), times_s, digits, made))
      return {"the checker needs more than " + std::to_string(kMaxSteps) + " steps", {}, {}};
  }
  return made;
}

}  // namespace

Checked check_welded_bodies(const Scenario& scenario, std::int64_t samples, int digits) {
  Checked made = of_two(weld(scenario, samples, digits), weld(scenario, samples, digits - 4), Long("1e-55"));
  widen_reactions(made, Long("1e-52"));
  return made;
}

}  // namespace atwood::fuzz
