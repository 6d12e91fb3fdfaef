// A step allocates nothing: operator new is counted.
#include <catch2/catch.hpp>

#include "counted_allocations.hpp"
#include "scenes.hpp"

namespace atwood::testing {
namespace {

template <class S> long allocations_of_steps(const std::string& scheme, const Scene& scene) {
  RigidModel<S> model(scene);
  const auto made = make_stepper(scheme, model);
  if (!made) return made.fault().reason.empty() ? 1 : 0;  // refused by name
  Stepper<S>* const stepper = made->get();
  std::vector<S> y(model.state_size()), y_new(model.state_size()), inside(model.state_size());
  model.initial_state(y.data());
  const long before = allocations;
  bool solved = true;
  for (int n = 0; n < 20; ++n) {
    model.select_interval(S(n) * S(0.01), S(n + 1) * S(0.01));
    solved = stepper->step(S(n) * S(0.01), S(0.01), y.data(), y_new.data()) && solved;
    stepper->dense(S(0.5), inside.data());
    y.swap(y_new);
  }
  const long count = allocations - before;
  REQUIRE(solved);
  return count;
}

TEST_CASE("the counter counts") {
  const long before = allocations;
  const std::vector<double> some(100);
  CHECK(allocations == before + 1);
}

TEST_CASE("steps, dense output and switches allocate nothing") {
  Scene switched = thrust_and_drag();
  std::get<Thruster>(switched.forces[0]).on_s = {{0.05, 0.1}, {0.15, 0.2}};
  for (const MethodInfo& info : integrator_catalogue())
    for (const Scene& scene : {kepler(0.3), quadratic_drag(), e_cross_b(), free_box(), switched}) {
      INFO(info.id);
      const std::string scheme = info.id.substr(7);
      CHECK(allocations_of_steps<float>(scheme, scene) == 0);
      CHECK(allocations_of_steps<double>(scheme, scene) == 0);
      CHECK(allocations_of_steps<long double>(scheme, scene) == 0);
    }
}

}  // namespace
}  // namespace atwood::testing
