// A change of units changes nothing but units. Scaled by powers of two, lengths, times and masses keep their digits,
// and so does each operation on them: the motion of `+event` is then the same to the last bit. A threshold that is
// absolute, or that compares quantities of different dimensions, shows as a different digit, impact or contact.
#include <catch2/catch.hpp>

#include <cmath>

#include "recorded.hpp"

using namespace atwood;
using namespace atwood::recorded;

namespace {

constexpr double kWeight = 9.81;

struct Units {
  double m, s, kg;  // powers of two; of m the exponent is even where speeds and accelerations need square roots
};

void scale(Real3& v, double by) {
  for (double& x : v) x *= by;
}
Shape in_units(Shape shape, double m) {
  if (auto* ball = std::get_if<Sphere>(&shape)) ball->radius_m *= m;
  if (auto* box = std::get_if<Box>(&shape)) scale(box->half_extents_m, m);
  if (auto* plane = std::get_if<Plane>(&shape)) plane->offset_m *= m;
  if (auto* sheet = std::get_if<Rectangle>(&shape))
    for (double& x : sheet->half_extents_m) x *= m;
  if (auto* capsule = std::get_if<Capsule>(&shape)) capsule->radius_m *= m, capsule->half_length_m *= m;
  if (auto* cylinder = std::get_if<Cylinder>(&shape)) cylinder->radius_m *= m, cylinder->half_length_m *= m;
  if (auto* mesh = std::get_if<Mesh>(&shape))
    for (Real3& point : mesh->points_m) scale(point, m);
  return shape;
}
Scene in_units(Scene scene, const Units& u) {
  scale(scene.gravity_m_per_s2, u.m / (u.s * u.s));
  for (Material& material : scene.materials) material.rolling_friction_m *= u.m;
  for (PairLaw& law : scene.pairs) law.rolling_friction_m *= u.m;
  for (Body& body : scene.bodies) {
    body.shape = in_units(body.shape, u.m);
    body.mass_kg *= u.kg;
    for (double& I : body.inertia_kg_m2) I *= u.kg * u.m * u.m;
    scale(body.position_m, u.m);
    scale(body.velocity_m_per_s, u.m / u.s);
    scale(body.angular_velocity_body_rad_per_s, 1 / u.s);
  }
  return scene;
}

struct Case {
  std::string name;
  Scene scene;
  double t_end_s;
  int steps;
  double round_off = 0;  // relative, where the order of operations may depend on units
};

Scene with_floor(double restitution, double friction, const Body& body) {
  Scene scene = world({0, 0, -kWeight}, restitution, friction);
  scene.bodies = {fixed("floor", Plane{}), body};
  return scene;
}

// A box over a tilted table, which it strikes with a spin; each axis of the world has its part of gravity.
Case elastic_box() {
  Scene scene = world({1.5469353883678236, 9.534331476448253, -1.7145303151077078}, 1, 0.2);
  const Real4 tilt = {0.6739426779648875, 0.5085707999067074, -0.39238867882344786, 0.36494949380833047};
  scene.bodies = {
      fixed("table", Box{{1, 0.5, 0.1}}, {0.015768964203545604, 0.09718992330732164, -0.017477373242688166}),
      box("die", 2, {0.1783235723696675, 0.1781311580803987, 0.13184175373615267},
          {0.31734040026775545, -0.09254338457631758, 0.5260527545265115},
          {1.9966073003798208, 0.23934122119045265, 3.1323919916233156})};
  scene.bodies[1].angular_velocity_body_rad_per_s = {0, 0, 0.4704141378888762};
  for (Body& body : scene.bodies) body.orientation_wxyz = tilt;
  return {"an elastic box on a tilted table", scene, 1, 128};
}

std::vector<Case> cases() {
  std::vector<Case> all = {elastic_box()};
  const Real3 half = {0.3410225824064568, 0.3446571020343868, 0.18727663875711126};
  Scene slides = world({0, 0, -kWeight}, 0.5, 0.2);
  slides.bodies = {
      box("top", 2, half, {0.6, -0.002286732986194251, half[2]}, {3.2689239198943505, -0.3355387256285536, 0}),
      fixed("table", Box{{1, 0.5, 0.1}}, {0, 0, -0.1})};
  slides.bodies[0].angular_velocity_body_rad_per_s = {0, 0, -0.2010459200479744};
  all.push_back({"a box that slides off a table", slides, 0.6, 100});
  Body die = box("die", 1, {0.1, 0.13, 0.2}, {0, 0, 0.6}, {0.7, 0.1, -1});
  die.angular_velocity_body_rad_per_s = {3, -7, 2};
  all.push_back({"a die that tumbles on a floor", with_floor(0.5, 0.3, die), 1, 100});
  Body marble = ball("marble", 0.5, 0.02, {0, 0, 0.02}, {0.5, 0, 0}, {0, -90, 12});
  Scene rolls = with_floor(0.5, 0.3, marble);
  rolls.pairs[0].rolling_friction_m = rolls.materials[0].rolling_friction_m = 0.001;
  // Rows of forces and couples are pivoted by size, in whatever units.
  all.push_back({"a marble that slips, rolls and stops", rolls, 2, 100, 1e-14});
  const Body coin =
      moving("coin", Cylinder{0.1, 0.01}, 1, {0.0025, 0.0025, 0.005}, {0, 0, 0.2}, {0.3, 0, 0}, {2, 5, 1});
  all.push_back({"a coin on its rim", with_floor(0, 0.5, coin), 0.3, 100});
  Scene stack = with_floor(0, 0.4, box("low", 3, {0.2, 0.2, 0.1}, {0, 0, 0.1}, {0.6, 0, 0}));
  stack.bodies.push_back(box("high", 1, {0.1, 0.1, 0.1}, {0.02, 0, 0.3}, {0.2, 0, 0}));
  all.push_back({"a stack whose boxes slide on each other", stack, 0.5, 100});
  return all;
}

double as_double(Wide x) { return static_cast<double>(x); }

}  // namespace

TEST_CASE("a change of units changes no digit of a motion with contacts") {
  for (const Case& it : cases())
    for (const char* method : {"atwood/rk4+event", "atwood/dopri5+event{restitution=poisson}"}) {
      const Recorded metres = try_run(method, it.scene, {it.t_end_s, it.steps, it.steps});
      // Micrometres and megametres under the same gravity; micrometres and kilometres with the same times.
      for (const Units& u : {Units{0x1p-20, 0x1p-10, 1}, Units{0x1p20, 0x1p10, 0x1p-12}, Units{0x1p-20, 1, 0x1p6},
                             Units{0x1p10, 1, 1}, Units{1, 0x1p-8, 1}}) {
        const Recorded other = try_run(method, in_units(it.scene, u), {it.t_end_s * u.s, it.steps, it.steps});
        INFO(it.name << ", " << method << ", " << u.m << " m, " << u.s << " s, " << u.kg
                     << " kg: " << metres.outcome.reason << "; " << other.outcome.reason);
        CHECK(other.outcome.status == metres.outcome.status);
        CHECK(other.outcome.steps_taken == metres.outcome.steps_taken);
        REQUIRE(other.samples.size() == metres.samples.size());
        int differ = 0;
        double first_s = -1;
        const auto same = [&](Wide a, double unit, Wide b) {
          return std::abs(as_double(b) - as_double(a) * unit) <= it.round_off * unit;
        };
        for (std::size_t k = 0; k < metres.samples.size(); ++k)
          for (std::size_t i = 0; i < it.scene.bodies.size(); ++i) {
            const BodySample &a = metres.samples[k].bodies[i], &b = other.samples[k].bodies[i];
            for (std::size_t c = 0; c < 3; ++c) {
              const bool all = same(a.p_m[c], u.m, b.p_m[c]) && same(a.v_m_per_s[c], u.m / u.s, b.v_m_per_s[c]) &&
                               same(a.w_rad_per_s[c], 1 / u.s, b.w_rad_per_s[c]);
              differ += !all;
              if (!all && first_s < 0) first_s = as_double(metres.samples[k].t_s);
            }
          }
        INFO("first at t = " << first_s << " s");
        CHECK(differ == 0);
        REQUIRE(other.events.size() == metres.events.size());
        for (std::size_t k = 0; k < metres.events.size(); ++k) {
          CHECK(other.events[k].kind == metres.events[k].kind);
          CHECK(same(metres.events[k].t_s, u.s, other.events[k].t_s));
        }
      }
    }
}

// Beyond the table's end, the box lies on more contacts, of vertices and of crossing edges, than determine its forces:
// they agree only where the box lies flat, which the stages of an implicit method do not keep to the last digit. A
// whole step has no solution then, a shorter one has.
TEST_CASE("an implicit step with redundant contacts is halved until it is solved") {
  const Case it = elastic_box();
  const Recorded implicit = run("atwood/gauss6+event", it.scene, {it.t_end_s, 512, 512}),
                 plain = run("atwood/rk4+event", it.scene, {it.t_end_s, 512, 512});
  REQUIRE(implicit.events.size() == plain.events.size());
  for (std::size_t k = 0; k < plain.events.size(); ++k)
    CHECK(std::abs(as_double(implicit.events[k].t_s - plain.events[k].t_s)) < 1e-4);
  for (std::size_t i = 0; i < it.scene.bodies.size(); ++i)
    for (int k = 0; k < 3; ++k) CHECK(std::abs(implicit.p(i)[k] - plain.p(i)[k]) < 1e-5);
}
