// Steps of many bodies allocate nothing either: pairs, the tree, free flight, with one thread and with two.
#include <catch2/catch.hpp>

#include "counted_allocations.hpp"
#include "integrators/free_flight.hpp"
#include "many_bodies.hpp"

namespace atwood::testing {
namespace {

long allocations_of_rates(GravityOptions::Sum sum, int threads) {
  ModelOptions options;
  options.gravity.sum = sum;
  options.threads = threads;
  RigidModel<double> model(random_cloud(500, 3, 1e-2), options);
  std::vector<double> y(model.state_size()), rate(model.state_size());
  model.initial_state(y.data());
  const long before = allocations;
  for (int n = 0; n < 5; ++n) {
    model.system().rate(0, y.data(), rate.data());
    for (std::size_t i = 0; i < y.size(); ++i) y[i] += 1e-3 * rate[i];  // another tree each time
  }
  return allocations - before;
}

TEST_CASE("gravity of many bodies allocates nothing") {
  for (const int threads : {1, 2}) {
    CHECK(allocations_of_rates(GravityOptions::Sum::direct, threads) == 0);
    CHECK(allocations_of_rates(GravityOptions::Sum::tree, threads) == 0);
  }
}

TEST_CASE("free flight allocates nothing") {
  Scene scene = random_cloud(200, 1);
  scene.forces.clear();
  for (std::size_t i = 0; i < scene.bodies.size(); i += 2)
    scene.bodies[i].inertia_kg_m2 = {1, 0, 0, 0, 2, 0, 0, 0, 1.5};
  for (const char* method : {"atwood/rk4", "atwood/dopri5{threads=2}"}) {
    auto simulation = prepare<double>(parse_method_id(method), scene);
    REQUIRE(simulation.free_flight != nullptr);
    const long before = allocations;
    simulation.free_flight->march(1e-3, 20, simulation.y.data());
    simulation.free_flight->march(1e-3, 20, simulation.y.data());
    CHECK(allocations - before == 0);
  }
}

}  // namespace
}  // namespace atwood::testing
