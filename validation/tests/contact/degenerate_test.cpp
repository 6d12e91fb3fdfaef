// Degenerate placements under `+event`: bodies whose edges, centres or ends lie exactly on each other. Each run ends
// ok, with energy that does not grow and bodies where geometry says, or is refused by name.
#include <catch2/catch.hpp>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "recorded.hpp"

using namespace atwood;
using namespace atwood::recorded;

namespace {

constexpr double g = 9.8125;
const std::string method = "atwood/rk4+event";

Body cylinder(const std::string& name, double r, double l, const Real3& at, const Real3& velocity = {},
              const Real3& spin = {}) {
  const double across = r * r / 4 + l * l / 3;
  return moving(name, Cylinder{r, l}, 1, {across, across, r * r / 2}, at, velocity, spin);
}
Body capsule(const std::string& name, double r, double l, const Real3& at) {
  return moving(name, Capsule{r, l}, 1, {0.03, 0.03, 0.01}, at);
}
Body turned(Body body, const Real3& axis, double angle) {
  const double s = std::sin(angle / 2);
  body.orientation_wxyz = {std::cos(angle / 2), s * axis[0], s * axis[1], s * axis[2]};
  return body;
}

// A table with its face at z = 1/2 and its rim at |x| = |y| = 1/2 on a floor.
Scene on_table(double e, double mu, const std::vector<Body>& bodies) {
  Scene scene = world({0, 0, -g}, e, mu);
  scene.bodies = {fixed("floor", Plane{{0, 0, 1}, 0}), fixed("table", Box{{0.5, 0.5, 0.25}}, {0, 0, 0.25})};
  scene.bodies.insert(scene.bodies.end(), bodies.begin(), bodies.end());
  return scene;
}

double energy(const Scene& scene, const Sample& sample) {
  double all = 0;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    if (body.fixed) continue;
    const Real3 p = Recorded::doubles(sample.bodies[i].p_m), v = Recorded::doubles(sample.bodies[i].v_m_per_s),
                w = Recorded::doubles(sample.bodies[i].w_rad_per_s);
    for (int k = 0; k < 3; ++k) all += body.mass_kg * v[k] * v[k] / 2 + body.inertia_kg_m2[4 * k] * w[k] * w[k] / 2;
    all += body.mass_kg * g * p[2];
  }
  return all;
}

// Runs for a second, and checks that no sample has more energy than an earlier one.
Recorded passive(const Scene& scene) {
  const Recorded it = run(method, scene, {1, 128, 128});
  double least = energy(scene, it.samples.front());
  for (const Sample& sample : it.samples) {
    const double now = energy(scene, sample);
    CHECK(now <= least + 1e-12);
    least = std::min(least, now);
  }
  return it;
}

struct Law {
  double e, mu;
};
const Law laws[] = {{0, 0}, {0, 0.5}, {0.5, 0.25}, {1, 0}};
void each_law(const std::function<void(double e, double mu)>& visit) {
  for (const Law& law : laws) {
    INFO("e = " << law.e << ", mu = " << law.mu);
    visit(law.e, law.mu);
  }
}

std::string refusal(const Scene& scene) {
  const Recorded it = try_run(method, scene, {1, 128, 128});
  CHECK(it.outcome.status == Status::unsupported);
  return it.outcome.reason;
}

}  // namespace

TEST_CASE("what passes a rim at a gap of exactly zero falls past it, as alone") {
  each_law([](double e, double mu) {
    for (const Body& body :
         {box("b", 1, {0.25, 0.25, 0.125}, {0.75, 0, 0.75}), box("b", 1, {0.25, 0.25, 0.125}, {0.75, 0.75, 0.75}),
          cylinder("b", 0.25, 0.125, {0.75, 0, 0.75}), ball("b", 1, 0.25, {0.75, 0, 0.75}),
          turned(capsule("b", 0.125, 0.25, {0.625, 0, 0.75}), {1, 0, 0}, M_PI / 2)}) {
      INFO("shape " << body.shape.index());
      Scene alone = world({0, 0, -g}, e, mu);
      alone.bodies = {fixed("floor", Plane{{0, 0, 1}, 0}), body};
      const Recorded beside = passive(on_table(e, mu, {body})), free = run(method, alone, {1, 128, 128});
      for (int k = 0; k < 3; ++k) CHECK(std::abs(beside.p(2)[k] - free.p(1)[k]) < 1e-12);
    }
  });
}

TEST_CASE("what lies over a rim with its middle exactly on it, or flush with it, stays on the face") {
  each_law([](double e, double mu) {
    for (const Body& body :
         {box("b", 1, {0.25, 0.25, 0.125}, {0.5, 0, 0.75}), box("b", 1, {0.5, 0.5, 0.125}, {0, 0, 0.75}),
          turned(capsule("b", 0.125, 0.25, {0.5, 0, 0.75}), {1, 0, 0}, M_PI / 2),
          turned(capsule("b", 0.125, 0.5, {0, 0, 0.75}), {0, 1, 0}, M_PI / 2),
          cylinder("b", 0.5, 0.125, {0, 0, 0.75})}) {
      INFO("shape " << body.shape.index() << " at " << body.position_m[0]);
      const Recorded it = passive(on_table(e, mu, {body}));
      for (const Sample& sample : it.samples) CHECK(Recorded::doubles(sample.bodies[2].p_m)[2] >= 0.625 - 1e-14);
      if (e < 1) CHECK(std::abs(it.p(2)[2] - 0.625) < 1e-12);
    }
  });
}

TEST_CASE("a slot without play lets its body through") {
  each_law([](double e, double mu) {
    Scene slot = world({0, 0, -g}, e, mu);
    slot.bodies = {fixed("floor", Plane{{0, 0, 1}, 0}), fixed("left", Box{{0.25, 0.5, 0.5}}, {-0.5, 0, 0.5}),
                   fixed("right", Box{{0.25, 0.5, 0.5}}, {0.5, 0, 0.5}), ball("b", 1, 0.25, {0, 0, 0.75})};
    CHECK(std::abs(passive(slot).p(3)[0]) < 1e-14);
    slot.bodies[3] = box("b", 1, {0.25, 0.25, 0.125}, {0, 0, 0.75});
    CHECK(std::abs(passive(slot).p(3)[0]) < 1e-14);
  });
}

TEST_CASE("edges that are exactly parallel, and polyhedra over a rim, are refused by name") {
  const Scene diamond =
      on_table(0.5, 0.25, {turned(box("b", 1, {0.25, 0.25, 0.25}, {0.5, 0, 1}), {0, 1, 0}, M_PI / 4)});
  CHECK(refusal(diamond).find("box `b` with the end of box `table`") != std::string::npos);
  const Body wedge = moving("t", Convex{{{0, 0, 0.25}, {0.5, 0, -0.125}, {-0.25, 0.5, -0.125}, {-0.25, -0.5, -0.125}}},
                            1, {0.03, 0.03, 0.03}, {0.5, 0, 0.875});
  CHECK(refusal(on_table(0.5, 0.25, {wedge})).find("convex `t` with the end of box `table`") != std::string::npos);
}

// The centre of a flat circle stood for the whole of it, wherever the table ended.
TEST_CASE("a cylinder whose middle is beyond the rim does not stand there") {
  each_law([](double e, double mu) {
    const double s = std::sqrt(0.5);
    for (const double inside : {0.2, 0.1, 1e-3, 1e-9}) {
      INFO("over the rim by " << inside);
      const double aside = 0.75 - inside, corner = 0.5 + s * (0.25 - inside);
      for (const Real3& at : {Real3{aside, 0, 0.75}, Real3{corner, corner, 0.75}})
        CHECK(refusal(on_table(e, mu, {cylinder("c", 0.25, 0.125, at)}))
                  .find("with the end of box `table`, over which") != std::string::npos);
    }
    const double touches = 0.5 + s * 0.25;  // its rim is exactly on the table's corner
    passive(on_table(e, mu, {cylinder("c", 0.25, 0.125, {touches, touches, 0.75})}));
  });
}

TEST_CASE("an end of a cylinder that lies flat is one contact only where its centre stands for the circle") {
  const auto on_floor = [](double mu, const Body& body, double aside = 0) {
    Scene scene = world({aside, 0, -g}, 0, mu);
    scene.bodies = {fixed("floor", Plane{{0, 0, 1}, 0}), body};
    return scene;
  };
  const std::string flat = "an end of cylinder `c` lies flat on plane `floor`";
  const double r = 0.25, l = 0.125;
  // It rests; without friction it slides and spins freely.
  CHECK(std::abs(run(method, on_floor(0.5, cylinder("c", r, l, {0, 0, 1})), {1, 128, 1}).p(1)[2] - l) < 1e-14);
  const Recorded puck = run(method, on_floor(0, cylinder("c", r, l, {0, 0, l}, {1, 0, 0}, {0, 0, 3})), {1, 128, 1});
  CHECK(std::abs(puck.p(1)[0] - 1) < 1e-14);
  CHECK(std::abs(puck.p(1)[2] - l) < 1e-14);
  CHECK(puck.w(1)[2] == 3);
  // Friction acts on all points of the end.
  CHECK(refusal(on_floor(0.25, cylinder("c", r, l, {0, 0, l}, {1, 0, 0}))).find(flat) != std::string::npos);
  CHECK(refusal(on_floor(0.25, cylinder("c", r, l, {0, 0, l}, {}, {0, 0, 3}))).find(flat) != std::string::npos);
  CHECK(refusal(on_floor(0.5, cylinder("c", r, l, {0, 0, l}), 1)).find(flat) != std::string::npos);
  // It falls onto its rim, and over it onto the end.
  const Recorded falls =
      try_run(method, on_floor(0.25, turned(cylinder("c", r, l, {0, 0, 0.75}), {1, 0, 0}, 0.3)), {1, 128, 128});
  CHECK(falls.outcome.status == Status::unsupported);
  CHECK(falls.outcome.reason.find(flat) != std::string::npos);
  REQUIRE(falls.count(EventKind::impact) >= 1);
  CHECK(falls.samples.size() > 40);
}

// The axis and the face's normal are then parallel to round-off only.
TEST_CASE("a cylinder stands on the face of a turned or tilted box as on an upright one") {
  const double r = 0.25, l = 0.125, half = 0.5;
  const Real3 axes[] = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {std::sqrt(0.5), std::sqrt(0.5), 0}};
  for (const Real3& axis : axes)
    for (const double angle : {0.1, 0.3, 0.7, M_PI / 4, 1.0, M_PI / 2, 2.5}) {
      const double c = std::cos(angle), s = std::sin(angle);
      // The box's z axis; the cylinder's centre is above its face by l.
      const Real3 up = {axis[1] * s, -axis[0] * s, axis[2] == 1 ? 1 : c};
      const double high = half + l;
      Body standing = turned(cylinder("c", r, l, {high * up[0], high * up[1], high * up[2]}), axis, angle);
      const double half_spin = 0.4, w = std::cos(half_spin), z = std::sin(half_spin);  // and about its own axis
      const Real4 q = standing.orientation_wxyz;
      standing.orientation_wxyz = {q[0] * w - q[3] * z, q[1] * w + q[2] * z, q[2] * w - q[1] * z, q[3] * w + q[0] * z};
      const Body table = turned(fixed("table", Box{{1, 1, half}}, {0, 0, 0}), axis, angle);
      INFO("axis " << axis[0] << " " << axis[1] << " " << axis[2] << ", angle " << angle);
      // Gravity along the face's normal: it rests, with friction too.
      Scene scene = world({-g * up[0], -g * up[1], -g * up[2]}, 0, 0.5);
      scene.bodies = {table, standing};
      const Recorded rests = try_run(method, scene, {1, 128, 1});
      CHECK(rests.outcome.reason == "");
      if (rests.outcome.status == Status::ok)
        for (int k = 0; k < 3; ++k) CHECK(std::abs(rests.p(1)[k] - high * up[k]) < 1e-13);
      // Straight down and without friction: it slides with the part of gravity along the face.
      if (up[2] < 0.7) continue;
      scene = world({0, 0, -g}, 0, 0);
      scene.bodies = {table, standing};
      const Recorded slides = try_run(method, scene, {0.25, 128, 1});
      CHECK(slides.outcome.reason == "");
      if (slides.outcome.status != Status::ok) continue;
      for (int k = 0; k < 3; ++k) {
        const double along = (k == 2 ? -g : 0) + g * up[2] * up[k];
        CHECK(std::abs(slides.p(1)[k] - high * up[k] - along * 0.25 * 0.25 / 2) < 1e-13);
      }
    }
}

TEST_CASE("bodies that overlap without a side to come apart are refused, others are held as they are") {
  Scene scene = world({0, 0, -g}, 0.5, 0.25);
  const auto reason = [&](const Body& a, const Body& b) {
    scene.bodies = {a, b};
    return refusal(scene);
  };
  const std::string text = "overlap symmetrically: the contact normal is not unique";
  const Body sphere = ball("b", 1, 0.25, {0, 0, 1}), block = box("a", 1, {0.5, 0.5, 0.5}, {0, 0, 1});
  CHECK(reason(ball("a", 1, 0.25, {0, 0, 1}), sphere) ==
        "atwood's +event: at t = 0 s sphere `a` and sphere `b` " + text);
  CHECK(reason(ball("a", 2, 0.5, {0, 0, 1}), sphere).find(text) != std::string::npos);
  CHECK(reason(capsule("a", 0.25, 0.5, {0, 0, 1.25}), sphere).find(text) != std::string::npos);
  CHECK(reason(block, sphere).find(text) != std::string::npos);
  CHECK(reason(block, box("b", 1, {0.25, 0.25, 0.25}, {0, 0, 1})).find(text) != std::string::npos);
  CHECK(reason(fixed("a", Rectangle{{0.5, 0.5}}, {0, 0, 1}), sphere).find(text) != std::string::npos);
  scene.bodies = {ball("a", 1, 0.25, {0.125, 0, 1}), sphere};
  CHECK(std::abs(run(method, scene, {1, 128, 1}).p(0)[0] - 0.125) < 1e-14);
}
