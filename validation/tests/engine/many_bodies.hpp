// Clouds of bodies for tests: random, clustered, coincident.
#pragma once

#include "forces/gravity_pairs.hpp"
#include "scene/split_mix.hpp"
#include "scenes.hpp"

namespace atwood::testing {

inline double between(SplitMix64& random, double low, double high) { return low + (high - low) * random.next_unit(); }

inline Real3 anywhere(SplitMix64& random, double half_m) {
  const double x = between(random, -half_m, half_m), y = between(random, -half_m, half_m);
  return {x, y, between(random, -half_m, half_m)};
}

inline Scene pulled(Scene scene, double softening_m) {
  MutualGravity gravity;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) gravity.bodies.push_back(static_cast<int>(i));
  gravity.constant_m3_per_kg_s2 = 1;
  gravity.softening_m = softening_m;
  scene.forces.push_back(gravity);
  return scene;
}

inline Scene random_cloud(int count, std::uint64_t seed, double softening_m = 0) {
  Scene scene = empty_scene();
  SplitMix64 random{seed};
  for (int i = 0; i < count; ++i) {
    const double mass_kg = between(random, 0.1, 2);
    const Real3 p = anywhere(random, 1), v = anywhere(random, 0.1);
    scene.bodies.push_back(point("body." + std::to_string(i), mass_kg, p, v));
  }
  return pulled(scene, softening_m);
}

// A few dense knots far apart: distances from 1e-6 to 1e3.
inline Scene clustered_cloud(int count, std::uint64_t seed, double softening_m = 0) {
  Scene scene = random_cloud(count, seed);
  scene.forces.clear();
  SplitMix64 random{seed + 1};
  for (int i = 0; i < count; ++i) {
    const double knot = i % 5, size_m = 1e-6 * std::pow(10.0, knot);
    const Real3 offset = anywhere(random, size_m);
    scene.bodies[i].position_m = {500 * std::cos(1.3 * knot) + offset[0], 500 * std::sin(1.3 * knot) + offset[1],
                                  offset[2]};
  }
  return pulled(scene, softening_m);
}

// Every body shares its place with another.
inline Scene coincident_cloud(int count, std::uint64_t seed, double softening_m) {
  Scene scene = random_cloud(count, seed);
  scene.forces.clear();
  for (int i = 1; i < count; i += 2) scene.bodies[i].position_m = scene.bodies[i - 1].position_m;
  return pulled(scene, softening_m);
}

// v' of every body as the engine's model gives it.
template <class S> std::vector<Vec3<S>> model_accelerations(const Scene& scene, const ModelOptions& options = {}) {
  RigidModel<S> model(scene, options);
  std::vector<S> y(model.state_size()), rate(model.state_size());
  model.initial_state(y.data());
  model.system().rate(S(0), y.data(), rate.data());
  std::vector<Vec3<S>> a(model.body_count());
  for (int i = 0; i < model.body_count(); ++i)
    if (model.offset(i) >= 0) a[i] = load3(rate.data() + model.offset(i) + kAtVelocity);
  return a;
}

template <class S> bool same_bits(const std::vector<Vec3<S>>& a, const std::vector<Vec3<S>>& b) {
  const auto same = [](const Vec3<S>& u, const Vec3<S>& v) { return u.x == v.x && u.y == v.y && u.z == v.z; };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), same);
}

inline std::vector<VectorWidth> widths_here() {
  std::vector<VectorWidth> widths{VectorWidth::narrow};
  if (widest_vectors() >= VectorWidth::v3) widths.push_back(VectorWidth::v3);
  if (widest_vectors() >= VectorWidth::v4) widths.push_back(VectorWidth::v4);
  return widths;
}

}  // namespace atwood::testing
