// The settings of DART's adapter: defaults, the tuned preset, their checks; and what DART cannot represent.
#include "dart/dart_world.hpp"
#include "dart/mechanism.hpp"
#include "dart/shapes.hpp"
#include "dart/surfaces.hpp"
#include "protocol/printed_setting.hpp"

namespace atwood::dartsim {

// The defaults of World::create, ConstraintSolver and ContactConstraint; contacts_per_body only raises World's limit of
// 1000 contacts.
std::vector<Setting> settings() {
  return {
      printed("scalar", std::string("double"), "Type of the engine's numbers."),
      printed("step", std::string("World::step")),
      printed("pair_law",
              std::string("the scene's: a shape for each material that a body can meet, where laws differ")),
      printed("friction_model", std::string("pyramid of two axes, mu times the normal force")),
      printed("forces", std::string("all but uniform gravity: evaluated by the adapter once a step, at its beginning")),
      printed("gyroscopic", std::string("explicit: always on")),
      printed("split_impulse", std::string("none: DART 6.12 has none for rigid bodies")),
      printed("slip_compliance", std::string("none")),
      printed("bouncing_velocity_m_per_s", 0.1, "Approaches slower than this do not bounce."),
      printed("max_bouncing_velocity_m_per_s", 100.0, "Largest velocity after a bounce."),
      printed("sleeping", std::string("none: DART 6.12 has none")),
      printed("joints", std::string("a skeleton for each tree; closing joints are constraints of velocity, whose error "
                                    "reduction has no effect")),
      printed("joint_forces", std::string("springs and dampers are DART's, implicit over a step; motors once a step")),
      printed("rectangle", std::string("a box of the least thickness")),
      printed("linear_damping", 0.0),
      printed("angular_damping", 0.0),
      rivals::substeps_setting(),
      {"collision_detector",
       std::string("ode"),
       {one_of({"ode", "fcl", "dart"}), "Which of DART's collision detectors finds the contacts."}},
      {"contacts_per_body",
       std::int64_t{16},
       {between(1, 10000), "Contact points for which there is room, beyond 1000."}},
      {"lcp_solver", std::string("dantzig"), {one_of({"dantzig", "pgs"}), "Solver of the contact problem."}},
      {"secondary_lcp_solver",
       std::string("pgs"),
       {one_of({"dantzig", "pgs", "none"}), "Solver where the first one fails."}},
      {"pgs_iterations", std::int64_t{30}, {between(1, 100000), "Most sweeps of projected Gauss-Seidel."}},
      {"pgs_tolerance", 1e-6, {between(0, 1), "Change of an impulse at which the sweeps end."}},
      {"pgs_relative_tolerance", 1e-3, {between(0, 1), "The same, relative to the impulse."}},
      {"error_allowance_m", 0.0, {between(0, 1000), "Overlap that is left alone.", "m"}},
      {"erp", 0.01, {between(0, 1), "Share of an overlap that a step takes away."}},
      {"max_erv_m_per_s", 1e-3, {between(0, 1e6), "Largest velocity that removes overlap.", "m/s"}},
      {"cfm", 1e-5, {between(1e-9, 1), "Softness of contacts (constraint force mixing); DART's own least is 1e-9."}},
      {"friction_direction",
       std::string("engine"),
       {one_of({"engine", "slip"}),
        "First axis of the friction pyramid: the engine's choice, or along the slip (only with collision_detector=ode)."}}};
}

Settings stiff() {
  return {{"erp", 0.0},  // recovery of penetration by velocity leaves a separation speed after an impact
          {"cfm", 1e-9},
          {"friction_direction", std::string("slip")}};
}

std::optional<Fault> contradiction(const Settings& settings) {
  if (rivals::word(settings, "friction_direction") == "slip" && rivals::word(settings, "collision_detector") != "ode")
    return Fault{"setting `friction_direction`: slip requires collision_detector = \"ode\""};
  return {};
}

std::optional<Fault> refusal(const Scene& scene, const Settings& settings) {
  if (const auto reason = refused_mechanism(scene); !reason.empty()) return Fault{reason};
  if (!rivals::shapes_matter(scene)) return {};
  int meshes = 0;
  for (const auto& body : scene.bodies) {
    const auto& detector = std::get<std::string>(settings.at("collision_detector"));
    if (auto fault = refused_shape(body, detector)) return fault;
    meshes += std::holds_alternative<Mesh>(body.shape);
    if (meshes > 1)
      return Fault{"DART's adapter does not support contact between two meshes; found the second mesh `" + body.name +
                   "`"};
  }
  if (const auto reason = refused_law(rivals::laws_in_play(scene)); !reason.empty()) return Fault{reason};
  return {};
}

}  // namespace atwood::dartsim
