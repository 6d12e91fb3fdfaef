// Rates of a batch of states: for every scene of the catalogue, in every scalar, the bits that rate() gives one by one.
#include <catch2/catch.hpp>
#include <cstring>
#include <filesystem>
#include <random>

#include "scene/files.hpp"
#include "scenes.hpp"

namespace atwood::testing {
namespace {

// The value's own bytes: a long double carries padding.
template <class S> bool same_bits(S a, S b) {
  return std::memcmp(&a, &b, sizeof(S) == sizeof(long double) && std::is_same_v<S, long double> ? 10 : sizeof(S)) == 0;
}

template <class S> std::vector<S> random_state(const RigidModel<S>& model, std::mt19937& random) {
  std::vector<S> y(model.state_size());
  model.initial_state(y.data());
  std::uniform_real_distribution<double> near(-0.3, 0.3);
  for (S& scalar : y) scalar += S(near(random)) * (S(1) + real::abs(scalar)) / S(3);
  return y;
}

template <class S>
int wrong_scalars(const Scene& scene, int count, std::mt19937& random, VectorWidth width = widest_vectors()) {
  RigidModel<S> model(scene);
  model.set_vector_width(width);
  if (!model.unsupported().empty()) return 0;
  System<S>& system = model.system();
  int wrong = 0;
  std::vector<double> switches = model.switch_times_s();
  switches.push_back(0);
  for (const double from_s : switches) {
    model.select_interval(S(from_s), S(from_s + 1e-6));
    std::vector<S> t_s, y(system.size * count), dydt(y.size(), S(7)), scratch(2 * system.size), rate(system.size);
    for (int k = 0; k < count; ++k) {
      t_s.push_back(S(0.1) * S(k + 1));
      const std::vector<S> state = random_state(model, random);
      for (int i = 0; i < system.size; ++i) y[i * count + k] = state[i];
    }
    system.rates(count, t_s.data(), y.data(), dydt.data(), scratch.data());
    for (int k = 0; k < count; ++k) {
      for (int i = 0; i < system.size; ++i) scratch[i] = y[i * count + k];
      system.rate(t_s[k], scratch.data(), rate.data());
      for (int i = 0; i < system.size; ++i) wrong += !same_bits(dydt[i * count + k], rate[i]);
    }
  }
  return wrong;
}

// Above it, two sizes of a batch do: with all six, a thousand bodies that attract one another take software arithmetic
// a minute.
constexpr std::size_t kManyBodies = 100;

void check_scene(const std::string& name, const Scene& scene) {
  std::mt19937 random(7);
  const bool many = scene.bodies.size() > kManyBodies;
  for (const int count : many ? std::vector<int>{3, 8} : std::vector<int>{1, 3, 8, 8, 16, 19}) {
    INFO(name << ", " << count << " states");
    CHECK(wrong_scalars<float>(scene, count, random) == 0);
    CHECK(wrong_scalars<double>(scene, count, random) == 0);
    for (const VectorWidth width : {VectorWidth::narrow, VectorWidth::v3}) {
      if (width > widest_vectors()) continue;
      CHECK(wrong_scalars<float>(scene, count, random, width) == 0);
      CHECK(wrong_scalars<double>(scene, count, random, width) == 0);
    }
    if (many && count != 3) continue;
    CHECK(wrong_scalars<long double>(scene, count, random) == 0);
    CHECK(wrong_scalars<Quad>(scene, count, random) == 0);
  }
}

TEST_CASE("a batch of rates has the bits of rates one by one, in every scene of the catalogue, at every vector width") {
  int scenes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(ATWOOD_SCENARIO_DIR)) {
    if (entry.path().extension() != ".toml") continue;
    check_scene(entry.path().filename().string(), read_scenario(entry.path().string()).scene);
    ++scenes;
  }
  CHECK(scenes > 40);
}

// What the catalogue has not: springs between bodies that rotate, an inertia that is not diagonal, a fixed and a held
// body that attract.
TEST_CASE("a batch of rates, for bodies that are fixed, held, joined or askew") {
  Scene joined = thrust_and_drag();
  joined.bodies.push_back(box({0.3, 0.5, 0.6}, {1, 2, -0.4}));
  joined.bodies.back().name = "other";
  joined.bodies.back().position_m = {1, 2, 0.5};
  Spring spring;
  spring.bodies = {0, 1};
  spring.points_body_m = {{0.1, 0, 0.2}, {0, 0.3, 0}};
  spring.stiffness_N_per_m = 11;
  spring.damping_N_s_per_m = 0.7;
  for (const double rest_length_m : {0.0, 0.8}) {
    spring.rest_length_m = rest_length_m;
    Scene scene = joined;
    scene.forces.push_back(spring);
    check_scene("joined boxes", scene);
  }
  Scene stars = kepler(0.3);
  stars.bodies.push_back(point("sun", 3, {0.2, 0.1, 0}, {0, 0, 0}));
  stars.bodies.back().fixed = true;
  stars.bodies.push_back(point("comet", 2, {1.2, 0.7, 0.3}, {0.1, 0, 0}));
  stars.bodies.back().release_s = 0.5;
  MutualGravity gravity;
  gravity.bodies = {0, 1, 2};
  gravity.constant_m3_per_kg_s2 = 1;
  stars.forces.push_back(gravity);
  check_scene("stars", stars);
}

TEST_CASE("a batch counts as many evaluations as it has states") {
  RigidModel<double> model(kepler(0.6));
  std::vector<double> t_s(5), y(30, 1.0), dydt(30), scratch(12);
  model.system().rates(5, t_s.data(), y.data(), dydt.data(), scratch.data());
  CHECK(model.system().evaluations == 5);
}

}  // namespace
}  // namespace atwood::testing
