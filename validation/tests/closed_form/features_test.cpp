// Each feature of scenes is added to the scene of each closed form. The closed form refuses it, or agrees with the
// certified solver, which shares no code with it; features without effect, for which that solver has no answer, are
// listed.
#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>

#include "extended/extended.hpp"
#include "scenes.hpp"
#include "validation/tests/catalogued.hpp"

using namespace atwood;
using namespace atwood::testing;

namespace {

// false: it cannot be added here
struct Addition {
  const char* name;
  std::function<bool(Scenario&)> apply;
};

int first_free(const Scene& scene) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    if (!scene.bodies[i].fixed) return static_cast<int>(i);
  return -1;
}
Body& mover(Scenario& given) { return given.scene.bodies[first_free(given.scene)]; }

Addition force(const char* name, const std::function<Force(int)>& make) {
  return {name, [make](Scenario& given) {
            given.scene.forces.push_back(make(first_free(given.scene)));
            return true;
          }};
}
Addition mutual(const char* name, const std::function<Force(int, int)>& make) {
  return {name, [make](Scenario& given) {
            const int at = first_free(given.scene), other = static_cast<int>(given.scene.bodies.size());
            Body made = point("other", 2, {3, 4, 5}, {0, 0, 0});
            made.charge_C = 1;
            mover(given).charge_C = 1;
            given.scene.bodies.push_back(made);
            given.scene.forces.push_back(make(at, other));
            return true;
          }};
}
Addition body(const char* name, const std::function<void(Body&)>& change) {
  return {name, [change](Scenario& given) {
            change(mover(given));
            return true;
          }};
}
Addition law(const char* name, const std::function<void(PairLaw&)>& change) {
  return {name, [change](Scenario& given) {
            for (PairLaw& pair : given.scene.pairs) change(pair);
            return true;
          }};
}
Addition extra(const char* name, const Body& made) {
  return {name, [made](Scenario& given) {
            given.scene.bodies.push_back(made);
            return true;
          }};
}
Body fixed(Body made, const Shape& shape) {
  made.shape = shape;
  made.fixed = true;
  made.mass_kg = 0;
  made.inertia_kg_m2 = {};
  return made;
}

std::vector<Addition> additions() {
  const Real3 none{0, 0, 0};
  Body far_ball = ball("far", 1, 0.5, {500, 300, 200}, none), moving = point("moving", 0, {9, 9, 9}, {0, 1, 0});
  return {
      // clang-format off
      mutual("gravity", [](int a, int b) { return MutualGravity{{a, b}, 0.5, 0}; }),
      mutual("softened gravity", [](int a, int b) { return MutualGravity{{a, b}, 0.5, 0.1}; }),
      mutual("coulomb", [](int a, int b) { return Coulomb{{a, b}, 0.5}; }),
      mutual("spring between two", [](int a, int b) { return Spring{{a, b}, {}, 3, 0, 1, {}}; }),
      force("attractor", [](int a) { return Attractor{{a}, {5, 6, 7}, 2}; }),
      force("linear drag", [](int a) { return LinearDrag{{a}, 0.3, {}, 0}; }),
      force("wind", [](int a) { return LinearDrag{{a}, 0.3, {0.5, -1, 2}, 0}; }),
      force("angular drag", [](int a) { return LinearDrag{{a}, 0, {}, 0.2}; }),
      force("quadratic drag", [](int a) { return QuadraticDrag{{a}, 1.2, 0.5, 0.1, {}, 0}; }),
      force("quadratic drag in wind", [](int a) { return QuadraticDrag{{a}, 1.2, 0.5, 0.1, {1, 2, 3}, 0}; }),
      force("spring", [](int a) { return Spring{{a}, {1, 2, 3}, 3, 0, 0, {}}; }),
      force("spring with rest length", [](int a) { return Spring{{a}, {1, 2, 3}, 3, 0.1, 1, {}}; }),
      force("spring beside the centre", [](int a) { return Spring{{a}, {1, 2, 3}, 3, 0, 0, {{0, 0.01, 0}}}; }),
      force("drive", [](int a) { return Drive{{a}, {0.5, 0.2, -1}, 2, 0.1}; }),
      force("thruster", [](int a) { return Thruster{a, {}, {1, 0, 0}, 2, {}}; }),
      force("thruster off the centre", [](int a) { return Thruster{a, {0.1, 0.2, 0}, {0, 0, 1}, 2, {{0, 0.25}}}; }),
      force("point-force", [](int a) { return PointForce{a, {0, 0, 0.01}, {1, 0, 0}, {}}; }),
      force("rotating-frame", [](int) { return RotatingFrame{{0, 0, 0.5}}; }),
      force("potential", [](int a) { return Potential{{a}, "henon-heiles", {}}; }),
      // clang-format on
      {"lorentz",
       [](Scenario& given) {
         mover(given).charge_C = -0.5;
         given.scene.forces.push_back(Lorentz{{first_free(given.scene)}, {1, 0, 2}, {0, 3, 1}});
         return true;
       }},
      {"gravity aside",
       [](Scenario& given) {
         given.scene.gravity_m_per_s2[0] += 0.75;
         return true;
       }},
      {"gravity down",
       [](Scenario& given) {
         given.scene.gravity_m_per_s2[2] -= 3;
         return true;
       }},
      {"frames",
       [](Scenario& given) {
         given.frame_ends_s = {given.t_end_s / 3, given.t_end_s};
         return true;
       }},
      {"bare problem",
       [](Scenario& given) {
         given.scene.problem = "lorenz";
         return true;
       }},
      body("release", [](Body& made) { made.release_s = 0.05; }),
      body("charge", [](Body& made) { made.charge_C = 2; }),
      body("negative charge", [](Body& made) { made.charge_C = -2; }),
      body("spin",
           [](Body& made) {
             if (rotates(made)) made.angular_velocity_body_rad_per_s[1] += 0.5;
           }),
      body("slow spin",
           [](Body& made) {
             if (rotates(made)) made.angular_velocity_body_rad_per_s[0] += 1e-17;
           }),
      body("velocity", [](Body& made) { made.velocity_m_per_s[1] += 0.25; }),
      body("slow velocity", [](Body& made) { made.velocity_m_per_s[1] += 1e-17; }),
      body("unequal moments", [](Body& made) { made.inertia_kg_m2[0] *= 1.25; }),
      body("skew moments",
           [](Body& made) {
             if (rotates(made)) made.inertia_kg_m2[1] = made.inertia_kg_m2[3] = 0.1 * made.inertia_kg_m2[0];
           }),
      body("no shape", [](Body& made) { made.shape = Shape(); }),
      body("cylinder",
           [](Body& made) {
             made.shape = Cylinder{0.125, 0.25};
           }),
      body("convex",
           [](Body& made) {
             made.shape = Convex{{{0, 0, 0.1}, {0.1, 0, 0}, {0, 0.1, 0}, {0, 0, -0.1}}};
           }),
      law("linear",
          [](PairLaw& pair) {
            pair.contact_law = ContactLaw::linear, pair.stiffness_N_per_m = 100, pair.damping_N_s_per_m = 1;
          }),
      law("hertz", [](PairLaw& pair) { pair.contact_law = ContactLaw::hertz, pair.modulus_Pa = 1e5; }),
      law("damped hertz",
          [](PairLaw& pair) {
            pair.contact_law = ContactLaw::hertz, pair.modulus_Pa = 1e5, pair.damping_s_per_m = 0.1;
          }),
      law("rolling friction", [](PairLaw& pair) { pair.rolling_friction_m = 0.01; }),
      law("friction", [](PairLaw& pair) { pair.friction = 0.35; }),
      law("restitution", [](PairLaw& pair) { pair.restitution = 0.4; }),
      law("restitution above 1", [](PairLaw& pair) { pair.restitution = 1.5; }),
      extra("a point", point("stray", 1, {40, 50, 60}, {0, 1, 0})),
      extra("a far ball", far_ball),
      extra("a fixed point", fixed(point("pin", 0, {7, 7, 7}, none), Shape())),
      extra("a fixed wall", fixed(point("wall", 0, none, none), Plane{{-1, 0, 0}, -0.3})),
      extra("a fixed box", fixed(point("block", 0, {0.4, 0.1, 0.1}, none), Box{{0.05, 0.05, 0.05}})),
      {"a moving wall",
       [moving](Scenario& given) {
         given.scene.bodies.push_back(moving);
         given.scene.bodies.back().fixed = true;
         given.scene.bodies.back().shape = Box{{1, 1, 1}};
         return true;
       }},
  };
}

// Differs by more than both bars: where, else empty.
std::string differs(const Truth& a, const Truth& b, std::size_t bodies) {
  for (std::size_t k = 0; k < a.values.size(); ++k)
    for (std::size_t i = 0; i < bodies; ++i) {
      const BodySample &x = a.values[k].bodies[i], &y = b.values[k].bodies[i], &p = a.bars[k].bodies[i],
                       &q = b.bars[k].bodies[i];
      for (int j = 0; j < 3; ++j) {
        if (fabsq(x.p_m[j] - y.p_m[j]) > p.p_m[j] + q.p_m[j]) return "position";
        if (fabsq(x.v_m_per_s[j] - y.v_m_per_s[j]) > p.v_m_per_s[j] + q.v_m_per_s[j]) return "velocity";
        if (fabsq(x.w_rad_per_s[j] - y.w_rad_per_s[j]) > p.w_rad_per_s[j] + q.w_rad_per_s[j]) return "spin";
      }
    }
  return "";
}

// Moments of inertia about axes without rotation; more gravity on bodies at rest.
bool idle(const std::string& id, const std::string& name) {
  if (id == "stack-10" && (name == "gravity aside" || name == "gravity down")) return true;
  for (const char* known : {"frames", "charge", "negative charge", "friction", "restitution", "a fixed point",
                            "a fixed wall", "a fixed box", "slow spin", "unequal moments", "skew moments"})
    if (name == known) return true;
  return false;
}

}  // namespace

TEST_CASE("A change of the scene is refused, has no effect, or gives the motion of the certified solver") {
  int answered = 0, refused = 0, unjudged = 0;
  for (const char* id : {"ballistic",
                         "projectile-linear-drag",
                         "terminal-velocity",
                         "oscillator-driven",
                         "kepler-e0.6",
                         "two-body",
                         "coulomb-scattering",
                         "charge-in-b",
                         "asymmetric-top",
                         "thrusters-spin",
                         "bounce-e0.5",
                         "oblique",
                         "slip-to-roll",
                         "slide-30",
                         "head-on",
                         "cradle-apart-1",
                         "friction-cone-0",
                         "struck-rod",
                         "penalty-linear",
                         "penalty-hertz",
                         "stack-10"}) {
    Scenario base = catalogued(id);
    base.t_end_s = std::min(base.t_end_s, 1.0);
    base.samples = 4;
    const Truth plain = closed_form_truth(base, 4);
    INFO(id << ": " << plain.outcome.reason);
    REQUIRE(plain.outcome.status == Status::ok);
    for (const Addition& added : additions()) {
      Scenario given = base;
      if (!added.apply(given)) continue;
      const Truth truth = closed_form_truth(given, 4);
      INFO(id << " with " << added.name << ": " << truth.outcome.reason);
      if (truth.outcome.status != Status::ok) {
        ++refused;
        CHECK(truth.values.empty());
        CHECK(!truth.outcome.reason.empty());
        continue;
      }
      ++answered;
      const Truth certified = extended_truth(given, 4);
      if (certified.outcome.status != Status::ok) {
        ++unjudged;
        // The same answer with a thing as without is right only of what has no effect on a rigid, unmoved contact.
        const bool same = differs(truth, plain, base.scene.bodies.size()).empty();
        INFO("the certified solver: " << certified.outcome.reason);
        CHECK((!same || idle(id, added.name)));
        continue;
      }
      INFO(differs(truth, certified, given.scene.bodies.size()));
      CHECK(differs(truth, certified, given.scene.bodies.size()).empty());
    }
  }
  CHECK(answered > 100);
  CHECK(refused > 500);
  CHECK(unjudged < answered / 4);
}

TEST_CASE("Compliant pairs are refused by every closed form of rigid contact, by name") {
  for (const char* id : {"bounce-e0.5", "oblique", "slip-to-roll", "cradle-apart-1", "friction-cone-0", "struck-rod",
                         "stack-10", "card-house"}) {
    Scenario given = catalogued(id);
    for (PairLaw& pair : given.scene.pairs) pair.contact_law = ContactLaw::linear, pair.stiffness_N_per_m = 100;
    CHECK_THAT(closed_form_truth(given, 4).outcome.reason, Catch::Contains("the contact law `linear` between"));
    for (PairLaw& pair : given.scene.pairs) pair.contact_law = ContactLaw::hertz, pair.modulus_Pa = 1e5;
    CHECK_THAT(closed_form_truth(given, 4).outcome.reason, Catch::Contains("the contact law `hertz` between"));
  }
}
