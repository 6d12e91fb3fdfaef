// Figures of a ladder besides its order: grid convergence without a truth, the least error above round-off (the V of
// the error curve), and the calibration of tolerances.
#include <algorithm>
#include <cmath>
#include <map>

#include "protocol/method.hpp"
#include "validation/metrics/measurements.hpp"

namespace atwood {
namespace {

// Rows of whole runs only: steps -> metric -> row.
using Figures = std::map<std::int64_t, std::map<std::string, const Row*>>;
Figures figures_of(std::span<const Row> cells) {
  Figures figures;
  for (const Row& r : cells)
    if (r.status == Status::ok && r.body.empty() && !r.t_s && r.steps > 0) figures[r.steps][r.metric] = &r;
  return figures;
}

double value_of(const std::map<std::string, const Row*>& cell, const std::string& metric, double otherwise) {
  const auto found = cell.find(metric);
  return found == cell.end() ? otherwise : found->second->value;
}

Row filled(Row row, const Row& like) {
  row.scenario = like.scenario;
  row.method = like.method;
  row.settings_hash = like.settings_hash;
  row.provenance = like.provenance;
  return row;
}

std::string steps_text(const LadderEnd& fine, const LadderEnd& medium, const LadderEnd& coarse) {
  return std::to_string(coarse.steps) + " " + std::to_string(medium.steps) + " " + std::to_string(fine.steps) +
         " steps";
}

GridLevel level_of(const LadderEnd& end, std::size_t body) {
  const auto& p = end.last.bodies[body].p_m;
  return {end.h_s, {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])}};
}

// Differences of positions are taken from values rounded to double, so they have the round-off of double.
struct Worst {
  GridConvergence grid;
  std::size_t body = 0;
};
Worst worst_body(const Scene& scene, const LadderEnd& fine, const LadderEnd& medium, const LadderEnd& coarse) {
  Worst worst;
  bool first = true;
  for (std::size_t b = 0; b < fine.last.bodies.size(); ++b) {
    if (scene.problem.empty() && scene.bodies[b].fixed) continue;
    const GridConvergence g = grid_convergence(level_of(fine, b), level_of(medium, b), level_of(coarse, b));
    if (first || g.difference > worst.grid.difference) worst = {g, b};
    first = false;
  }
  return worst;
}

// The order of the next coarser three steps for the same body, compared with that of the finest three and the formal
// one.
std::string range_text(std::span<const LadderEnd> finest, const Worst& worst) {
  if (finest.size() < 4) return "asymptotic range not tested: three steps cannot";
  const GridConvergence coarser = grid_convergence(level_of(finest[1], worst.body), level_of(finest[2], worst.body),
                                                   level_of(finest[3], worst.body));
  // Of two steps nearly the same, both threes say nearly the same; Celik et al. (2008) ask for a ratio of 1.3.
  constexpr double min_ratio = 1.3;
  for (std::size_t k = 0; k + 1 < 4; ++k)
    if (const double ratio = finest[k + 1].h_s / finest[k].h_s; !(ratio >= min_ratio * (1 - 1e-9)))
      return "asymptotic range not tested: two steps differ only by a factor of " + format_measure(ratio, 0, 4) +
             ", below " + format_measure(min_ratio, 0);
  const double formal = finest[0].formal_order;
  std::string orders = "orders " + format_measure(worst.grid.order, 0) + " and, from " +
                       steps_text(finest[1], finest[2], finest[3]) + ", " + format_measure(coarser.order, 0);
  if (formal > 0) orders += "; formal order " + format_measure(formal, 0);
  switch (asymptotic_range(worst.grid.order, coarser.order, formal)) {
    case AsymptoticRange::not_tested: return "asymptotic range not tested: the coarser three steps have no order";
    case AsymptoticRange::agrees: return "asymptotic: " + orders;
    case AsymptoticRange::disagrees: return "not asymptotic: " + orders;
  }
  return "";
}

}  // namespace

std::vector<Row> fit_ends(const Scenario& scenario, std::span<const LadderEnd> ends, std::span<const Row> cells) {
  if (ends.size() < 3 || cells.empty() || cells.front().method.find(':') != std::string::npos) return {};
  std::vector<LadderEnd> sorted(ends.begin(), ends.end());
  std::sort(sorted.begin(), sorted.end(), [](const LadderEnd& a, const LadderEnd& b) { return a.steps > b.steps; });
  const Figures figures = figures_of(cells);
  const double unit = std::max(unit_round_off(cells.front().method), 0x1p-53);
  for (std::size_t i = 0; i + 2 < sorted.size(); ++i) {
    const LadderEnd &fine = sorted[i], &medium = sorted[i + 1], &coarse = sorted[i + 2];
    double size = 0;
    for (const BodySample& b : fine.last.bodies) size = std::max(size, metrics::norm(b.p_m));
    const auto cell = figures.find(fine.steps);
    const double condition = cell == figures.end() ? 1 : std::max(1.0, value_of(cell->second, "condition", 1));
    if (cell != figures.end()) size = std::max(size, value_of(cell->second, "size-position", 0));
    const Worst worst = worst_body(scenario.scene, fine, medium, coarse);
    const GridConvergence& g = worst.grid;
    if (!(g.difference > 30 * round_off_floor(unit, static_cast<double>(fine.steps), size, condition))) continue;
    const std::string steps = steps_text(fine, medium, coarse);
    const bool converges = !g.extrapolated.empty();
    std::vector<Row> rows = {filled(
        metrics::row(
            "richardson-order-position", g.order, 0,
            to_string(g.kind) + "; " + steps + (g.order < 0 ? "; negative: the differences grow as h shrinks" : "")),
        cells.front())};
    if (!converges) {
      rows.push_back(
          filled(metrics::row("gci-position", std::nan(""), 0, "inconclusive: " + to_string(g.kind) + ", " + steps),
                 cells.front()));
      return rows;
    }
    std::string text = to_string(g.kind) + "; " + steps + "; extrapolated";
    for (double x : g.extrapolated) text += " " + format_double(x);
    const std::size_t known = std::min<std::size_t>(sorted.size() - i, 4);
    text += " m; " + range_text(std::span(sorted).subspan(i, known), worst);
    rows.push_back(filled(metrics::row("gci-position", g.index, 0, text), cells.front()));
    const auto error = cell == figures.end() ? std::map<std::string, const Row*>::const_iterator{}
                                             : cell->second.find("error-position-end");
    if (cell != figures.end() && error != cell->second.end() && error->second->value > 3 * error->second->truth_bar)
      rows.push_back(filled(
          metrics::row("gci-effectivity", error->second->value / g.index, error->second->truth_bar / g.index, steps),
          cells.front()));
    return rows;
  }
  return {filled(metrics::row("gci-position", std::nan(""), 0,
                              "inconclusive: no three steps whose differences lie above 30 x the floor"),
                 cells.front())};
}

// Requires a least error with two finer steps whose errors are larger.
std::vector<Row> fit_round_off_v(std::span<const Row> cells) {
  if (cells.empty() || cells.front().method.find(':') != std::string::npos) return {};
  std::vector<const Row*> rungs;
  for (const auto& [steps, cell] : figures_of(cells))
    if (const auto found = cell.find("error-position-end"); found != cell.end() && std::isfinite(found->second->value))
      rungs.push_back(found->second);
  if (rungs.size() < 4) return {};
  const auto best =
      std::min_element(rungs.begin(), rungs.end(), [](const Row* a, const Row* b) { return a->value < b->value; });
  if (best == rungs.begin() || rungs.end() - best < 3) return {};
  const Row& least = **best;
  if (!(least.value > 3 * least.truth_bar)) return {};
  if (!((*(best + 1))->value > least.value) || !((*(best + 2))->value > least.value)) return {};
  const std::string text = std::to_string(least.steps) + " steps; at " + std::to_string(rungs.back()->steps) +
                           " steps " + format_measure(rungs.back()->value, 0) + " m";
  return {filled(metrics::row("round-off-best-error", least.value, least.truth_bar, text), least),
          filled(metrics::row("round-off-best-step", least.h_s, 0, text), least)};
}

std::vector<Row> fit_tolerances(std::span<const Row> rows) {
  struct Ladder {
    std::vector<double> rtol, error, floor;
    const Row* like = nullptr;
  };
  std::map<std::string, Ladder> ladders;                             // by the method's id without its tolerance
  std::map<std::string, std::map<std::string, const Row*>> figures;  // by method
  for (const Row& r : rows)
    if (r.status == Status::ok && r.body.empty() && !r.t_s && r.method.find(':') != std::string::npos)
      figures[r.method][r.metric] = &r;
  std::vector<Row> fitted;
  for (const auto& [method, cell] : figures) {
    MethodId id = parse_method_id(method);
    const auto error = cell.find("error-position-max");
    const double size = value_of(cell, "size-position", 0);
    if (!id.rtol || error == cell.end() || !(size > 0)) continue;
    const double rtol = *id.rtol;
    if (error->second->value > 3 * error->second->truth_bar) {
      Row ratio = filled(
          metrics::row("tolerance-ratio", error->second->value / size / rtol, error->second->truth_bar / size / rtol),
          *error->second);
      ratio.steps = error->second->steps;
      ratio.h_s = error->second->h_s;
      fitted.push_back(ratio);
    }
    id.rtol.reset();
    id.atol.reset();
    Ladder& ladder = ladders[to_string(id)];
    ladder.rtol.push_back(rtol);
    ladder.error.push_back(error->second->value);
    const double steps = value_of(cell, "steps-taken", static_cast<double>(error->second->steps));
    ladder.floor.push_back(
        std::max(error->second->truth_bar,
                 round_off_floor(unit_round_off(method), steps, size, std::max(1.0, value_of(cell, "condition", 1)))));
    ladder.like = error->second;
  }
  for (const auto& [method, ladder] : ladders) {
    if (ladder.rtol.size() < 4) continue;
    const ToleranceFit fit = fit_tolerance(ladder.rtol, ladder.error, ladder.floor);
    Row row = filled(
        metrics::row(
            "tolerance-exponent", fit.conclusive ? fit.exponent : std::nan(""), fit.conclusive ? fit.half_width_95 : 0,
            fit.conclusive ? std::to_string(fit.used) + " of " + std::to_string(ladder.rtol.size()) + " tolerances"
                           : "inconclusive: " + fit.reason),
        *ladder.like);
    row.method = method;
    fitted.push_back(row);
  }
  return fitted;
}

}  // namespace atwood
