#include "rivals/applied_forces.hpp"

#include <set>

#include "rivals/vector.hpp"

namespace atwood::rivals {
namespace {

struct Context {
  const Scene& scene;
  double t_s, t_switch_s;
  const std::vector<Motion>& motions;
  std::vector<Wrench>& wrenches;

  double mass(int i) const { return scene.bodies[i].mass_kg; }
  void push(int i, const Real3& force_N) const { add(wrenches[i].force_N, force_N); }
  // A force at a point fixed in the body also has a moment, except on a point mass.
  void push_at(int i, const Real3& point_B, const Real3& force_N) const {
    push(i, force_N);
    if (rotates(scene.bodies[i])) {
      add(wrenches[i].torque_N_m, cross(to_world(motions[i].q_WB, point_B), force_N));
    }
  }
  void twist(int i, double coefficient) const {  // torque = -coefficient w
    if (coefficient != 0) add(wrenches[i].torque_N_m, to_world(motions[i].q_WB, -coefficient * motions[i].w_WB_B));
  }
  bool on(const std::vector<Interval>& on_s) const {
    for (const auto& interval : on_s) {
      if (interval.from_s <= t_switch_s && t_switch_s < interval.to_s) return true;
    }
    return on_s.empty();
  }
};

void apply(const MutualGravity& f, const Context& c) {
  const double softening2 = f.softening_m * f.softening_m;
  for (std::size_t i = 0; i < f.bodies.size(); ++i) {
    for (std::size_t j = i + 1; j < f.bodies.size(); ++j) {
      const int a = f.bodies[i], b = f.bodies[j];
      const Real3 r = c.motions[b].p_WB - c.motions[a].p_WB;
      const double r2 = dot(r, r) + softening2;
      const Real3 pull = (f.constant_m3_per_kg_s2 * c.mass(a) * c.mass(b) / (r2 * std::sqrt(r2))) * r;
      c.push(a, pull);
      c.push(b, -1.0 * pull);
    }
  }
}

void apply(const Attractor& f, const Context& c) {
  for (int i : f.bodies) {
    const Real3 r = c.motions[i].p_WB - f.center_m;
    const double r2 = dot(r, r);
    c.push(i, (-c.mass(i) * f.mu_m3_per_s2 / (r2 * std::sqrt(r2))) * r);
  }
}

void apply(const LinearDrag& f, const Context& c) {
  for (int i : f.bodies) {
    c.push(i, -f.coefficient_kg_per_s * (c.motions[i].v_WB - f.wind_m_per_s));
    c.twist(i, f.angular_coefficient_N_m_s);
  }
}

void apply(const QuadraticDrag& f, const Context& c) {
  for (int i : f.bodies) {
    const Real3 u = c.motions[i].v_WB - f.wind_m_per_s;
    c.push(i, (-0.5 * f.density_kg_per_m3 * f.drag_coefficient * f.area_m2 * length(u)) * u);
    c.twist(i, f.angular_coefficient_N_m_s);
  }
}

// Between two points: stiffness along the line for a rest length, isotropic (F = -k d) without; the dashpot acts along
// the line, or on the whole relative velocity where the ends coincide.
void apply(const Spring& f, const Context& c) {
  const int a = f.bodies[0];
  const Real3 point_a = f.points_body_m.empty() ? Real3{} : f.points_body_m[0];
  const auto position = [&](int i, const Real3& p) { return c.motions[i].p_WB + to_world(c.motions[i].q_WB, p); };
  const auto velocity = [&](int i, const Real3& p) {
    return c.motions[i].v_WB + to_world(c.motions[i].q_WB, cross(c.motions[i].w_WB_B, p));
  };
  const bool two = f.bodies.size() > 1;
  const int b = two ? f.bodies[1] : -1;
  const Real3 point_b = two && f.points_body_m.size() > 1 ? f.points_body_m[1] : Real3{};
  const Real3 d = position(a, point_a) - (two ? position(b, point_b) : f.anchor_m);
  const Real3 u = two ? velocity(a, point_a) - velocity(b, point_b) : velocity(a, point_a);
  const double l = length(d);
  Real3 force{};
  if (l > 0) {
    const double along = f.stiffness_N_per_m * (l - f.rest_length_m) + f.damping_N_s_per_m * dot(u, d) / l;
    force = (-along / l) * d;
  } else {
    force = -f.damping_N_s_per_m * u;
  }
  c.push_at(a, point_a, force);
  if (two) c.push_at(b, point_b, -1.0 * force);
}

void apply(const Drive& f, const Context& c) {
  for (int i : f.bodies) c.push(i, std::cos(f.angular_frequency_rad_per_s * c.t_s + f.phase_rad) * f.force_N);
}

void apply(const Lorentz& f, const Context& c) {
  for (int i : f.bodies) {
    c.push(i, c.scene.bodies[i].charge_C * (f.electric_V_per_m + cross(c.motions[i].v_WB, f.magnetic_T)));
  }
}

void apply(const Coulomb& f, const Context& c) {
  for (std::size_t i = 0; i < f.bodies.size(); ++i) {
    for (std::size_t j = i + 1; j < f.bodies.size(); ++j) {
      const int a = f.bodies[i], b = f.bodies[j];
      const Real3 r = c.motions[b].p_WB - c.motions[a].p_WB;
      const double r2 = dot(r, r);
      const Real3 push =
          (f.constant_N_m2_per_C2 * c.scene.bodies[a].charge_C * c.scene.bodies[b].charge_C / (r2 * std::sqrt(r2))) * r;
      c.push(b, push);
      c.push(a, -1.0 * push);
    }
  }
}

void apply(const Thruster& f, const Context& c) {
  if (!c.on(f.on_s)) return;
  c.push_at(f.body, f.point_body_m, f.thrust_N * to_world(c.motions[f.body].q_WB, f.direction_body));
}

void apply(const PointForce& f, const Context& c) {
  if (c.on(f.on_s)) c.push_at(f.body, f.point_body_m, f.force_N);
}

void apply(const RotatingFrame& f, const Context& c) {
  const Real3& w = f.angular_velocity_rad_per_s;
  for (std::size_t i = 0; i < c.scene.bodies.size(); ++i) {
    const Real3 coriolis = -2.0 * cross(w, c.motions[i].v_WB);
    const Real3 centrifugal = -1.0 * cross(w, cross(w, c.motions[i].p_WB));
    c.push(static_cast<int>(i), c.mass(static_cast<int>(i)) * (coriolis + centrifugal));
  }
}

// Henon and Heiles 1964: V = 1/2 (x^2 + y^2) + lambda (x^2 y - y^3 / 3), lambda = 1 unless given.
void apply(const Potential& f, const Context& c) {
  const auto given = f.parameters.find("lambda");
  const double lambda = given == f.parameters.end() ? 1.0 : given->second;
  for (int i : f.bodies) {
    const double x = c.motions[i].p_WB[0], y = c.motions[i].p_WB[1];
    c.push(i, {-x - 2 * lambda * x * y, -y - lambda * (x * x - y * y), 0});
  }
}

const char* name_of(const Force& force) {
  static constexpr const char* names[] = {"gravity",  "attractor",   "drag",           "drag",
                                          "spring",   "drive",       "lorentz",        "coulomb",
                                          "thruster", "point-force", "rotating-frame", "potential"};
  static_assert(std::size(names) == std::variant_size_v<Force>);
  return names[force.index()];
}

}  // namespace

void applied_wrenches(const Scene& scene, double t_s, double t_switch_s, const std::vector<Motion>& motions,
                      std::vector<Wrench>& wrenches) {
  for (auto& wrench : wrenches) wrench = {};
  const Context context{scene, t_s, t_switch_s, motions, wrenches};
  for (const auto& force : scene.forces) {
    std::visit([&](const auto& f) { apply(f, context); }, force);
  }
}

std::string uncovered_force(const Scene& scene) {
  for (const auto& force : scene.forces) {
    if (const auto* potential = std::get_if<Potential>(&force)) {
      if (potential->name != "henon-heiles") return "no force of a potential `" + potential->name + "`";
      for (const auto& [key, value] : potential->parameters) {
        if (key != "lambda") return "no parameter `" + key + "` of the potential henon-heiles";
      }
    }
    if (std::holds_alternative<RotatingFrame>(force)) {
      for (const auto& body : scene.bodies) {
        if (!body.fixed && rotates(body))
          return "rotating frames for point masses only, and `" + body.name + "` rotates";
      }
    }
  }
  return "";
}

std::string names_of_forces(const Scene& scene) {
  std::set<std::string> names;
  for (const auto& force : scene.forces) names.insert(name_of(force));
  std::string text;
  for (const auto& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

}  // namespace atwood::rivals
