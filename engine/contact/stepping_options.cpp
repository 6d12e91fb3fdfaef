#include "contact/stepping_options.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <variant>

namespace atwood::stepping {

Settings default_settings() {
  const Options standard;
  return {{"solver", std::string("auto")},
          {"direct_points", std::int64_t(standard.direct_points)},
          {"substeps", std::int64_t(standard.substeps)},
          {"iterations", std::int64_t(standard.iterations)},
          {"rest_sweeps", std::int64_t(standard.rest_sweeps)},
          {"broad_phase", std::string("tree")},
          {"correction", standard.correction},
          {"restitution", std::string("newton")},
          {"warm_start", standard.warm_start},
          {"threads", std::int64_t(standard.threads)},
          {"sleeping", standard.sleeping},
          {"sleep_after_s", standard.sleep_after_s},
          {"sleep_below_m_per_s", standard.sleep_below_m_per_s}};
}

namespace {

int count_of(const Settings& settings, const char* name, std::int64_t least, std::int64_t most, std::string& why) {
  const auto value = std::get<std::int64_t>(settings.at(name));
  if (value < least || value > most)
    why = "+impulse: " + std::string(name) + " is " + std::to_string(least) + " to " + std::to_string(most);
  return static_cast<int>(value);
}

}  // namespace

int substeps_of(const Options& options, double h_s) {
  constexpr double min_substeps_per_s = 480, round_off = 1e-9;
  if (options.substeps > 0) return options.substeps;
  return static_cast<int>(std::clamp(std::ceil(h_s * min_substeps_per_s * (1 - round_off)), 4.0, 1000.0));
}

Options options_of(const Settings& settings, std::string& why) {
  Options options;
  const auto& solver = std::get<std::string>(settings.at("solver"));
  if (solver == "sequential") options.solver = Solver::sequential;
  else if (solver == "direct") options.solver = Solver::direct;
  else if (solver != "auto") why = "+impulse: solver is auto, sequential or direct, not `" + solver + "`";
  options.direct_points = count_of(settings, "direct_points", 1, 1000, why);
  options.substeps = count_of(settings, "substeps", 0, 1000, why);
  options.iterations = count_of(settings, "iterations", 1, 100000, why);
  options.rest_sweeps = count_of(settings, "rest_sweeps", 0, 100000, why);
  options.correction = std::get<double>(settings.at("correction"));
  if (!(options.correction >= 0 && options.correction <= 1)) why = "+impulse: correction is 0 to 1";
  try {
    options.broad_phase = broad_phase_kind(std::get<std::string>(settings.at("broad_phase")));
  } catch (const std::invalid_argument& fault) {
    why = std::string("+impulse: ") + fault.what();
  }
  const auto& law = std::get<std::string>(settings.at("restitution"));
  if (law == "poisson") options.restitution = Restitution::poisson;
  else if (law == "stronge") options.restitution = Restitution::stronge;
  else if (law != "newton") why = "+impulse: restitution is newton, poisson or stronge, not `" + law + "`";
  options.warm_start = std::get<bool>(settings.at("warm_start"));
  options.threads = count_of(settings, "threads", 1, 256, why);
  options.sleeping = std::get<bool>(settings.at("sleeping"));
  options.sleep_after_s = std::get<double>(settings.at("sleep_after_s"));
  options.sleep_below_m_per_s = std::get<double>(settings.at("sleep_below_m_per_s"));
  if (!(options.sleep_after_s >= 0)) why = "+impulse: sleep_after_s is 0 or more";
  if (!(options.sleep_below_m_per_s > 0)) why = "+impulse: sleep_below_m_per_s is above 0";
  return options;
}

}  // namespace atwood::stepping
