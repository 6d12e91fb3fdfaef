// A physics engine in C++ at Atwood's table: symplectic Euler of points in free fall, v += h g, then x += h v.
#include <atwood/protocol/equal_steps.hpp>
#include <atwood/protocol/refusal.hpp>
#include <atwood/protocol/worker.hpp>

using namespace atwood;

// What the scene asks for beyond points in free fall. Empty: nothing.
std::string beyond(const Scene& scene) {
  if (!scene.problem.empty()) return "equations of " + scene.problem;
  if (!scene.forces.empty()) return "forces beside uniform gravity";
  if (!scene.joints.empty() || !scene.ropes.empty() || !scene.fluids.empty()) return "joints, ropes or fluids";
  for (const Body& body : scene.bodies)
    if (body.angular_velocity_body_rad_per_s != Real3{} || body.release_s > 0) return "turning or held bodies";
  return scene.bodies.size() > 1 ? "contacts, and so no second body" : "";
}

Outcome run(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats) {
  if (to_string(id) != "cpp/symplectic-euler") return refused("cpp has no method " + to_string(id));
  if (const std::string what = beyond(scene); !what.empty()) return refused("cpp has no " + what);
  const auto step = [&](std::vector<Body>& bodies, double h_s) {
    for (Body& b : bodies)
      for (int k = 0; k < 3 && !b.fixed; ++k)
        b.position_m[k] += h_s * (b.velocity_m_per_s[k] += h_s * scene.gravity_m_per_s2[k]);
  };
  return equal_steps(
      plan, observer, repeats, [&] { return scene.bodies; }, step, samples_of);
}

int main() {
  const MethodInfo euler{"cpp/symplectic-euler", "Symplectic Euler, free fall.", "", {{"point-mass", 1}}, false, {}};
  return serve(Engine{"cpp", "1", "double", {euler}, run});
}
