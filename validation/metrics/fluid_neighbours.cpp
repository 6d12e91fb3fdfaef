// How many particles lie within the support of a kernel, counted from positions.
#include <algorithm>
#include <cmath>

#include "validation/metrics/fluid.hpp"
#include "validation/metrics/measurements.hpp"

namespace atwood {
namespace {

using Place = std::array<double, 3>;

// One axis cut into cells at least as wide as the support, so that neighbours lie in the same cell or the next ones.
struct CellAxis {
  double begin = 0, width = 1, period = 0;  // period 0: open
  std::int64_t cells = 1;

  std::int64_t cell_of(double x) const {
    const double at = period > 0 ? x - period * std::floor(x / period) : x - begin;
    return std::clamp(static_cast<std::int64_t>(at / width), std::int64_t{0}, cells - 1);
  }
  // The cells beside this one and itself, each once.
  std::vector<std::int64_t> around(std::int64_t cell) const {
    std::vector<std::int64_t> near;
    for (std::int64_t next = cell - 1; next <= cell + 1; ++next) {
      if (period == 0 && (next < 0 || next >= cells)) continue;
      const std::int64_t wrapped = (next + cells) % cells;
      if (std::find(near.begin(), near.end(), wrapped) == near.end()) near.push_back(wrapped);
    }
    return near;
  }
  double apart(double a, double b) const {
    const double d = a - b;
    return period > 0 ? d - period * std::round(d / period) : d;
  }
};

std::array<CellAxis, 3> make_axes(const Domain& domain, const std::vector<Place>& places, double support_m) {
  // Along an axis: about a cell a particle, wherever a lost particle may be.
  const auto most =
      static_cast<std::int64_t>(std::pow(static_cast<double>(places.size()), 1.0 / domain.dimensions)) + 1;
  std::array<CellAxis, 3> axes;
  for (std::size_t i = 0; i < 3; ++i) {
    double low = places.front()[i], high = low;
    for (const Place& x : places) low = std::min(low, x[i]), high = std::max(high, x[i]);
    CellAxis& axis = axes[i];
    axis.period = domain.periodic_m[i];
    axis.begin = low;
    const double length = axis.period > 0 ? axis.period : high - low;
    axis.cells = std::clamp(static_cast<std::int64_t>(length / support_m), std::int64_t{1}, most);
    axis.width = length > 0 ? length / static_cast<double>(axis.cells) : 1;
  }
  return axes;
}

double setting_of(const Settings& settings, const char* name) {
  const auto found = settings.find(name);
  if (found == settings.end()) return 0;
  if (const auto* real = std::get_if<double>(&found->second)) return *real;
  if (const auto* whole = std::get_if<std::int64_t>(&found->second)) return static_cast<double>(*whole);
  return 0;
}

}  // namespace

double mean_neighbours(const Domain& domain, const std::vector<Place>& places, double support_m) {
  if (places.empty() || !(support_m > 0)) return 0;
  const std::array<CellAxis, 3> axes = make_axes(domain, places, support_m);
  const auto index_of = [&](std::int64_t x, std::int64_t y, std::int64_t z) {
    return static_cast<std::size_t>((x * axes[1].cells + y) * axes[2].cells + z);
  };
  std::vector<std::vector<std::size_t>> members(
      static_cast<std::size_t>(axes[0].cells * axes[1].cells * axes[2].cells));
  for (std::size_t i = 0; i < places.size(); ++i)
    members[index_of(axes[0].cell_of(places[i][0]), axes[1].cell_of(places[i][1]), axes[2].cell_of(places[i][2]))]
        .push_back(i);
  std::int64_t pairs = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Place& x = places[i];
    for (const std::int64_t a : axes[0].around(axes[0].cell_of(x[0])))
      for (const std::int64_t b : axes[1].around(axes[1].cell_of(x[1])))
        for (const std::int64_t c : axes[2].around(axes[2].cell_of(x[2])))
          for (const std::size_t j : members[index_of(a, b, c)]) {
            const double d0 = axes[0].apart(places[j][0], x[0]), d1 = axes[1].apart(places[j][1], x[1]),
                         d2 = axes[2].apart(places[j][2], x[2]);
            if (j != i && d0 * d0 + d1 * d1 + d2 * d2 < support_m * support_m) ++pairs;
          }
  }
  return static_cast<double>(pairs) / static_cast<double>(places.size());
}

double kernel_support_m(const Settings& response, double spacing_m, bool free_surface) {
  double smoothing = setting_of(response, "smoothing");
  if (smoothing == 0 && response.contains("degree"))
    smoothing = free_surface ? 1.75 : setting_of(response, "degree") == 4 ? 1.55 : 1.5;
  const auto kernel = response.find("kernel");
  if (kernel == response.end()) return 0;
  const auto* name = std::get_if<std::string>(&kernel->second);
  return (name != nullptr && *name == "quintic" ? 3 : 2) * smoothing * spacing_m;
}

std::vector<Row> neighbour_rows(const Scene& scene, const Recording& run, double support_m) {
  if (!(support_m > 0) || run.outcome.status != Status::ok || run.values.empty()) return {};
  std::vector<Place> places;
  for (const ParticleSample& p : run.values.back().particles)
    places.push_back({static_cast<double>(p.p_m[0]), static_cast<double>(p.p_m[1]), static_cast<double>(p.p_m[2])});
  for (const Place& x : places)
    if (!std::isfinite(x[0] + x[1] + x[2])) return {};
  return {metrics::row("neighbours", mean_neighbours(scene.domain, places, support_m), 0,
                       "within " + format_measure(support_m, 0, 4) + " m of " + std::to_string(places.size()) +
                           " particles, at the end")};
}

}  // namespace atwood
