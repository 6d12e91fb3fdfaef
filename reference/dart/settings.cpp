// The settings of DART's adapter: defaults, the tuned preset, their checks; and what DART cannot represent.
#include <stdexcept>

#include "dart/dart_world.hpp"
#include "dart/shapes.hpp"
#include "dart/surfaces.hpp"

namespace atwood::dartsim {

// The defaults of World::create, ConstraintSolver and ContactConstraint; contacts_per_body only raises World's limit of
// 1000 contacts.
Settings default_settings() {
  return {{"scalar", std::string("double")},
          {"step", std::string("World::step")},
          {"pair_law", std::string("the scene's: a shape for each material that a body can meet, where laws differ")},
          {"friction_model", std::string("pyramid of two axes, mu times the normal force")},
          {"forces", std::string("all but uniform gravity: evaluated by the adapter once a step, at its beginning")},
          {"gyroscopic", std::string("explicit: always on")},
          {"split_impulse", std::string("none: DART 6.12 has none for rigid bodies")},
          {"slip_compliance", std::string("none")},
          {"bouncing_velocity_m_per_s", 0.1},
          {"max_bouncing_velocity_m_per_s", 100.0},
          {"sleeping", std::string("none: DART 6.12 has none")},
          {"rectangle", std::string("a box of the least thickness")},
          {"linear_damping", 0.0},
          {"angular_damping", 0.0},
          {"substeps", std::int64_t{1}},
          {"collision_detector", std::string("ode")},
          {"contacts_per_body", std::int64_t{16}},
          {"lcp_solver", std::string("dantzig")},
          {"secondary_lcp_solver", std::string("pgs")},
          {"pgs_iterations", std::int64_t{30}},
          {"pgs_tolerance", 1e-6},
          {"pgs_relative_tolerance", 1e-3},
          {"error_allowance_m", 0.0},
          {"erp", 0.01},
          {"max_erv_m_per_s", 1e-3},
          {"cfm", 1e-5},
          {"friction_direction", std::string("engine")}};
}

Settings tuned_settings() {
  Settings tuned = default_settings();
  tuned["erp"] = 0.0;  // recovery of penetration by velocity leaves a separation speed after an impact
  tuned["cfm"] = 1e-9;
  tuned["friction_direction"] = std::string("slip");
  return tuned;
}

std::set<std::string> fixed_settings() {
  return {"scalar",
          "step",
          "pair_law",
          "friction_model",
          "forces",
          "gyroscopic",
          "split_impulse",
          "slip_compliance",
          "bouncing_velocity_m_per_s",
          "max_bouncing_velocity_m_per_s",
          "sleeping",
          "rectangle",
          "linear_damping",
          "angular_damping"};
}

void check_settings(const Settings& settings) {
  const std::string detector = rivals::choice(settings, "collision_detector", {"ode", "fcl", "dart"});
  const std::string direction = rivals::choice(settings, "friction_direction", {"engine", "slip"});
  if (direction == "slip" && detector != "ode") {
    throw std::invalid_argument("setting `friction_direction`: slip requires collision_detector = \"ode\"");
  }
  rivals::choice(settings, "lcp_solver", {"dantzig", "pgs"});
  rivals::choice(settings, "secondary_lcp_solver", {"dantzig", "pgs", "none"});
  rivals::count(settings, "pgs_iterations", 1);
  rivals::count(settings, "contacts_per_body", 1);
  const auto at_least = [&](const char* name, double least) {
    if (!(rivals::number(settings, name) >= least)) {
      throw std::invalid_argument(std::string("setting `") + name + "`: expected a number of at least " +
                                  (least > 0 ? "1e-9" : "0"));
    }
  };
  for (const char* name : {"error_allowance_m", "erp", "max_erv_m_per_s", "pgs_tolerance", "pgs_relative_tolerance"}) {
    at_least(name, 0);
  }
  at_least("cfm", 1e-9);  // DART's own bound
  if (!(rivals::number(settings, "erp") <= 1))
    throw std::invalid_argument("setting `erp`: expected a number of at most 1");
}

std::string refusal(const Scene& scene, const Settings& settings) {
  if (!rivals::shapes_matter(scene)) return "";
  int meshes = 0;
  for (const auto& body : scene.bodies) {
    const auto& detector = std::get<std::string>(settings.at("collision_detector"));
    if (const auto reason = refused_shape(body, detector); !reason.empty()) return reason;
    meshes += std::holds_alternative<Mesh>(body.shape);
    if (meshes > 1)
      return "DART's adapter does not support contact between two meshes; found the second mesh `" + body.name + "`";
  }
  return refused_law(rivals::laws_in_play(scene));
}

}  // namespace atwood::dartsim
