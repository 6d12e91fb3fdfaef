// A physics engine in C++ at Atwood's table: symplectic Euler of points in free fall, v += h g, then x += h v.
#include <atwood/protocol/refusal.hpp>
#include <atwood/protocol/timed_passes.hpp>
#include <atwood/protocol/worker.hpp>

using namespace atwood;

// Refused by name: what the scene asks for beyond free fall. Empty: nothing.
std::string beyond(const Scene& scene) {
  if (!scene.problem.empty()) return "equations of " + scene.problem;
  if (!scene.forces.empty()) return "forces beside uniform gravity";
  int shapes = 0;
  for (const Body& body : scene.bodies) {
    if (body.angular_velocity_body_rad_per_s != Real3{} || body.release_s > 0) return "turning or held bodies";
    shapes += body.shape.index() > 0;
  }
  return shapes > 1 ? "contacts" : "";
}

void simulate(const Scene& scene, const Plan& plan, const Observer& observer) {
  std::vector<Body> bodies = scene.bodies;
  const double h_s = plan.t_end_s / static_cast<double>(plan.steps);
  for (std::int64_t n = 0; n <= plan.steps; ++n) {
    if (observer.sample && n % (plan.steps / plan.samples) == 0) {
      Sample sample{step_begin_s<Wide>(plan, n), {}};
      for (const Body& b : bodies) {
        BodySample& s = sample.bodies.emplace_back();
        for (int k = 0; k < 3; ++k) s.p_m[k] = b.position_m[k], s.v_m_per_s[k] = b.velocity_m_per_s[k];
        for (int k = 0; k < 4; ++k) s.q_wxyz[k] = b.orientation_wxyz[k];
      }
      observer.sample(sample);
    }
    for (Body& b : bodies) {
      for (int k = 0; k < 3 && n < plan.steps && !b.fixed; ++k) {
        b.velocity_m_per_s[k] += h_s * scene.gravity_m_per_s2[k];
        b.position_m[k] += h_s * b.velocity_m_per_s[k];
      }
    }
  }
}

Outcome run(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats) {
  if (id.scheme != "symplectic-euler" || !id.overrides.empty() || !id.scalar.empty() || !id.response.empty())
    return refused("cpp has no method " + to_string(id));
  if (const std::string what = beyond(scene); !what.empty()) return refused("cpp has no " + what);
  Outcome outcome = timed_passes(repeats, whole_pass([&] { return simulate(scene, plan, observer), Outcome{}; }));
  outcome.steps_taken = plan.steps;
  return outcome;
}

int main() {
  const MethodInfo euler{
      "cpp/symplectic-euler", "Symplectic Euler of points in free fall.", "", {{"point-mass", 1}}, false, {}};
  return serve(Engine{"cpp", "1", "double", {euler}, run});
}
