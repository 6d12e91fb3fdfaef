// Derivatives of forward dynamics by dual numbers, against differences in quad; and what differences in double reach.
#include <catch2/catch.hpp>

#include "joints/derivatives.hpp"
#include "joints/differences.hpp"
#include "joints/tree.hpp"
#include "mechanisms.hpp"

namespace atwood::testing {
namespace {

TreeState layout_of(const Scene& scene) {
  RigidModel<double> model(scene);
  INFO(model.unsupported());
  REQUIRE(model.unsupported().empty());
  TreeState layout;
  for (int i = 0; i < model.body_count(); ++i) layout.offsets.push_back(model.offset(i));
  layout.first_free = model.tree()->scalars_at();
  layout.y.resize(model.state_size());
  model.initial_state(layout.y.data());
  return layout;
}

AccelerationDerivatives by_duals(const Scene& scene, const TreeState& layout) {
  return acceleration_derivatives(scene, layout.offsets, layout.first_free, layout.y.data(),
                                  static_cast<int>(layout.y.size()));
}

template <class A, class B> double worst_difference(const std::vector<A>& a, const std::vector<B>& exact) {
  REQUIRE(a.size() == exact.size());
  Quad worst = 0, largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    worst = real::max(worst, real::abs(Quad(a[i]) - Quad(exact[i])));
    largest = real::max(largest, real::abs(Quad(exact[i])));
  }
  return static_cast<double>(worst / largest);
}

TEST_CASE("derivatives of random trees by duals are those of differences in quad") {
  double worst = 0;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    Scene scene = random_tree(seed, 8);
    for (int j = 0; j < static_cast<int>(scene.joints.size()); ++j)
      if (scene.joints[j].kind == JointKind::hinge || scene.joints[j].kind == JointKind::slider) {
        JointSpring spring;
        spring.joint = j;
        spring.stiffness = 3, spring.damping = 0.2;
        scene.joint_forces.push_back(spring);
      }
    const TreeState layout = layout_of(scene);
    const AccelerationDerivatives dual = by_duals(scene, layout);
    const auto check = [&](Along along, const std::vector<double>& matrix) {
      worst = std::max(worst, worst_difference(matrix, difference_derivatives<Quad>(scene, layout, along, Quad(1e-10),
                                                                                    DifferenceRule::central)));
    };
    check(Along::displacement, dual.by_displacement);
    check(Along::rate, dual.by_rate);
    check(Along::force, dual.by_force);
    for (int i = 0; i < dual.rates; ++i)  // the inverse of the mass matrix is symmetric
      for (int k = 0; k < i; ++k)
        CHECK(dual.by_force[i * dual.rates + k] == Approx(dual.by_force[k * dual.rates + i]).margin(1e-10));
  }
  CHECK(worst < 2e-13);
}

// The error of a forward difference is h / 2 |f''| + eps / h |f|, of a central one h^2 / 6 |f'''| + eps / h |f|.
TEST_CASE("the error of differences in double has its least value far above that of duals") {
  const Scene scene = hinge_chain({2.0, 1.0, -0.5}, {0.3, -1.0, 2.0});
  const TreeState layout = layout_of(scene);
  const std::vector<Quad> exact =
      difference_derivatives<Quad>(scene, layout, Along::displacement, Quad(1e-10), DifferenceRule::central);
  const double dual = worst_difference(by_duals(scene, layout).by_displacement, exact);
  double least[2] = {1, 1}, at[2] = {};
  for (int k = 1; k <= 14; ++k) {
    const double step = std::pow(10.0, -k);
    double error[2];
    for (int c = 0; c < 2; ++c) {
      error[c] =
          worst_difference(difference_derivatives<double>(scene, layout, Along::displacement, step,
                                                          c == 1 ? DifferenceRule::central : DifferenceRule::forward),
                           exact);
      if (error[c] < least[c]) least[c] = error[c], at[c] = step;
    }
    if (k == 14) CHECK(error[0] > 1e-3);
    UNSCOPED_INFO("step " << step << ": forward " << error[0] << ", central " << error[1]);
  }
  CAPTURE(dual);
  CHECK(dual < 3e-15);
  CHECK(least[0] > 1e-10);
  CHECK(least[0] < 1e-6);
  CHECK(at[0] <= 1e-7);
  CHECK(at[0] >= 1e-9);
  CHECK(least[1] > 1e-13);
  CHECK(least[1] < 1e-8);
  CHECK(at[1] >= 1e-6);
}

}  // namespace
}  // namespace atwood::testing
