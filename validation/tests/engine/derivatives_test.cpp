// Derivatives of forward dynamics by dual numbers, against differences in quad; and what differences in double reach.
#include <catch2/catch.hpp>

#include "joints/derivatives.hpp"
#include "joints/tree.hpp"
#include "math/so3.hpp"
#include "mechanisms.hpp"

namespace atwood::testing {
namespace {

struct Layout {
  std::vector<int> offsets;
  int first_free = 0;
  std::vector<double> y;
};
Layout layout_of(const Scene& scene) {
  RigidModel<double> model(scene);
  INFO(model.unsupported());
  REQUIRE(model.unsupported().empty());
  Layout layout;
  for (int i = 0; i < model.body_count(); ++i) layout.offsets.push_back(model.offset(i));
  layout.first_free = model.tree()->scalars_at();
  layout.y.resize(model.state_size());
  model.initial_state(layout.y.data());
  return layout;
}

AccelerationDerivatives by_duals(const Scene& scene, const Layout& layout) {
  return acceleration_derivatives(scene, layout.offsets, layout.first_free, layout.y.data(),
                                  static_cast<int>(layout.y.size()));
}

enum class Along { displacement, rate, force };

// (u'(+step) - u'(-step)) / (2 step), or (u'(step) - u'(0)) / step, along every rate.
template <class S>
std::vector<S> by_differences(const Scene& scene, const Layout& layout, Along along, S step, bool central) {
  Tree<S> tree(scene, layout.offsets, layout.first_free);
  const JointForces<S> joint_forces(scene);
  const int n = tree.rate_count();
  std::vector<Load<S>> loads(scene.bodies.size());
  for (auto& load : loads) load.acceleration_W = narrow3<S>(scene.gravity_m_per_s2);
  const auto at = [&](const Link<S>& link, int k, S by) {
    std::vector<S> y(layout.y.begin(), layout.y.end()), applied(n), du(n);
    const auto turn = [&](S* q, int axis) {
      Vec3<S> about{};
      (axis == 0 ? about.x : axis == 1 ? about.y : about.z) = by;
      store4(load4(q) * so3_exp(about), q);
    };
    if (along == Along::rate) y[tree.state_of_rate(link.first_rate + k)] += by;
    if (along == Along::force) applied[link.first_rate + k] = by;
    if (along == Along::displacement) {
      if (link.joint < 0 && k >= 3) turn(y.data() + link.at_q + 6, k - 3);
      else if (link.kind == JointKind::ball && link.joint >= 0) turn(y.data() + link.at_q, k);
      else y[link.at_q + k] += by;
    }
    tree.kinematics(S(0), y.data());
    joint_forces.add(tree, S(0), y.data(), applied.data());
    tree.accelerations(loads.data(), applied.data(), du.data());
    return du;
  };
  std::vector<S> matrix(static_cast<std::size_t>(n) * n);
  for (const Link<S>& link : tree.links())
    for (int k = 0; k < link.rates; ++k) {
      const std::vector<S> after = at(link, k, step), before = at(link, k, central ? -step : S(0));
      for (int i = 0; i < n; ++i)
        matrix[i * n + link.first_rate + k] = (after[i] - before[i]) / (central ? S(2) * step : step);
    }
  return matrix;
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
    const Layout layout = layout_of(scene);
    const AccelerationDerivatives dual = by_duals(scene, layout);
    const auto check = [&](Along along, const std::vector<double>& matrix) {
      worst = std::max(worst, worst_difference(matrix, by_differences<Quad>(scene, layout, along, Quad(1e-10), true)));
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
  const Layout layout = layout_of(scene);
  const std::vector<Quad> exact = by_differences<Quad>(scene, layout, Along::displacement, Quad(1e-10), true);
  const double dual = worst_difference(by_duals(scene, layout).by_displacement, exact);
  double least[2] = {1, 1}, at[2] = {};
  for (int k = 1; k <= 14; ++k) {
    const double step = std::pow(10.0, -k);
    double error[2];
    for (int c = 0; c < 2; ++c) {
      error[c] = worst_difference(by_differences<double>(scene, layout, Along::displacement, step, c == 1), exact);
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
