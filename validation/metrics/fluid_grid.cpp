// Errors of a fluid's fields on a regular grid.
#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <optional>

#include "validation/metrics/fluid_parts.hpp"
#include "validation/metrics/measurements.hpp"

namespace atwood {
namespace {

using GridPlace = std::array<double, 3>;
constexpr double kGridReach = 3;  // of the fit around a point of the grid
constexpr int kDegree = 4;

// Cells of an axis: of the grid (n, as wide as the spacing), and of the search for particles (bins).
struct GridAxis {
  double period = 0;
  std::int64_t n = 1, bins = 1;
  std::int64_t bin_of(double x) const {
    if (bins == 1) return 0;
    const double turns = x / period;
    return std::min(bins - 1, static_cast<std::int64_t>((turns - std::floor(turns)) * static_cast<double>(bins)));
  }
  double apart(double to, double from) const {
    return period > 0 ? to - from - period * std::round((to - from) / period) : to - from;
  }
};

// Of a domain that fluids fill and that is periodic along every axis, with room for a fit; none: of another.
std::optional<std::array<GridAxis, 3>> grid_axes(const Scene& scene) {
  const auto d = static_cast<std::size_t>(scene.domain.dimensions);
  double spacing = 0, filled = 0, whole = 1;
  for (const Fluid& fluid : scene.fluids) {
    const auto* box = std::get_if<BoxRegion>(&fluid.region);
    if (box == nullptr) return std::nullopt;
    double volume = 1;
    for (std::size_t i = 0; i < d; ++i) volume *= box->max_m[i] - box->min_m[i];
    filled += volume;
    spacing = std::max(spacing, fluid.spacing_m);
  }
  if (!scene.fluid_boundaries.empty() || !(spacing > 0)) return std::nullopt;
  std::array<GridAxis, 3> axes;
  for (std::size_t i = 0; i < d; ++i) {
    axes[i].period = scene.domain.periodic_m[i];
    if (!(axes[i].period >= 2 * kGridReach * spacing)) return std::nullopt;
    axes[i].n = std::llround(axes[i].period / spacing);
    axes[i].bins = std::max<std::int64_t>(1, static_cast<std::int64_t>(axes[i].period / (kGridReach * spacing)));
    whole *= axes[i].period;
  }
  if (std::fabs(filled - whole) > 1e-9 * whole) return std::nullopt;
  return axes;
}

// Weights of the particles around a point: its value is their weighted sum of the particles' values.
struct GridStencil {
  std::vector<std::size_t> particles;
  Eigen::VectorXd weights;
};

// Monomials of degree 0 .. kDegree of z, the constant first.
void grid_monomials(const GridPlace& z, std::size_t d, std::vector<double>& out) {
  out.clear();
  for (int degree = 0; degree <= kDegree; ++degree)
    for (int a = degree; a >= 0; --a)
      for (int b = degree - a; b >= (d == 2 ? degree - a : 0); --b)
        out.push_back(std::pow(z[0], a) * std::pow(z[1], b) * std::pow(z[2], degree - a - b));
}

class GridFit {
 public:
  GridFit(const Scene& scene, const std::array<GridAxis, 3>& axes, std::span<const ParticleSample> particles)
      : axes_(axes), d_(static_cast<std::size_t>(scene.domain.dimensions)) {
    for (const Fluid& fluid : scene.fluids) reach_ = std::max(reach_, kGridReach * fluid.spacing_m);
    bins_.resize(static_cast<std::size_t>(axes[0].bins * axes[1].bins * axes[2].bins));
    for (const ParticleSample& p : particles) {
      const GridPlace x{static_cast<double>(p.p_m[0]), static_cast<double>(p.p_m[1]), static_cast<double>(p.p_m[2])};
      bins_[bin(axes_[0].bin_of(x[0]), axes_[1].bin_of(x[1]), axes_[2].bin_of(x[2]))].push_back(places_.size());
      places_.push_back(x);
    }
  }

  // Moving least squares (Lancaster and Salkauskas 1981): minimise sum_j w(r_j / reach) (q(x_j) - f_j)^2 over the
  // polynomials q of degree 4, w(s) = (1 - s)^4 (1 + 4 s); the value is q(x). None: too few particles around x.
  std::optional<GridStencil> around(const GridPlace& x) const {
    GridStencil stencil;
    std::vector<double> rows, roots, basis;
    const auto neighbours = [&](const GridAxis& axis, double at) {
      std::vector<std::int64_t> near;
      const std::int64_t own = axis.bin_of(at), reach = axis.bins < 3 ? 0 : 1;
      if (reach == 0)
        for (std::int64_t k = 0; k < axis.bins; ++k) near.push_back(k);
      else
        for (std::int64_t k = -1; k <= 1; ++k) near.push_back((own + k + axis.bins) % axis.bins);
      return near;
    };
    for (const std::int64_t a : neighbours(axes_[0], x[0]))
      for (const std::int64_t b : neighbours(axes_[1], x[1]))
        for (const std::int64_t c : neighbours(axes_[2], x[2]))
          for (const std::size_t j : bins_[bin(a, b, c)]) {
            GridPlace z{};
            for (std::size_t i = 0; i < d_; ++i) z[i] = axes_[i].apart(places_[j][i], x[i]) / reach_;
            const double s = std::hypot(z[0], z[1], z[2]);
            if (!(s < 1)) continue;
            roots.push_back((1 - s) * (1 - s) * std::sqrt(1 + 4 * s));
            grid_monomials(z, d_, basis);
            rows.insert(rows.end(), basis.begin(), basis.end());
            stencil.particles.push_back(j);
          }
    grid_monomials({}, d_, basis);
    const auto count = static_cast<Eigen::Index>(roots.size()), unknowns = static_cast<Eigen::Index>(basis.size());
    if (count < unknowns) return std::nullopt;
    // With A = diag(root) P and its QR factors: q(x) = e_0 . A^+ (root f), so that the weights are root A^+^T e_0.
    const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> P(rows.data(), count,
                                                                                                     unknowns);
    const Eigen::Map<const Eigen::VectorXd> root(roots.data(), count);
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(root.asDiagonal() * P);
    if (qr.rank() < unknowns) return std::nullopt;
    const Eigen::VectorXd constant = Eigen::VectorXd::Unit(unknowns, 0);
    const Eigen::MatrixXd R = qr.matrixR().topLeftCorner(unknowns, unknowns);
    Eigen::VectorXd of_rows = Eigen::VectorXd::Zero(count);
    of_rows.head(unknowns) =
        R.triangularView<Eigen::Upper>().transpose().solve(qr.colsPermutation().transpose() * constant);
    stencil.weights = root.cwiseProduct(qr.householderQ() * of_rows);
    return stencil;
  }

 private:
  std::size_t bin(std::int64_t a, std::int64_t b, std::int64_t c) const {
    return static_cast<std::size_t>((a * axes_[1].bins + b) * axes_[2].bins + c);
  }
  std::array<GridAxis, 3> axes_;
  std::size_t d_;
  double reach_ = 0;
  std::vector<GridPlace> places_;
  std::vector<std::vector<std::size_t>> bins_;
};

// One of the fields; a scalar has one component.
struct GridField {
  const char* name;
  bool FieldKnown::*known;
  Wide ParticleSample::*scalar;  // null: the velocity
  double operator()(const ParticleSample& p, std::size_t component) const {
    return static_cast<double>(scalar ? p.*scalar : p.v_m_per_s[component]);
  }
};
constexpr std::array<GridField, 4> kGridFields{
    {{"velocity", &FieldKnown::velocity, nullptr},
     {"pressure", &FieldKnown::pressure, &ParticleSample::pressure_Pa},
     {"density", &FieldKnown::density, &ParticleSample::density_kg_per_m3},
     {"temperature", &FieldKnown::temperature, &ParticleSample::temperature_K}}};

struct GridNorms {
  double sum = 0, squares = 0, largest = 0;
  void take(const GridPlace& e) {
    const double size = std::hypot(e[0], e[1], e[2]);
    sum += size;
    squares += size * size;
    if (!(size <= largest)) largest = size;
  }
  double of(int norm) const { return norm == 0 ? sum : norm == 1 ? std::sqrt(squares) : largest; }
};

}  // namespace

std::vector<FieldPosition> comparison_grid(const Scene& scene) {
  const auto axes = grid_axes(scene);
  std::vector<FieldPosition> points;
  if (!axes) return points;
  const auto at = [&](std::size_t axis, std::int64_t k) {
    const GridAxis& of = (*axes)[axis];
    return of.period > 0 ? Wide(of.period) * (Wide(k) + Wide(0.5)) / Wide(of.n) : Wide(0);
  };
  for (std::int64_t i = 0; i < (*axes)[0].n; ++i)
    for (std::int64_t j = 0; j < (*axes)[1].n; ++j)
      for (std::int64_t k = 0; k < (*axes)[2].n; ++k) points.push_back({at(0, i), at(1, j), at(2, k)});
  return points;
}

void metrics::append_grid_norms(const Scenario& scenario, const FluidTruths& truths, const Recording& run,
                                std::vector<Row>& rows) {
  const Scene& scene = scenario.scene;
  const FieldAtParticles &exact = truths.exact, &on_grid = truths.on_grid;
  const auto axes = grid_axes(scene);
  if (!axes || on_grid.outcome.status != Status::ok || on_grid.samples.size() != 1 || exact.samples.empty()) return;
  const std::vector<FieldPosition> points = comparison_grid(scene);
  const std::span<const ParticleSample> particles = run.values.back().particles, there = on_grid.samples[0].values,
                                        here = exact.samples.back().values;
  if (there.size() != points.size() || here.size() != particles.size()) return;
  const GridFit grid(scene, *axes, particles);
  struct Sums {
    GridNorms error, size, own;
  };
  std::array<Sums, kGridFields.size()> sums;
  for (std::size_t g = 0; g < points.size(); ++g) {
    const auto stencil = grid.around(
        {static_cast<double>(points[g][0]), static_cast<double>(points[g][1]), static_cast<double>(points[g][2])});
    if (!stencil) return;  // a hole in the fluid: no field is there
    for (std::size_t q = 0; q < kGridFields.size(); ++q) {
      const GridField& quantity = kGridFields[q];
      GridPlace exact_value{}, error{}, own{};
      for (std::size_t c = 0; c < (quantity.scalar ? 1 : 3); ++c) {
        exact_value[c] = quantity(there[g], c);
        for (std::size_t n = 0; n < stencil->particles.size(); ++n) {
          const double weight = stencil->weights[static_cast<Eigen::Index>(n)];
          const std::size_t i = stencil->particles[n];
          error[c] += weight * quantity(particles[i], c);
          own[c] += weight * quantity(here[i], c);
        }
        error[c] -= exact_value[c];
        own[c] -= exact_value[c];
      }
      sums[q].size.take(exact_value), sums[q].error.take(error), sums[q].own.take(own);
    }
  }
  constexpr std::array<const char*, 3> norms{"l1", "l2", "linf"};
  for (std::size_t q = 0; q < kGridFields.size(); ++q) {
    if (!(exact.known.*kGridFields[q].known) || !(sums[q].size.largest > 0)) continue;
    for (int n = 0; n < 3; ++n)
      rows.push_back(metrics::row(std::string(kGridFields[q].name) + "-grid-" + norms[static_cast<std::size_t>(n)],
                                  sums[q].error.of(n) / sums[q].size.of(n), sums[q].own.of(n) / sums[q].size.of(n),
                                  "on " + std::to_string(points.size()) +
                                      " points by moving least squares of degree 4; the bar is the error of this "
                                      "interpolation for the exact field; " +
                                      exact.source));
  }
}

}  // namespace atwood
