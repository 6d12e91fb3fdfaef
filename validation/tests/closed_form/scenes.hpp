// Scenes of the closed forms' tests, and exact differentiation of their samples.
#pragma once

#include <quadmath.h>

#include <cmath>
#include <string>
#include <vector>

#include "closed_form/closed_form.hpp"
#include "dynamics/rates.hpp"
#include "dynamics/state.hpp"
#include "scene/scene.hpp"

namespace atwood::testing {

inline const Real3 down{0, 0, -9.8};

inline Scenario scenario(const std::string& solution, double t_end_s) {
  Scenario made;
  made.id = solution;
  made.t_end_s = t_end_s;
  made.samples = 64;
  made.truth = {TruthKind::closed_form, solution, ""};
  made.scene.materials.push_back({"default", 0, 0, 0});
  made.scene.pairs.push_back({0, 0, 0, 0, 0});
  return made;
}

inline Body point(const std::string& name, double mass_kg, Real3 p, Real3 v) {
  Body body;
  body.name = name;
  body.mass_kg = mass_kg;
  body.position_m = p;
  body.velocity_m_per_s = v;
  return body;
}

inline Body solid(const std::string& name, double mass_kg, Real3 moments, Real3 w) {
  Body body = point(name, mass_kg, {0, 0, 0}, {0, 0, 0});
  body.inertia_kg_m2 = {moments[0], 0, 0, 0, moments[1], 0, 0, 0, moments[2]};
  body.angular_velocity_body_rad_per_s = w;
  return body;
}

inline Body ball(const std::string& name, double mass_kg, double radius_m, Real3 p, Real3 v) {
  Body body = solid(
      name, mass_kg,
      {0.4 * mass_kg * radius_m * radius_m, 0.4 * mass_kg * radius_m * radius_m, 0.4 * mass_kg * radius_m * radius_m},
      {0, 0, 0});
  body.shape = Sphere{radius_m};
  body.position_m = p;
  body.velocity_m_per_s = v;
  return body;
}

inline Joint joint(const std::string& name, JointKind kind, int parent, int child, Real3 on_parent, Real3 on_child,
                   Real3 axis = {0, 0, 1}) {
  Joint made;
  made.name = name;
  made.kind = kind;
  made.parent = parent;
  made.child = child;
  made.anchors_body_m = {on_parent, on_child};
  made.axis_body = axis;
  if (kind == JointKind::ball) made.coordinates = {1, 0, 0, 0};
  return made;
}

inline Wide quad(const char* text) { return strtoflt128(text, nullptr); }

// How far the closed form is from solving the reference's equations of motion: its samples differentiated by the
// central formula of 13 points, against dy/dt, over the scale of each kind. Together with the initial state (checked
// too) that is all that determines the motion. Truncation is (rate h)^12: choose samples accordingly.
inline double residual(const Scenario& given, std::int64_t samples) {
  const Truth truth = closed_form_truth(given, samples);
  if (truth.outcome.status != Status::ok) return HUGE_VAL;
  const dynamics::Dynamics<Wide> equations(given.scene, given.t_end_s);
  const int n = 6, size = equations.size();
  const Wide h = Wide(given.t_end_s) / samples;
  std::vector<std::vector<Wide>> y;
  for (const SampleView sample : truth.values) y.push_back(dynamics::pack<Wide>(given.scene, sample));
  std::vector<Wide> dydt(size), error(4, 0), scale(4, 0);
  const std::vector<Wide> start = dynamics::pack<Wide>(given.scene);
  for (int i = 0; i < size; ++i) error[0] = fmaxq(error[0], fabsq(start[i] - y[0][i]));
  for (std::int64_t k = n; k + n <= samples; ++k) {
    const double at = static_cast<double>(truth.values[k].t_s);
    const int interval = equations.interval_at(at);
    if (equations.interval_at(static_cast<double>(truth.values[k - n].t_s)) != interval ||
        equations.interval_at(static_cast<double>(truth.values[k + n].t_s)) != interval)
      continue;
    equations.rate(truth.values[k].t_s, y[k].data(), dydt.data(), interval);
    for (int i = 0; i < size; ++i) {
      Wide slope = 0, weight = -1;
      for (int j = 1; j <= n; ++j) {  // c_j = (-1)^(j+1) (n!)^2 / (j (n - j)! (n + j)!)
        weight = j == 1 ? Wide(n) / (n + 1) : -weight * (j - 1) * (n - j + 1) / (Wide(j) * (n + j));
        slope += weight * (y[k + j][i] - y[k - j][i]);
      }
      const int kind = static_cast<int>(equations.layout().kinds[i]);
      error[kind] = fmaxq(error[kind], fabsq(slope / h - dydt[i]));
      scale[kind] = fmaxq(scale[kind], fabsq(dydt[i]));
    }
  }
  Wide worst = 0;
  for (int kind = 0; kind < 4; ++kind) worst = fmaxq(worst, scale[kind] > 0 ? error[kind] / scale[kind] : error[kind]);
  return static_cast<double>(worst);
}

}  // namespace atwood::testing
