// Symplecticity: M = d(end) / d(start) in canonical variables, by central differences, and how far it is from
//
//     M^T J M = J,      J = [0 1; -1 0]            (Hairer, Lubich and Wanner 2006, VI.2)
//
// for points, q = r and p = m v + e A(r) + m W x r: A = B x r / 2 in a uniform magnetic field, W a rotating frame's
// rate. For a freely rotating body the flow of the angular momentum L = I w in body axes is a Poisson map,
//
//     M hat(L_start) M^T = hat(L_end),  hat(a) b = a x b      (Marsden and Ratiu 1999, 15.2).
//
// Everything is scaled by the sizes of q and p (of L), so the figure has no unit. Differences with steps d and
// 4 d are combined to order 4. The best step depends on the motion, so there is a ladder of steps, 2^-10 to 2^-24 of
// the scale: larger ones have truncation errors, smaller ones round-off. The figure is that of the step where it
// changes least to the next one, and this change is the bar.
#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "dynamics/eigen_quad.hpp"
#include "validation/metrics/probe_parts.hpp"

namespace atwood::metrics {
namespace {

using Vector = std::vector<double>;
using Wides = std::vector<Wide>;
using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
constexpr double kStep = 0x1p-10;  // of the scale, and its quarters
constexpr std::size_t kLevels = 8;
constexpr std::size_t kMaxBodies = 8;

std::array<Wide, 3> cross(const Real3& a, const std::array<Wide, 3>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

bool acts_on(const std::vector<int>& bodies, int body) {
  return std::find(bodies.begin(), bodies.end(), body) != bodies.end();
}

// The part of p besides m v.
std::array<Wide, 3> field_momentum(const Scene& scene, int body, const std::array<Wide, 3>& r) {
  std::array<Wide, 3> p{};
  const Body& b = scene.bodies[static_cast<std::size_t>(body)];
  for (const Force& force : scene.forces) {
    std::array<Wide, 3> add{};
    if (const auto* magnetic = std::get_if<Lorentz>(&force); magnetic && acts_on(magnetic->bodies, body)) {
      add = cross(magnetic->magnetic_T, r);
      for (Wide& x : add) x *= Wide(b.charge_C) / 2;
    } else if (const auto* frame = std::get_if<RotatingFrame>(&force)) {
      add = cross(frame->angular_velocity_rad_per_s, r);
      for (Wide& x : add) x *= b.mass_kg;
    }
    for (int i = 0; i < 3; ++i) p[i] += add[i];
  }
  return p;
}

std::vector<int> mobile_bodies(const Scene& scene) {
  std::vector<int> mobile;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b)
    if (!scene.bodies[b].fixed) mobile.push_back(static_cast<int>(b));
  return mobile;
}

// (q, p) of the mobile bodies, all q first.
Wides canonical(const Scene& scene, const std::vector<int>& mobile, const SampleView& s) {
  Wides z(6 * mobile.size());
  for (std::size_t k = 0; k < mobile.size(); ++k) {
    const BodySample& b = s.bodies[static_cast<std::size_t>(mobile[k])];
    const auto extra = field_momentum(scene, mobile[k], b.p_m);
    for (std::size_t i = 0; i < 3; ++i) {
      z[3 * k + i] = b.p_m[i];
      z[3 * (mobile.size() + k) + i] =
          Wide(scene.bodies[static_cast<std::size_t>(mobile[k])].mass_kg) * b.v_m_per_s[i] + extra[i];
    }
  }
  return z;
}

Sample from_canonical(const Scene& scene, const std::vector<int>& mobile, const Wides& z, const SampleView& like) {
  Sample s = copy_of(like);
  for (std::size_t k = 0; k < mobile.size(); ++k) {
    BodySample& b = s.bodies[static_cast<std::size_t>(mobile[k])];
    for (std::size_t i = 0; i < 3; ++i) b.p_m[i] = z[3 * k + i];
    const auto extra = field_momentum(scene, mobile[k], b.p_m);
    for (std::size_t i = 0; i < 3; ++i)
      b.v_m_per_s[i] =
          (z[3 * (mobile.size() + k) + i] - extra[i]) / Wide(scene.bodies[static_cast<std::size_t>(mobile[k])].mass_kg);
  }
  return s;
}

// A map of the state, in scaled variables, as the probe differentiates it.
struct Map {
  Wides start;
  Vector scale;
  std::function<Wides(const Wides&)> end;
};

// d(end) / d(start), scaled, by (16 D(d) - D(4 d)) / 15 of central differences D: one matrix per step d.
std::vector<Matrix> differentiate(const Map& map) {
  const std::size_t n = map.start.size();
  std::vector<Matrix> matrices(kLevels - 1, Matrix(n, n));
  for (std::size_t c = 0; c < n; ++c) {
    std::array<Vector, kLevels> central;
    for (std::size_t level = 0; level < kLevels; ++level) {
      const double d = kStep * std::pow(0.25, static_cast<double>(level));
      Wides up = map.start, down = map.start;
      up[c] += Wide(d * map.scale[c]);
      down[c] -= Wide(d * map.scale[c]);
      const Wides a = map.end(up), b = map.end(down);
      for (std::size_t r = 0; r < n; ++r)
        central[level].push_back(static_cast<double>((a[r] - b[r]) / Wide(map.scale[r])) / (2 * d));
    }
    for (std::size_t level = 0; level + 1 < kLevels; ++level)
      for (std::size_t r = 0; r < n; ++r)
        matrices[level](static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c)) =
            (16 * central[level + 1][r] - central[level][r]) / 15;
  }
  return matrices;
}

// a b c, each sum in the order of its index (lazyProduct: Eigen's blocked product has another order).
Matrix sandwich(const Matrix& a, const Matrix& b, const Matrix& c) {
  const Matrix bc = b.lazyProduct(c);
  return a.lazyProduct(bc);
}

template <class Defect>
Row defect_row(const std::string& metric, const std::vector<Matrix>& matrices, const Defect& defect) {
  std::vector<Matrix> defects;
  for (const Matrix& m : matrices) defects.push_back(defect(m));
  std::size_t best = 0;
  double bar = std::numeric_limits<double>::infinity();
  for (std::size_t level = 0; level + 1 < defects.size(); ++level) {
    const double change = (defects[level] - defects[level + 1]).norm();
    if (change < bar) {
      bar = change;
      best = level;
    }
  }
  return row(metric, defects[best].norm(), bar,
             std::to_string(matrices[0].rows()) + " variables, difference step 2^-" + std::to_string(12 + 2 * best) +
                 " of the scale");
}

std::vector<Row> of_points(const ProbeRequest& request, const Plan& plan) {
  const Scene& scene = request.scenario.scene;
  const std::vector<int> mobile = mobile_bodies(scene);
  if (mobile.size() > kMaxBodies) throw ProbeEnds(Status::unsupported, "more than 8 bodies");
  const Recording run = good_run(request, scene, plan);
  const std::size_t half = 3 * mobile.size();
  Map map;
  map.start = canonical(scene, mobile, run.values.front());
  double q = 0, p = 0;
  for (const SampleView s : run.values) {
    const Wides z = canonical(scene, mobile, s);
    for (std::size_t i = 0; i < half; ++i) {
      q = std::max(q, std::fabs(static_cast<double>(z[i])));
      p = std::max(p, std::fabs(static_cast<double>(z[half + i])));
    }
  }
  if (!(q > 0) || !(p > 0)) throw ProbeEnds(Status::unsupported, "the motion has no size to scale by");
  map.scale.assign(2 * half, q);
  std::fill(map.scale.begin() + static_cast<std::ptrdiff_t>(half), map.scale.end(), p);
  map.end = [&](const Wides& z) {
    const Scene from = started_from(scene, from_canonical(scene, mobile, z, run.values.front()));
    return canonical(scene, mobile, good_run(request, from, plan).values.back());
  };
  const auto matrices = differentiate(map);
  const auto points = static_cast<Eigen::Index>(half);
  Matrix J = Matrix::Zero(2 * points, 2 * points);
  J.topRightCorner(points, points).setIdentity();
  J.bottomLeftCorner(points, points).diagonal().setConstant(-1);
  const auto defect = [&](const Matrix& M) -> Matrix { return sandwich(M.transpose(), J, M) - J; };
  return {defect_row("symplecticity-defect", matrices, defect)};
}

std::vector<Row> of_free_body(const ProbeRequest& request, const Plan& plan) {
  const Scene& scene = request.scenario.scene;
  const Body& body = scene.bodies[0];
  const Recording run = good_run(request, scene, plan);
  const auto angular = [&](const SampleView& s) {
    Wides l(3);
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 3; ++k) l[i] += Wide(body.inertia_kg_m2[3 * i + k]) * s.bodies[0].w_rad_per_s[k];
    return l;
  };
  using Inertia = Eigen::Matrix<Wide, 3, 3, Eigen::RowMajor>;
  const Inertia inverse =
      Inertia(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(body.inertia_kg_m2.data()).cast<Wide>())
          .inverse();
  Map map;
  map.start = angular(run.values.front());
  double size = 0;
  for (const Wide& x : map.start) size += static_cast<double>(x * x);
  size = std::sqrt(size);
  if (!(size > 0)) throw ProbeEnds(Status::unsupported, "the body does not turn");
  map.scale.assign(3, size);
  map.end = [&](const Wides& l) {
    Sample s = copy_of(run.values.front());
    Eigen::Matrix<Wide, 3, 1>::Map(s.bodies[0].w_rad_per_s.data()) = inverse * Eigen::Matrix<Wide, 3, 1>::Map(l.data());
    return angular(good_run(request, started_from(scene, s), plan).values.back());
  };
  const auto matrices = differentiate(map);
  const auto hat = [&](const Wides& l) {
    const double x = static_cast<double>(l[0]) / size, y = static_cast<double>(l[1]) / size,
                 z = static_cast<double>(l[2]) / size;
    return Matrix{{0, -z, y}, {z, 0, -x}, {-y, x, 0}};
  };
  const Matrix before = hat(map.start), after = hat(angular(run.values.back()));
  const auto defect = [&](const Matrix& M) -> Matrix { return sandwich(M, before, M.transpose()) - after; };
  return {defect_row("poisson-defect", matrices, defect)};
}

}  // namespace

std::vector<Row> probe_symplecticity(const ProbeRequest& request) {
  require_bodies(request);
  require_no_contacts(request);
  require_no_dissipation(request);
  const Scene& scene = request.scenario.scene;
  const Plan& plan = request.plan;
  const bool turns =
      std::any_of(scene.bodies.begin(), scene.bodies.end(), [](const Body& b) { return rotates(b) && !b.fixed; });
  if (!turns) return of_points(request, plan);
  const bool free = scene.bodies.size() == 1 && scene.forces.empty();
  if (!free)
    throw ProbeEnds(Status::unsupported, "bodies that turn under forces: points, or one free body, are probed");
  return of_free_body(request, plan);
}

}  // namespace atwood::metrics
