// The catalogue's smooth problems as scenes, built in place so that these tests stand without files.
#pragma once

#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace atwood::scenes {

inline Body point(std::string name, double mass_kg, Real3 p, Real3 v) {
  Body body;
  body.name = std::move(name);
  body.mass_kg = mass_kg;
  body.position_m = p;
  body.velocity_m_per_s = v;
  return body;
}

inline std::vector<int> all(const Scene& scene) {
  std::vector<int> bodies;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) bodies.push_back(static_cast<int>(i));
  return bodies;
}

inline Scene empty_scene() {
  Scene scene;
  scene.materials.push_back({"plain", 0, 0, 0});
  scene.pairs.push_back({0, 0, 0, 0, 0});
  return scene;
}

inline Scenario scenario(Scene scene, double t_end_s) {
  Scenario made;
  made.scene = std::move(scene);
  made.t_end_s = t_end_s;
  made.truth.kind = TruthKind::extended;
  return made;
}

inline Scenario pleiades() {
  Scene scene = empty_scene();
  const double x[] = {3, 3, -1, -3, 2, -2, 2}, y[] = {3, -3, 2, 0, 0, -4, 4};
  const double u[] = {0, 0, 0, 0, 0, 1.75, -1.5}, v[] = {0, 0, 0, -1.25, 1, 0, 0};
  for (int i = 0; i < 7; ++i)
    scene.bodies.push_back(point("star" + std::to_string(i), i + 1, {x[i], y[i], 0}, {u[i], v[i], 0}));
  scene.forces.push_back(MutualGravity{all(scene), 1, 0});
  return scenario(scene, 3);
}

inline Scenario kepler(double e, double t_end_s) {
  Scene scene = empty_scene();
  scene.bodies.push_back(point("planet", 1, {1 - e, 0, 0}, {0, e == 0.6 ? 2.0 : 1.0, 0}));
  scene.forces.push_back(Attractor{{0}, {0, 0, 0}, 1});
  return scenario(scene, t_end_s);
}

inline Scenario arenstorf(double vy, double t_end_s) {
  const double mu = 0.012277471;
  Scene scene = empty_scene();
  scene.bodies.push_back(point("satellite", 1, {0.994, 0, 0}, {0, vy, 0}));
  scene.forces.push_back(Attractor{{0}, {-mu, 0, 0}, 1 - mu});
  scene.forces.push_back(Attractor{{0}, {1 - mu, 0, 0}, mu});
  scene.forces.push_back(RotatingFrame{{0, 0, 1}});
  return scenario(scene, t_end_s);
}

inline Scenario figure_eight() {
  const double x = 9.7000435669733343994349692832442e-01, y = -2.4308753153584886171573983825582e-01;
  const double vx = -9.3240737144105230154823176400484e-01, vy = -8.6473146092100595637465906875124e-01;
  Scene scene = empty_scene();
  scene.bodies = {point("a", 1, {x, y, 0}, {-vx / 2, -vy / 2, 0}), point("b", 1, {-x, -y, 0}, {-vx / 2, -vy / 2, 0}),
                  point("c", 1, {0, 0, 0}, {vx, vy, 0})};
  scene.forces.push_back(MutualGravity{all(scene), 1, 0});
  return scenario(scene, 6.3259139829262116775890003339705e+00);
}

inline Scenario henon_heiles(double t_end_s) {
  Scene scene = empty_scene();
  scene.bodies.push_back(point("star", 1, {0.1, 0, 0}, {0, 0.5, 0}));
  scene.forces.push_back(Potential{{0}, "henon-heiles", {}});
  return scenario(scene, t_end_s);
}

inline Scenario outer_solar_system() {
  Scene scene = empty_scene();
  scene.bodies = {
      point("sun", 1, {0, 0, 0}, {0, 0, 0}),
      point("jupiter", 0.000954786104043, {-3.5023653, -3.8169847, -1.5507963}, {0.00565429, -0.00412490, -0.00190589}),
      point("saturn", 0.000285583733151, {9.0755314, -3.0458353, -1.6483708}, {0.00168318, 0.00483525, 0.00192462}),
      point("uranus", 0.0000437273164546, {8.3101420, -16.2901086, -7.2521278}, {0.00354178, 0.00137102, 0.00055029}),
      point("neptune", 0.0000517759138449, {11.4707666, -25.7294829, -10.8169456},
            {0.00288930, 0.00114527, 0.00039677}),
      point("pluto", 1 / 1.3e8, {-15.5387357, -25.2225594, -3.1902382}, {0.00276725, -0.00170702, -0.00136504})};
  scene.forces.push_back(MutualGravity{all(scene), 2.95912208286e-4, 0});
  return scenario(scene, 200000);
}

inline Scenario lorenz(double t_end_s) {
  Scene scene = empty_scene();
  scene.problem = "lorenz";
  scene.bodies.push_back(point("lorenz", 1, {1, 0, 0}, {0, 0, 0}));
  return scenario(scene, t_end_s);
}

inline Body solid(std::string name, double mass_kg, Real3 I, Real3 w) {
  Body body = point(std::move(name), mass_kg, {0, 0, 0}, {0, 0, 0});
  body.inertia_kg_m2 = {I[0], 0, 0, 0, I[1], 0, 0, 0, I[2]};
  body.angular_velocity_body_rad_per_s = w;
  return body;
}

inline Scenario asymmetric_top(Real3 w, double t_end_s) {
  Scene scene = empty_scene();
  scene.bodies.push_back(solid("top", 1, {0.6, 0.8, 1.0}, w));
  return scenario(scene, t_end_s);
}

// A tumbling ship whose thrusters fire in turn.
inline Scenario thrusters() {
  Scene scene = empty_scene();
  scene.bodies.push_back(solid("ship", 100, {40, 60, 80}, {0.1, 0.05, -0.1}));
  scene.forces = {Thruster{0, {0, 0, -1}, {0, 0, 1}, 50, {{0, 2}, {5, 6}}},
                  Thruster{0, {1, 0, 0}, {0, 1, 0}, 5, {{1, 2}}}, Thruster{0, {-1, 0, 0}, {0, 1, 0}, 5, {{3, 4}}},
                  Thruster{0, {0, 1, 0}, {0, 0, 1}, 5, {{2, 3}, {7, 8}}}};
  return scenario(scene, 10);
}

// A ball above the ground; gravity alone, or with quadratic drag.
inline Scenario bounce(double restitution, double clearance_m, bool drag, double t_end_s) {
  Scene scene = empty_scene();
  scene.gravity_m_per_s2 = {0, 0, -9.81};
  scene.materials[0].restitution = scene.pairs[0].restitution = restitution;
  Body ground;
  ground.name = "ground";
  ground.fixed = true;
  ground.shape = Plane{{0, 0, 1}, 0};
  Body ball = solid("ball", 0.5, {0.002, 0.002, 0.002}, {0, 0, 0});
  ball.position_m = {0, 0, 0.125 + clearance_m};
  ball.shape = Sphere{0.125};
  scene.bodies = {ground, ball};
  if (drag) scene.forces.push_back(QuadraticDrag{{1}, 1.2, 0.47, 0.05, {0, 0, 0}, 0});
  return scenario(scene, t_end_s);
}

}  // namespace atwood::scenes
