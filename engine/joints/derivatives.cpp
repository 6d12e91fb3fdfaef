// Jacobians of forward dynamics by forward-mode differentiation: the tree's algorithm runs on dual numbers.
#include "math/dual.hpp"

#include "joints/derivatives.hpp"
#include "joints/joint_forces.hpp"
#include "joints/tree.hpp"

namespace atwood {
namespace {

using Scalar = Dual<double>;

// The derivative of the attitude q exp(turn) by a turn about the k-th axis: q (0, e_k) / 2.
void seed_turn(Scalar* q, int k) {
  Quat<double> axis{0, 0, 0, 0};
  (k == 0 ? axis.x : k == 1 ? axis.y : axis.z) = 0.5;
  const Quat<double> slope = Quat<double>{q[0].value, q[1].value, q[2].value, q[3].value} * axis;
  q[0].slope = slope.w, q[1].slope = slope.x, q[2].slope = slope.y, q[3].slope = slope.z;
}

void seed_displacement(const Link<Scalar>& link, int k, Scalar* y) {
  constexpr int attitude = 6;  // of a free body: p v q w
  if (link.joint < 0) {
    if (k < 3) y[link.at_q + k].slope = 1;
    else seed_turn(y + link.at_q + attitude, k - 3);
  } else if (link.kind == JointKind::ball) {
    seed_turn(y + link.at_q, k);
  } else {
    y[link.at_q + k].slope = 1;
  }
}

}  // namespace

AccelerationDerivatives acceleration_derivatives(const Scene& scene, const std::vector<int>& offsets, int first_free,
                                                 const double* y, int size, double t_s) {
  Tree<Scalar> tree(scene, offsets, first_free);
  JointForces<Scalar> joint_forces(scene);
  joint_forces.select(t_s);
  const int n = tree.rate_count();
  std::vector<Load<Scalar>> loads(scene.bodies.size());
  const auto& g = scene.gravity_m_per_s2;
  for (Load<Scalar>& load : loads) load.acceleration_W = {Scalar(g[0]), Scalar(g[1]), Scalar(g[2])};
  AccelerationDerivatives out;
  out.rates = n;
  out.acceleration.resize(n);
  for (auto* matrix : {&out.by_displacement, &out.by_rate, &out.by_force}) matrix->resize(n * n);
  std::vector<Scalar> state(size), applied(n), du(n);
  const auto column = [&](Along along, const Link<Scalar>& link, int k, std::vector<double>& matrix) {
    for (int i = 0; i < size; ++i) state[i] = y[i];
    for (Scalar& force : applied) force = 0.0;
    const int rate = link.first_rate + k;
    if (along == Along::displacement) seed_displacement(link, k, state.data());
    if (along == Along::rate) state[tree.state_of_rate(rate)].slope = 1;
    if (along == Along::force) applied[rate].slope = 1;
    tree.kinematics(Scalar(0), state.data());
    joint_forces.add(tree, Scalar(t_s), state.data(), applied.data());
    tree.accelerations(loads.data(), applied.data(), du.data());
    for (int i = 0; i < n; ++i) {
      out.acceleration[i] = du[i].value;
      matrix[i * n + rate] = du[i].slope;
    }
  };
  for (const Link<Scalar>& link : tree.links())
    for (int k = 0; k < link.rates; ++k) {
      column(Along::displacement, link, k, out.by_displacement);
      column(Along::rate, link, k, out.by_rate);
      column(Along::force, link, k, out.by_force);
    }
  return out;
}

}  // namespace atwood
