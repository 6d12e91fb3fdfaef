// Makes the cells of a study from its blocks, the catalogue and the workers; each cell has a hash of all that decides
// its result.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numeric>
#include <set>
#include <unordered_map>

#include "protocol/wire.hpp"
#include "scene/files.hpp"
#include "scene/fluid_points.hpp"
#include "validation/gates/gates.hpp"
#include "validation/metrics/instants.hpp"
#include "validation/metrics/probes.hpp"
#include "validation/study/content_hash.hpp"
#include "validation/study/key_table.hpp"
#include "validation/study/short_text.hpp"
#include "validation/study/study.hpp"

namespace atwood {
namespace {

constexpr std::size_t kLongestName = 200;  // bytes of a name quoted in a message

std::string base_id(const MethodId& id) { return id.scheme.empty() ? id.engine : id.engine + "/" + id.scheme; }

bool scenario_matches(const std::vector<std::string>& names, const Scenario& scenario) {
  return std::any_of(names.begin(), names.end(),
                     [&](const std::string& name) { return names_scenario(name, scenario); });
}

// A method of the plan and the worker that runs it.
struct Offer {
  std::string text;  // the id in rows
  int worker = -1;
  const MethodInfo* info = nullptr;
  std::string pattern = {};  // the glob of the study that it comes from
};

struct Found {
  int worker = -1;
  const MethodInfo* info = nullptr;
};

Found find_method(const std::string& base, const std::vector<Worker>& workers) {
  for (std::size_t i = 0; i < workers.size(); ++i) {
    if (workers[i].status != Status::ok) continue;
    for (const MethodInfo& info : workers[i].engine.methods) {
      if (info.id == base) return {static_cast<int>(i), &info};
    }
  }
  return {};
}

// A sweep of poses asks an engine's contact test ("bullet64/contacts"), which integrates no motion.
std::vector<Offer> contact_test(const std::string& text, const std::vector<Worker>& workers) {
  static const MethodInfo test{};
  const std::string engine = parse_method_id(text).engine;
  for (std::size_t i = 0; i < workers.size(); ++i)
    if (workers[i].status == Status::ok && workers[i].engine.name == engine)
      return {{text, static_cast<int>(i), &test}};
  return {{text, -1, nullptr}};
}

// "bullet64/*", "atwood/*+event@float": the glob is over base ids; the suffixes are kept.
std::vector<Offer> expand(const std::string& pattern, const std::vector<Worker>& workers) {
  try {  // parsed with a letter in place of the glob
    std::string sample = pattern;
    std::replace_if(
        sample.begin(), sample.end(), [](char c) { return c == '*' || c == '?'; }, 'x');
    if (sample.find('/') != std::string::npos || !has_glob(pattern)) parse_method_id(sample);
  } catch (const std::invalid_argument& error) {
    throw InputError(error.what());
  }
  if (!has_glob(pattern)) {
    const Found found = find_method(base_id(parse_method_id(pattern)), workers);
    return {{pattern, found.worker, found.info}};
  }
  const std::size_t cut = std::min(pattern.find_first_of(":+@{"), pattern.size());
  std::vector<Offer> offers;
  for (std::size_t i = 0; i < workers.size(); ++i) {
    if (workers[i].status != Status::ok) continue;
    for (const MethodInfo& info : workers[i].engine.methods) {
      if (glob_match(pattern.substr(0, cut), info.id) && find_method(info.id, workers).info == &info) {
        offers.push_back({info.id + pattern.substr(cut), static_cast<int>(i), &info});
      }
    }
  }
  if (offers.empty()) offers.push_back({pattern, -1, nullptr});
  return offers;
}

const MethodInfo* find_response(const MethodId& id, const Offer& offer, const std::vector<Worker>& workers) {
  if (id.response.empty() || offer.worker < 0) return nullptr;
  for (const MethodInfo& info : workers[static_cast<std::size_t>(offer.worker)].engine.responses)
    if (info.id == "+" + id.response) return &info;
  return nullptr;
}

// The order that a method claims, at most what its response permits: a response's claim "fluid{kernel=cubic}": 3 bounds
// the order in the class of motion "fluid" where that setting has that value.
double claimed_order(const StudyCells& cells, const Offer& offer, const std::string& method,
                     const std::vector<Worker>& workers) {
  if (cells.claim.empty() || offer.info == nullptr) return 0;
  const auto found = offer.info->claimed_order.find(cells.claim);
  if (found == offer.info->claimed_order.end()) return 0;
  double order = found->second;
  const MethodId id = parse_method_id(method);
  const MethodInfo* response = find_response(id, offer, workers);
  if (response == nullptr) return order;
  Settings settings = response->settings;
  for (const auto& [key, value] : id.overrides) settings[key] = value;
  for (const auto& [key, value] : settings) {
    const auto bound = response->claimed_order.find(cells.claim + "{" + key + "=" + value_words(value) + "}");
    if (bound != response->claimed_order.end()) order = std::min(order, bound->second);
  }
  return order;
}

bool excepted(const StudyCells& cells, const Offer& offer) {
  if (offer.info == nullptr) return false;
  return std::any_of(cells.except.begin(), cells.except.end(),
                     [&](const std::string& pattern) { return glob_match(pattern, offer.info->id); });
}

bool claims(const StudyCells& cells, const Offer& offer, const std::vector<Worker>& workers) {
  if (cells.claim.empty()) return true;
  const double order = claimed_order(cells, offer, offer.text, workers);
  return order > 0 && order >= cells.least_order && order <= cells.most_order;
}

// Whether the method or its response has the swept setting. An absent engine, or one that lists no settings, may have
// it.
bool has_setting(const Offer& offer, const std::string& key, const std::vector<Worker>& workers) {
  if (!offer.info || offer.info->settings.empty() || offer.info->settings.contains(key)) return true;
  const auto& responses = workers[static_cast<std::size_t>(offer.worker)].engine.responses;
  const std::string response = "+" + parse_method_id(offer.text).response;
  return std::any_of(responses.begin(), responses.end(),
                     [&](const MethodInfo& info) { return info.id == response && info.settings.contains(key); });
}

void check_sweep(const StudyCells& cells, const std::vector<Offer>& offers, const std::vector<Worker>& workers,
                 const Study& study) {
  for (const auto& [key, values] : cells.sweep) {
    const bool known = std::any_of(offers.begin(), offers.end(),
                                   [&, &key = key](const Offer& offer) { return has_setting(offer, key, workers); });
    if (known || offers.empty()) continue;
    std::string methods;
    for (const std::string& method : cells.methods) methods += (methods.empty() ? "" : ", ") + method;
    throw InputError(cells.place + "study `" + study.id + "`: sweep over `" + shortened(key, kLongestName) +
                     "`: no method of the block has this setting: " + shortened(methods, 5 * kLongestName) +
                     "; `atwood describe METHOD` prints the settings");
  }
}

// Every combination of the swept settings that this method has; one empty combination where it has none of them.
std::vector<Settings> combinations(const StudyCells& cells, const Offer& offer, const std::vector<Worker>& workers) {
  std::vector<Settings> all{{}};
  for (const auto& [key, values] : cells.sweep) {
    if (!has_setting(offer, key, workers)) continue;
    std::vector<Settings> next;
    for (const Settings& before : all) {
      for (const SettingValue& value : values) {
        next.push_back(before);
        next.back()[key] = value;
      }
    }
    all = std::move(next);
  }
  return all;
}

std::string with_settings(const std::string& method, const Settings& settings) {
  if (settings.empty()) return method;
  MethodId id = parse_method_id(method);
  for (const auto& [key, value] : settings) id.overrides[key] = value;
  return to_string(id);
}

// Sets the reason why the cell has no worker: that of the engine's executable, if there is one.
void explain_absence(Cell& cell, const std::vector<Worker>& workers) {
  cell.absent_reason = "no available engine provides " + cell.method;
  const Worker* worker = unanswered(workers, cell.method.substr(0, cell.method.find('/')));
  if (worker == nullptr) return;
  cell.absent = worker->status;
  cell.absent_reason = worker->reason;
}

bool frames_taken(const Cell& cell, const std::vector<Worker>& workers) {
  return cell.worker < 0 || cell.plan.frame_ends_s.empty() ||
         workers[static_cast<std::size_t>(cell.worker)].engine.frames;
}

void refuse_frames(Cell& cell) {
  cell.absent_reason = cell.method.substr(0, cell.method.find('/')) + " takes equal steps, no recorded frames";
  cell.absent = Status::unsupported;
  cell.worker = -1;
}

// What a method adds to the hashes of its cells.
struct HashedMethod {
  std::string canonical, with_settings, version;  // the id; with all settings; the engine's
};

HashedMethod hashed_method(const std::string& method, const Offer& offer, const std::vector<Worker>& workers) {
  const Worker& worker = workers[static_cast<std::size_t>(offer.worker)];
  MethodId id = parse_method_id(method);
  HashedMethod hashed{to_string(id), "", worker.engine.name + " " + worker.engine.version + " " + worker.engine.scalar};
  Settings all = offer.info->settings;
  for (const MethodInfo& response : worker.engine.responses)
    if (response.id == "+" + id.response) all.insert(response.settings.begin(), response.settings.end());
  for (const auto& [key, value] : id.overrides) all[key] = value;
  id.overrides = std::move(all);
  hashed.with_settings = to_string(id);
  return hashed;
}

void hash_cell(Cell& cell, const HashedMethod& method, const Worker& worker, const std::string& scene_hash,
               const std::string& cpu, const std::string& arithmetic) {
  const auto hash = [](std::initializer_list<std::string_view> parts) { return ContentHash(content_hash(parts)); };
  cell.settings_hash = std::string_view(hash({method.with_settings, method.version}));
  const std::int64_t samples = cell.scenario->samples;
  cell.accuracy_hash = hash({"cell 2", scene_hash, format_double(cell.plan.t_end_s), std::to_string(cell.plan.steps),
                             std::to_string(samples), method.canonical, method.with_settings,
                             std::to_string(wire::kProtocol), worker.build_id, method.version, arithmetic});
  for (const double end_s : cell.plan.frame_ends_s)
    cell.accuracy_hash = hash({cell.accuracy_hash, format_double(end_s)});
  if (cell.probe != Probe::none) cell.accuracy_hash = hash({cell.accuracy_hash, "probe 1", to_string(cell.probe)});
  if (worker.foreign && !worker.unknown_code.empty()) cell.campaign = worker.build_id;
  cell.timing_hash = hash({"timing 2", cell.accuracy_hash, cpu, std::to_string(cell.repeats)});
  if (cell.plan.samples != samples)  // a timed run has no samples
    cell.accuracy_hash = hash({cell.accuracy_hash, "shared samples", std::to_string(cell.plan.samples)});
}

// The two probes that are ladders of ordinary cells: of scalars and compensated summation, and of tolerances. A method
// that names its scalar or tolerance is left as it is.
std::vector<std::string> ladder_of_probe(Probe probe, const std::string& method, const MethodInfo* info) {
  if (probe == Probe::tolerance && info && info->adaptive && !parse_method_id(method).rtol) {
    std::vector<std::string> methods;
    const std::size_t end = std::min(method.find_first_of("+@{"), method.size());
    for (int digits = 3; digits <= 12; ++digits)
      methods.push_back(method.substr(0, end) + ":1e-" + std::to_string(digits) + method.substr(end));
    return methods;
  }
  if (probe == Probe::round_off_v && info && parse_method_id(method).scalar.empty()) {
    std::vector<std::string> methods;
    for (const char* scalar : {"float", "", "long-double"}) {
      MethodId id = parse_method_id(method);
      id.scalar = scalar;
      methods.push_back(to_string(id));
      if (!info->settings.contains("compensated") || id.overrides.contains("compensated")) continue;
      id.overrides["compensated"] = true;
      methods.push_back(to_string(id));
    }
    return methods;
  }
  return {method};
}

void allow_more(Cell& cell, const std::vector<Status>& allowed) {
  for (const Status status : allowed)
    if (std::find(cell.allow.begin(), cell.allow.end(), status) == cell.allow.end()) cell.allow.push_back(status);
}

// Joins a cell that two blocks name. It counts as named by its id if either block names it so, and may have the
// statuses that either block allows.
void join(Cell& before, const StudyCells& cells, const Offer& offer) {
  if (has_glob(before.pattern)) before.pattern = offer.pattern;
  allow_more(before, cells.allow);
}

// The ids that a block makes of an offer.
std::vector<std::string> ids_of(const StudyCells& cells, const Offer& offer, const std::vector<Worker>& workers) {
  const std::vector<Settings> sweep =
      has_glob(offer.text) ? std::vector<Settings>{{}} : combinations(cells, offer, workers);
  std::vector<std::string> ids;
  for (const Settings& settings : sweep)
    for (std::string& id : ladder_of_probe(cells.probe, with_settings(offer.text, settings), offer.info))
      ids.push_back(std::move(id));
  return ids;
}

std::vector<Offer> offers_of(const StudyCells& cells, const std::vector<Worker>& workers) {
  std::vector<Offer> offers;
  for (const std::string& pattern : cells.methods) {
    for (Offer& offer : is_sweep(cells.probe) ? contact_test(pattern, workers) : expand(pattern, workers)) {
      if (!claims(cells, offer, workers) || excepted(cells, offer)) continue;
      offers.push_back(std::move(offer));
      offers.back().pattern = pattern;
    }
  }
  return offers;
}

// The steps of a block's cells.
std::vector<std::int64_t> ladder_of(const StudyCells& cells, const Scenario& scenario) {
  if (!cells.chosen_steps().empty()) return cells.chosen_steps();
  std::vector<std::int64_t> ladder = scenario.steps;
  if (!cells.whole_ladder) return ladder;
  const std::int64_t coarsest = *std::min_element(ladder.begin(), ladder.end()),
                     least = scenario.scene.fluids.empty() ? 0 : coarsest / 4;
  for (std::int64_t n = coarsest; n % 2 == 0 && (n / 2) % scenario.samples == 0 && n / 2 >= least; n /= 2)
    ladder.push_back(n / 2);
  return ladder;
}

// ---- instants that the rungs of a ladder share --------------------------------------------------------------------
std::int64_t divisor_of(std::int64_t divisor, const std::vector<std::int64_t>& steps) {
  for (const std::int64_t n : steps) divisor = std::gcd(divisor, n);
  return divisor;
}

bool runs_once(const StudyCells& cells) { return cells.probe == Probe::none || is_ladder(cells.probe); }

// By scenario and method: the greatest common divisor of the steps that all blocks give to the ladder, chosen or not by
// the command line. Of scenarios that share no more than their own samples there is none.
using Divisors = std::unordered_map<std::string, std::int64_t>;
std::string ladder_key(const Scenario& scenario, const std::string& method) { return scenario.id + "\n" + method; }

Divisors ladder_divisors(const Study& study, const std::vector<std::vector<Offer>>& offers,
                         const std::vector<Scenario>& catalogue, const std::vector<Worker>& workers) {
  std::vector<const Scenario*> sharing;
  for (const Scenario& scenario : catalogue)
    if (shared_samples(scenario) != scenario.samples) sharing.push_back(&scenario);
  Divisors divisors;
  for (std::size_t block = 0; block < study.cells.size(); ++block) {
    const StudyCells& cells = study.cells[block];
    std::vector<const Scenario*> named;
    for (const Scenario* scenario : sharing)
      if (runs_once(cells) && scenario_matches(cells.scenarios, *scenario)) named.push_back(scenario);
    if (named.empty()) continue;
    for (const Offer& offer : offers[block])
      for (const std::string& id : ids_of(cells, offer, workers))
        for (const Scenario* scenario : named) {
          std::int64_t& divisor = divisors[ladder_key(*scenario, id)];
          divisor = divisor_of(divisor, cells.only_steps);
          if (!cells.steps.empty()) divisor = divisor_of(divisor, cells.steps);
          else divisor = divisor_of(divisor, scenario->steps);
        }
  }
  return divisors;
}

// The samples that the rungs of a ladder share; a run with a tolerance has its samples at any instant.
std::int64_t samples_of_ladder(const Scenario& scenario, const std::string& method, bool adaptive,
                               const Divisors& divisors) {
  const auto found = divisors.find(ladder_key(scenario, method));
  if (found == divisors.end()) return scenario.samples;
  return adaptive ? shared_samples(scenario) : shared_samples(scenario, found->second);
}

// Of a ladder of tolerances, whose steps only set the first one: the fewest that have all the samples, else the fewest.
std::vector<std::int64_t> first_steps(const std::vector<std::int64_t>& ladder, std::int64_t samples) {
  const auto found = std::find_if(ladder.begin(), ladder.end(), [&](std::int64_t n) { return n % samples == 0; });
  return {found == ladder.end() ? ladder.front() : *found};
}

// ---- how many cells -----------------------------------------------------------------------------------------------
constexpr std::int64_t kUncountable = std::numeric_limits<std::int64_t>::max() / 8;

std::int64_t product(std::int64_t a, std::int64_t b) {
  if (a == 0 || b == 0) return 0;
  return a > kUncountable / b ? kUncountable : a * b;
}
std::int64_t sum(std::int64_t a, std::int64_t b) { return std::min(kUncountable, a + b); }

// The number of cells of a block, by multiplication, before any is made; cells named twice count twice.
std::int64_t count_cells(const StudyCells& cells, const std::vector<Offer>& offers,
                         const std::vector<Scenario>& catalogue, const std::vector<Worker>& workers) {
  std::int64_t equal_steps = 0, tolerances = 0, rungs = 0, scenarios = 0;  // with a tolerance: one rung
  const auto count = [](const std::vector<double>& chosen, const std::vector<double>& ladder) {
    return static_cast<std::int64_t>(std::max<std::size_t>(1, (chosen.empty() ? ladder : chosen).size()));
  };
  for (const Offer& offer : offers) {
    std::int64_t swept = 1;
    for (const auto& [key, values] : cells.sweep) {
      if (!has_glob(offer.text) && has_setting(offer, key, workers))
        swept = product(swept, static_cast<std::int64_t>(values.size()));
    }
    for (const std::string& method : ladder_of_probe(cells.probe, offer.text, offer.info)) {
      const bool adaptive = offer.worker >= 0 && parse_method_id(method).rtol.has_value();
      std::int64_t& methods = adaptive ? tolerances : equal_steps;
      methods = sum(methods, swept);
    }
  }
  for (const Scenario& scenario : catalogue) {
    if (!scenario_matches(cells.scenarios, scenario)) continue;
    const std::int64_t resolutions = product(count(cells.spacings_m, scenario.spacings_m),
                                             count(cells.sound_speeds_m_per_s, scenario.sound_speeds_m_per_s));
    scenarios = sum(scenarios, resolutions);
    const std::vector<std::int64_t> steps = ladder_of(cells, scenario);
    rungs = sum(rungs, product(resolutions, static_cast<std::int64_t>(steps.size())));
  }
  return sum(product(equal_steps, rungs), product(tolerances, scenarios));
}

[[noreturn]] void refuse_cells(const Study& study, std::int64_t counted, std::int64_t most_cells) {
  const bool sweeps = std::any_of(study.cells.begin(), study.cells.end(),
                                  [](const StudyCells& cells) { return cells.sweep.size() > 1; });
  const std::string count = counted >= kUncountable ? "more than 10^18" : "up to " + std::to_string(counted);
  throw InputError("study `" + study.id + "` plans " + count + " cells; at most " + std::to_string(most_cells) +
                   " are taken unless --max-cells N allows more" +
                   (sweeps ? "; a sweep of several settings takes every combination" : ""));
}

// ---- resolutions of fluids ----------------------------------------------------------------------------------------
// One of the scenario at this spacing and sound speed, with its particles; of a scene without fluids the scenario
// itself.
struct Resolved {
  Resolution at = {};
  double refinement = 1;  // how many times the steps of the first entries
  Scenario scenario;
};

std::vector<double> entries(const std::vector<double>& chosen, const std::vector<double>& ladder, double own) {
  if (!chosen.empty()) return chosen;
  return ladder.empty() ? std::vector<double>{own} : ladder;
}

std::vector<Resolved> resolutions(const StudyCells& cells, const Scenario& scenario) {
  if (scenario.scene.fluids.empty()) return {{{}, 1, scenario}};
  const Fluid& first = scenario.scene.fluids.front();
  std::vector<Resolved> all;
  const bool exact = !cells.spacings_m.empty() || !cells.sound_speeds_m_per_s.empty();
  for (const double spacing : entries(cells.spacings_m, scenario.spacings_m, first.spacing_m))
    for (const double speed :
         entries(cells.sound_speeds_m_per_s, scenario.sound_speeds_m_per_s, first.sound_speed_m_per_s)) {
      Resolved one{{spacing, speed}, 1, scenario};
      if (!exact || cells.chosen_steps().empty())
        one.refinement = first.spacing_m / spacing * (speed / first.sound_speed_m_per_s);
      // One spacing or speed without a ladder is each fluid's own.
      const bool of_run = !cells.spacings_m.empty() || !scenario.spacings_m.empty();
      const bool speed_of_run = !cells.sound_speeds_m_per_s.empty() || !scenario.sound_speeds_m_per_s.empty();
      if (spacing != first.spacing_m || speed != first.sound_speed_m_per_s)
        one.scenario.scene = at_resolution(scenario, of_run ? spacing : 0, speed_of_run ? speed : 0);
      all.push_back(std::move(one));
    }
  return all;
}

// Rounded up to a multiple of the samples.
std::int64_t refined(std::int64_t steps, double refinement, std::int64_t samples) {
  if (refinement == 1) return steps;
  const double wanted =
      static_cast<double>(steps) * refinement / static_cast<double>(std::max<std::int64_t>(1, samples));
  return std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(wanted * (1 - 1e-12)))) *
         std::max<std::int64_t>(1, samples);
}

// What tells a planned cell from all others.
std::string key_of(const std::string& scenario, const std::string& method, std::int64_t steps, Probe probe,
                   const Resolution& at) {
  return scenario + "\n" + method + "\n" + std::to_string(steps) + "\n" + to_string(probe) + "\n" + resolution_text(at);
}

bool fluids_taken(const Cell& cell, const std::vector<Worker>& workers) {
  return cell.worker < 0 || cell.scenario->scene.fluids.empty() ||
         workers[static_cast<std::size_t>(cell.worker)].engine.fluids;
}

void refuse_fluids(Cell& cell) {
  cell.absent_reason = cell.method.substr(0, cell.method.find('/')) + " simulates no fluids";
  cell.absent = Status::unsupported;
  cell.worker = -1;
}

bool joints_taken(const Cell& cell, const std::vector<Worker>& workers) {
  return cell.worker < 0 || (cell.scenario->scene.joints.empty() && cell.scenario->scene.ropes.empty()) ||
         workers[static_cast<std::size_t>(cell.worker)].engine.joints;
}

void refuse_joints(Cell& cell) {
  cell.absent_reason = cell.method.substr(0, cell.method.find('/')) + " simulates no joints";
  cell.absent = Status::unsupported;
  cell.worker = -1;
}

void check_steps(const StudyCells& cells, const Scenario& scenario, const Study& study) {
  for (const std::int64_t n : cells.chosen_steps().empty() ? scenario.steps : cells.chosen_steps()) {
    if (scenario.samples > 0 && n % scenario.samples == 0) continue;
    throw InputError(cells.place + "study `" + study.id + "`: steps = " + std::to_string(n) + " on `" + scenario.id +
                     "`; expected a multiple of its " + std::to_string(scenario.samples) + " samples");
  }
}

}  // namespace

std::vector<Cell> plan_cells(const Study& study, const std::vector<Scenario>& catalogue,
                             const std::vector<Worker>& workers, const std::string& cpu, std::int64_t most_cells,
                             const std::string& arithmetic) {
  std::vector<Cell> planned;
  std::int64_t counted = 0;  // before cells named twice are left out
  // A cell named twice is planned once, with the larger number of repeats: the cells by their names.
  KeyTable<std::size_t> index;
  // Its place; of a new cell that behind the last one.
  const auto place_of = [&](const std::string& key) { return *index.insert(key_sum(key), planned.size()).first; };
  std::vector<std::vector<Offer>> all_offers;  // by block
  for (const StudyCells& cells : study.cells) {
    all_offers.push_back(offers_of(cells, workers));
    check_sweep(cells, all_offers.back(), workers, study);
    counted = sum(counted, count_cells(cells, all_offers.back(), catalogue, workers));
    if (counted > product(4, most_cells)) refuse_cells(study, counted, most_cells);
  }
  planned.reserve(static_cast<std::size_t>(std::min(counted, most_cells)));
  const Divisors divisors = ladder_divisors(study, all_offers, catalogue, workers);
  for (std::size_t block = 0; block < study.cells.size(); ++block) {
    const StudyCells& cells = study.cells[block];
    const std::vector<Offer>& offers = all_offers[block];
    std::vector<Resolved> scenarios;
    for (const Scenario& scenario : catalogue) {
      if (!scenario_matches(cells.scenarios, scenario)) continue;
      check_steps(cells, scenario, study);
      for (Resolved& one : resolutions(cells, scenario)) scenarios.push_back(std::move(one));
    }
    for (const Resolved& resolved : scenarios) {
      const auto shared = std::make_shared<const Scenario>(resolved.scenario);
      const Scenario& scenario = *shared;
      const std::string scene_hash = content_hash(std::string_view(scene_to_json(scenario.scene)));
      std::vector<std::int64_t> ladder = ladder_of(cells, scenario);
      for (std::int64_t& steps : ladder) steps = refined(steps, resolved.refinement, scenario.samples);
      std::sort(ladder.begin(), ladder.end());
      for (const Offer& offer : offers) {
        for (const std::string& method : ids_of(cells, offer, workers)) {
          const bool adaptive = offer.worker >= 0 && parse_method_id(method).rtol.has_value();
          const HashedMethod hashed = offer.worker >= 0 ? hashed_method(method, offer, workers) : HashedMethod{};
          const Probe probe = is_ladder(cells.probe) ? Probe::none : cells.probe;
          const std::int64_t samples =
              probe == Probe::none ? samples_of_ladder(scenario, method, adaptive, divisors) : scenario.samples;
          for (const std::int64_t steps : adaptive ? first_steps(ladder, samples) : ladder) {
            const std::string key = key_of(scenario.id, method, steps, probe, resolved.at);
            const std::size_t place = place_of(key);
            const bool fresh = place == planned.size();
            if (!fresh) join(planned[place], cells, offer);
            if (!fresh && planned[place].repeats >= cells.repeats) {
              if (!cells.claim.empty()) {
                planned[place].claim = cells.claim;
                planned[place].claimed_order = claimed_order(cells, offer, method, workers);
              }
              continue;
            }
            Cell cell{shared,
                      method,
                      {scenario.t_end_s, steps, std::gcd(samples, steps), scenario.frame_ends_s},
                      offer.worker,
                      cells.repeats,
                      cells.claim,
                      claimed_order(cells, offer, method, workers),
                      {},
                      {},
                      {},
                      Status::not_built,
                      {},
                      probe,
                      cells.limit_s,
                      fresh ? offer.pattern : planned[place].pattern,
                      fresh ? cells.allow : planned[place].allow};
            cell.spacing_m = resolved.at.first, cell.sound_speed_m_per_s = resolved.at.second;
            if (probe != Probe::none) cell.repeats = 0;
            if (!frames_taken(cell, workers)) refuse_frames(cell);
            else if (!fluids_taken(cell, workers)) refuse_fluids(cell);
            else if (!joints_taken(cell, workers)) refuse_joints(cell);
            else if (offer.worker >= 0)
              hash_cell(cell, hashed, workers[static_cast<std::size_t>(offer.worker)], scene_hash, cpu, arithmetic);
            else explain_absence(cell, workers);
            if (fresh && static_cast<std::int64_t>(planned.size()) >= most_cells)
              refuse_cells(study, counted, most_cells);
            if (fresh) planned.push_back(std::move(cell));
            else planned[place] = std::move(cell);
          }
        }
      }
    }
  }
  return planned;
}

bool names_scenario(const std::string& name, const Scenario& scenario) {
  if (name.rfind("tag:", 0) != 0) return glob_match(name, scenario.id);
  return std::any_of(scenario.tags.begin(), scenario.tags.end(),
                     [&](const std::string& tag) { return glob_match(name.substr(4), tag); });
}

}  // namespace atwood
