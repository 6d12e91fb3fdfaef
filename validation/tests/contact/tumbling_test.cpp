// Boxes that tumble and strike each other under `+event`, where several points of an instant share their impulses.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

#include "posed_boxes.hpp"

using namespace atwood;
using namespace atwood::posed_boxes;
using namespace atwood::recorded;

namespace {

Body tumbling(const std::string& name, double mass_kg, const Real3& half, const Real3& at, const Real4& q, double speed,
              const Real3& spin) {
  Body body = box(name, mass_kg, half, at, {0, 0, speed});
  body.orientation_wxyz = q;
  body.angular_velocity_body_rad_per_s = spin;
  return body;
}

struct Totals {
  Vector momentum, angular_momentum;
  long double energy = 0;
};
Totals totals_of(const Scene& scene, const Sample& sample) {
  Totals sum;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    const BodySample& s = sample.bodies[i];
    Body posed = body;
    for (std::size_t k = 0; k < 4; ++k) posed.orientation_wxyz[k] = static_cast<double>(s.q_wxyz[k]);
    const Vector x = wide(s.p_m), v = wide(s.v_m_per_s), w = wide(s.w_rad_per_s);
    const long double m = body.mass_kg, I[3] = {body.inertia_kg_m2[0], body.inertia_kg_m2[4], body.inertia_kg_m2[8]};
    sum.momentum += m * v;
    sum.angular_momentum += m * cross(x, v) + (I[0] * w.x) * body_axis(posed, 0) + (I[1] * w.y) * body_axis(posed, 1) +
                            (I[2] * w.z) * body_axis(posed, 2);
    sum.energy += (m * dot(v, v) + I[0] * w.x * w.x + I[1] * w.y * w.y + I[2] * w.z * w.z) / 2;
  }
  return sum;
}

}  // namespace

// While two of the boxes lie on each other, the third strikes: on friction's cone, Gauss-Seidel sweeps gain a digit in
// thousands of sweeps.
TEST_CASE("impulses that Gauss-Seidel sweeps hardly find are found by Newton's method") {
  Scene scene = world({0, 0, 0}, 0, 0.5);
  scene.bodies = {tumbling("b0", 2.882302754968077, {0.38906051728721647, 0.10001533135425689, 0.37898923458429634},
                           {-0.13991380411958632, -0.019314530591861695, 1.0},
                           {0.992864285851168, 0.06455753818895593, 0.0920664940370093, -0.03970635742503983}, 2,
                           {4.787403792330524, -0.5524532524653258, -4.253649623901328}),
                  tumbling("b1", 2.4011167763990247, {0.2543369176930558, 0.410245118696942, 0.17770153971409447},
                           {-0.15229040897694524, -0.04819924421258376, 2.8},
                           {0.9641345784246106, -0.2067983367017625, -0.1414857704221419, -0.08752564990581825}, -1,
                           {-4.462076497747331, -0.6312502310269643, 1.3898703943264188}),
                  tumbling("b2", 1.1790664785204423, {0.362850412334782, 0.20703733089025614, 0.17981815196545373},
                           {-0.05565011824643015, -0.05205559820238101, 4.6},
                           {0.7526167362356027, 0.0229324205968351, -0.6265196723384975, 0.2012840097884109}, -4,
                           {-1.119364759127265, 0.9267689595104986, 2.8333094452741907})};
  for (const char* method : {"atwood/dop853+event", "atwood/dop853+event{restitution=poisson}"}) {
    const Recorded it = run(method, scene, {1, 512, 512});
    INFO(method);
    CHECK(it.count(EventKind::impact) > 10);
    const auto solved = it.outcome.solvers.find("simultaneous-impacts");
    REQUIRE(solved != it.outcome.solvers.end());
    CHECK(solved->second.stagnated > 0);  // solved by Newton's method
    CHECK(solved->second.residual_max < 1e-12);
    const Totals start = totals_of(scene, it.samples.front());
    long double last = start.energy;
    for (const Sample& sample : it.samples) {
      const Totals now = totals_of(scene, sample);
      CHECK(static_cast<double>(norm(now.momentum - start.momentum)) < 1e-11);
      CHECK(static_cast<double>(norm(now.angular_momentum - start.angular_momentum)) < 1e-9);
      CHECK(now.energy <= last * (1 + 1e-11L));
      last = now.energy;
    }
  }
}
