#include "joints/differences.hpp"

#include <utility>

#include "joints/joint_forces.hpp"
#include "joints/tree.hpp"
#include "math/dense_lu.hpp"
#include "math/so3.hpp"

namespace atwood {
namespace {

constexpr int kAttitudeOfFreeBody = 6;  // p v q w

// Where the quaternion stands that turns with the k-th rate of the link; -1: the coordinate is a number of its own.
template <class S> int attitude_at(const Link<S>& link, int k) {
  if (link.joint < 0) return k < 3 ? -1 : link.at_q + kAttitudeOfFreeBody;
  return link.kind == JointKind::ball ? link.at_q : -1;
}
template <class S> int turn_axis(const Link<S>& link, int k) { return link.joint < 0 ? k - 3 : k; }

template <class S> void displace(const Link<S>& link, int k, S by, S* y) {
  const int attitude = attitude_at(link, k);
  if (attitude < 0) {
    y[link.at_q + k] += by;
    return;
  }
  Vec3<S> turn{};
  component(turn, turn_axis(link, k)) = by;
  store4(load4(y + attitude) * so3_exp(turn), y + attitude);
}

// The displacement along the k-th rate of the link that leads from one state to another.
template <class S> S displacement(const Link<S>& link, int k, const S* from, const S* to) {
  const int attitude = attitude_at(link, k);
  if (attitude < 0) return to[link.at_q + k] - from[link.at_q + k];
  Vec3<S> turn = so3_log(conjugate(load4(from + attitude)) * load4(to + attitude));
  return component(turn, turn_axis(link, k));
}

template <class S> class Dynamics {
 public:
  Dynamics(const Scene& scene, const TreeState& at)
      : tree(scene, at.offsets, at.first_free), forces_(scene), t_s_(at.t_s), loads_(scene.bodies.size()) {
    forces_.select(at.t_s);
    for (Load<S>& load : loads_) load.acceleration_W = narrow3<S>(scene.gravity_m_per_s2);
  }
  int rates() const { return tree.rate_count(); }
  // `applied`: generalised forces besides, rates() of them, overwritten.
  std::vector<S> accelerations(const std::vector<S>& y, std::vector<S> applied) {
    std::vector<S> du(static_cast<std::size_t>(rates()));
    tree.kinematics(S(0), y.data());
    forces_.add(tree, S(t_s_), y.data(), applied.data());
    tree.accelerations(loads_.data(), applied.data(), du.data());
    return du;
  }

  Tree<S> tree;

 private:
  JointForces<S> forces_;
  double t_s_;
  std::vector<Load<S>> loads_;
};

// By rate; zeros where no joint has a damper.
std::vector<Quad> damping_of(const Scene& scene, const Tree<Quad>& tree, bool& any) {
  std::vector<Quad> damping(static_cast<std::size_t>(tree.rate_count()));
  any = false;
  for (const JointForce& force : scene.joint_forces) {
    const auto* spring = std::get_if<JointSpring>(&force);
    if (!spring || spring->damping == 0) continue;
    const Link<Quad>& link = tree.links()[static_cast<std::size_t>(tree.link_of_joint(spring->joint))];
    any = true;
    const bool ball = link.kind == JointKind::ball;
    for (int k = ball ? 0 : spring->coordinate; k <= (ball ? 2 : spring->coordinate); ++k)
      damping[static_cast<std::size_t>(link.first_rate + k)] += spring->damping;
  }
  return damping;
}

void damp_implicitly(const Scene& scene, Tree<Quad>& tree, Quad h, std::vector<Quad>& du) {
  bool any = false;
  const std::vector<Quad> damping = damping_of(scene, tree, any);
  if (!any) return;
  const int n = static_cast<int>(du.size());
  DenseLu<Quad> A(n);  // I + h M^-1 D
  std::vector<Quad> unit(du.size()), column(du.size());
  for (int k = 0; k < n; ++k) {
    const auto at = static_cast<std::size_t>(k);
    A.at(k, k) += 1;
    if (damping[at] == 0) continue;
    unit.assign(du.size(), Quad(0));
    unit[at] = h * damping[at];
    tree.solve(unit.data(), column.data());
    for (int i = 0; i < n; ++i) A.at(i, k) += column[static_cast<std::size_t>(i)];
  }
  A.factor();
  A.solve(du.data());
}

std::vector<Quad> euler_step(const Scene& scene, Dynamics<Quad>& dynamics, Quad h, std::vector<Quad> y) {
  std::vector<Quad> du = dynamics.accelerations(y, std::vector<Quad>(static_cast<std::size_t>(dynamics.rates())));
  damp_implicitly(scene, dynamics.tree, h, du);
  for (const Link<Quad>& link : dynamics.tree.links()) {
    const auto rate_of = [&](int k) -> Quad& {
      return y[static_cast<std::size_t>(dynamics.tree.state_of_rate(link.first_rate + k))];
    };
    for (int k = 0; k < link.rates; ++k) rate_of(k) += h * du[static_cast<std::size_t>(link.first_rate + k)];
    Vec3<Quad> turn{};
    int attitude = -1;
    for (int k = 0; k < link.rates; ++k) {
      if (attitude_at(link, k) < 0) {
        displace(link, k, h * rate_of(k), y.data());
        continue;
      }
      attitude = attitude_at(link, k);
      component(turn, turn_axis(link, k)) = h * rate_of(k);
    }
    if (attitude >= 0) store4(load4(y.data() + attitude) * so3_exp(turn), y.data() + attitude);
  }
  return y;
}

}  // namespace

template <class S>
std::vector<S> difference_derivatives(const Scene& scene, const TreeState& at, Along along, S step,
                                      DifferenceRule rule) {
  Dynamics<S> dynamics(scene, at);
  const int n = dynamics.rates();
  const auto moved = [&](const Link<S>& link, int k, S by) {
    std::vector<S> y(at.y.begin(), at.y.end()), applied(static_cast<std::size_t>(n));
    const int rate = link.first_rate + k;
    if (along == Along::displacement) displace(link, k, by, y.data());
    if (along == Along::rate) y[static_cast<std::size_t>(dynamics.tree.state_of_rate(rate))] += by;
    if (along == Along::force) applied[static_cast<std::size_t>(rate)] = by;
    return dynamics.accelerations(y, std::move(applied));
  };
  const bool central = rule == DifferenceRule::central;
  std::vector<S> matrix(static_cast<std::size_t>(n) * static_cast<std::size_t>(n));
  for (const Link<S>& link : dynamics.tree.links())
    for (int k = 0; k < link.rates; ++k) {
      const std::vector<S> after = moved(link, k, step), before = moved(link, k, central ? -step : S(0));
      for (int i = 0; i < n; ++i)
        matrix[static_cast<std::size_t>(i * n + link.first_rate + k)] =
            (after[static_cast<std::size_t>(i)] - before[static_cast<std::size_t>(i)]) / (central ? S(2) * step : step);
    }
  return matrix;
}

template std::vector<double> difference_derivatives(const Scene&, const TreeState&, Along, double, DifferenceRule);
template std::vector<Quad> difference_derivatives(const Scene&, const TreeState&, Along, Quad, DifferenceRule);

std::vector<Quad> euler_step_derivatives(const Scene& scene, const TreeState& at, double h_s) {
  constexpr double step = 1e-10;
  Dynamics<Quad> dynamics(scene, at);
  const int n = dynamics.rates();
  std::vector<Quad> matrix(static_cast<std::size_t>(4 * n * n));
  const auto stepped = [&](bool rates, const Link<Quad>& link, int k, Quad by) {
    std::vector<Quad> y(at.y.begin(), at.y.end());
    if (rates) y[static_cast<std::size_t>(dynamics.tree.state_of_rate(link.first_rate + k))] += by;
    else displace(link, k, by, y.data());
    return euler_step(scene, dynamics, Quad(h_s), std::move(y));
  };
  for (const bool rates : {false, true})
    for (const Link<Quad>& by : dynamics.tree.links())
      for (int k = 0; k < by.rates; ++k) {
        const std::vector<Quad> after = stepped(rates, by, k, Quad(step)), before = stepped(rates, by, k, -Quad(step));
        const int column = (rates ? n : 0) + by.first_rate + k;
        for (const Link<Quad>& of : dynamics.tree.links())
          for (int i = 0; i < of.rates; ++i) {
            const int row = of.first_rate + i;
            const auto u = static_cast<std::size_t>(dynamics.tree.state_of_rate(row));
            matrix[static_cast<std::size_t>(row * 2 * n + column)] =
                displacement(of, i, before.data(), after.data()) / (2 * Quad(step));
            matrix[static_cast<std::size_t>((n + row) * 2 * n + column)] = (after[u] - before[u]) / (2 * Quad(step));
          }
      }
  return matrix;
}

}  // namespace atwood
