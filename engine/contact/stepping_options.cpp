#include "contact/stepping_options.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

namespace atwood::stepping {

std::vector<Setting> setting_table() {
  const Options standard;
  return {
      {"solver",
       std::string("auto"),
       {one_of({"auto", "sequential", "direct"}),
        "Solver of an island's contacts: projected Gauss-Seidel sweeps (sequential), Newton's method on all of them (direct), or "
        "one of the two, by the number of points (auto)."}},
      {"direct_points",
       std::int64_t(standard.direct_points),
       {between(1, 1000),
        "Largest number of contact points of an island that is solved directly. With solver=direct a larger island ends the "
        "run; with auto it is solved by sweeps, and so are scenes in motion with more than 32 points."}},
      {"substeps",
       std::int64_t(standard.substeps),
       {between(0, 1000), "Substeps of a step; 0: at least 4, none longer than 1/480 s."}},
      {"iterations", std::int64_t(standard.iterations), {between(1, 100000), "Velocity sweeps of a substep."}},
      {"rest_sweeps",
       std::int64_t(standard.rest_sweeps),
       {between(0, 100000),
        "Maximum number of velocity sweeps of a substep at rest (at most 1000 pairs, no body faster than the velocity that gravity adds in "
        "a substep); they end when the velocities converge."}},
      {"broad_phase", std::string("tree"), {one_of(broad_phase_names()), "Algorithm that finds pairs of near bodies."}},
      {"correction",
       standard.correction,
       {between(0, 1), "Fraction of the overlap that a substep removes, by moving only positions."}},
      {"restitution", std::string("newton"), {one_of({"newton", "poisson", "stronge"}), "Law of restitution."}},
      {"warm_start", standard.warm_start, {{}, "The sweeps begin with the impulses of the substep before."}},
      {"threads", std::int64_t(standard.threads), {between(1, 256), "Threads that share a step."}},
      {"sleeping",
       standard.sleeping,
       {{}, "Islands at rest are treated as fixed until a moving body comes near; their remaining momentum is lost."}},
      {"sleep_after_s", standard.sleep_after_s, {between(0, 1e9), "Time at rest after which an island sleeps.", "s"}},
      {"sleep_below_m_per_s",
       standard.sleep_below_m_per_s,
       {{0, 1e6, true, false}, "Speed of its fastest point below which an island counts as at rest.", "m/s"}}};
}

int substeps_of(const Options& options, double h_s) {
  constexpr double min_substeps_per_s = 480, round_off = 1e-9;
  if (options.substeps > 0) return options.substeps;
  return static_cast<int>(std::clamp(std::ceil(h_s * min_substeps_per_s * (1 - round_off)), 4.0, 1000.0));
}

Options options_of(const Settings& settings) {
  const auto word = [&](const char* name) -> const std::string& { return std::get<std::string>(settings.at(name)); };
  const auto count = [&](const char* name) { return static_cast<int>(std::get<std::int64_t>(settings.at(name))); };
  const auto real = [&](const char* name) { return std::get<double>(settings.at(name)); };
  Options options;
  if (word("solver") == "sequential") options.solver = Solver::sequential;
  else if (word("solver") == "direct") options.solver = Solver::direct;
  options.direct_points = count("direct_points");
  options.substeps = count("substeps");
  options.iterations = count("iterations");
  options.rest_sweeps = count("rest_sweeps");
  options.correction = real("correction");
  options.broad_phase = broad_phase_kind(word("broad_phase"));
  if (word("restitution") == "poisson") options.restitution = Restitution::poisson;
  else if (word("restitution") == "stronge") options.restitution = Restitution::stronge;
  options.warm_start = std::get<bool>(settings.at("warm_start"));
  options.threads = count("threads");
  options.sleeping = std::get<bool>(settings.at("sleeping"));
  options.sleep_after_s = real("sleep_after_s");
  options.sleep_below_m_per_s = real("sleep_below_m_per_s");
  return options;
}

}  // namespace atwood::stepping
