// Advice: which method, at which step or tolerance, for a wanted error or a budget of time, with its evidence.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "reports/command_line/command_line.hpp"

namespace atwood {

// What moves in a scene decides who may compete.
struct MotionClass {
  bool rotates = false, velocity_dependent = false, conservative = false, contacts = false, magnetic = false,
       bare = false, fluids = false, mechanism = false, loop = false;
};
MotionClass classify(const Scene& scene);
std::string class_words(const MotionClass& motion);  // "rotation, no velocity-dependent force"

// Ids to try, in that order, and why others are not.
struct Candidates {
  std::vector<std::string> ids;
  std::size_t firsts = 0;                                     // so many head the list: one of each engine
  std::size_t short_list = 0;                                 // so many, those included, are tried before the others
  std::vector<std::pair<std::string, std::string>> left_out;  // reason, methods
};
// Every method of every engine that is here, but for those of ours that claim nothing for the scene's kind of motion:
// the ones made for it first, one's own engines, rivals, then all others. Among those that come first, and among the
// others, the engines take turns, a method each. Of a scene with fluids: a short list of ours, and every method of the
// other engines that simulate fluids.
Candidates choose_candidates(const Scene& scene, const std::vector<Worker>& workers, std::size_t own_engines);
// --same-rate: ours as their twins on the reference's rate, libraries as they are; all others are left out with the
// reason.
Candidates at_same_rate(const Candidates& candidates, const std::vector<Worker>& workers);
// Those that were named, ids or globs. InputError: no engine offers one of them.
Candidates named_candidates(const std::vector<std::string>& methods, const std::vector<Worker>& workers);

// A scene without a truth gets one: certified in extended precision, else CVODE's, else a method's own convergence,
// written to a file of values in `folder`. `words` says which. Throws InputError where none can be had.
struct AdviceTruth {
  Scenario scenario;
  std::string words;
};
AdviceTruth find_truth(const Place& place, const Scenario& scenario, const std::vector<Worker>& workers,
                       const Candidates& candidates, const std::string& folder, double limit_s);

// One measured run that the advice stands on.
struct AdviceRung {
  std::string method;
  std::int64_t steps = 0;
  double h_s = 0, error = 0, bar = 0, seconds = 0, evaluations = 0;
  Resolution at = {};
};
struct Advice {
  Scenario scenario;
  MotionClass motion;
  std::string metric, unit, truth;
  std::string rates;                      // whose right-hand sides the methods evaluate; empty: each its engine's own
  double wanted_error = 0, budget_s = 0;  // one of them; 0: the other was asked
  bool found = false;
  bool under_wasm = false;  // some method that reached it was timed under WebAssembly alone, and is not ranked
  AdviceRung best, next;    // next.method empty: none
  std::optional<AdviceRung> coarser, finer;  // the rungs beside it on its ladder
  std::string no_coarser;                    // where there is no coarser rung: why
  std::optional<TimedRatio> next_over_best;  // of times, in turns
  std::string not_judged;                    // coordinates of another unit, with their error; empty: none
  std::string caution;                       // what speaks against it; empty: nothing
  std::vector<std::pair<std::string, std::string>> left_out;
  int runs = 0;
  std::vector<std::string> rerun;  // the words of the command that runs `best` alone
};
std::string advice_text(const Advice& advice);
std::string advice_json(const Advice& advice);

}  // namespace atwood
