// The candidates of a goal: which cells they run, in which order, and which rungs cannot be the cheapest.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "benchmarks/goals.hpp"
#include "validation/study/study.hpp"

namespace atwood {

// `library`: a rival that evaluates the reference's rate; `same_rate`: our method with that rate.
enum class Side { ours, rival, uncounted, library, same_rate };

inline bool is_rival(Side side) { return side == Side::rival || side == Side::library; }

struct Candidate {
  Side side = Side::ours;
  const Cell* cell = nullptr;
  GoalEntrant entrant;
  std::vector<double> times_s;  // one per round; NaN: it did not take part
};

struct PlannedCell {
  Cell cell;
  Side side = Side::ours;
};

// The cells of a goal in the order in which they run: first all without a tolerance and the coarser half of the
// tolerances, then one tolerance after another. Throws InputError.
std::vector<std::vector<PlannedCell>> plan_waves(const Goal& goal, const Scenario& scenario, bool with_rivals,
                                                 const std::vector<Worker>& workers, const std::string& cpu);

// Which finer rungs of rivals need not run: a coarser rung of the same method needed more than kMaxEvaluations times
// the evaluations of the cheapest rung of the same engine that reaches the error. A method of order 2 needs a million
// steps for 1e-12.
class CostlyRungs {
 public:
  void note(const GoalEntrant& entrant);  // of a rung that ran
  bool leaves_out(const PlannedCell& planned) const;

 private:
  std::map<std::string, double> of_engine_, of_family_;  // least that reaches the error; most of any rung
};

// Leaves those that can be their side's cheapest: of the rungs of one method the two that need the fewest evaluations
// and those within kFinerRungs of the fewest; of rivals, those within kMaxEvaluations of the fewest of their engine.
// All reach the error. Those that count no evaluations stay.
inline constexpr double kFinerRungs = 1.3;
void leave_cheap(std::vector<Candidate*>& accurate);

}  // namespace atwood
