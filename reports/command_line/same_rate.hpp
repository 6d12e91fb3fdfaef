// Methods of ours beside those of a library (benchmarks/rates.hpp): which ids run, and which rows are ranked.
#pragma once

#include <string>
#include <vector>

#include "benchmarks/rates.hpp"
#include "reports/command_line/command_line.hpp"
#include "reports/command_line/contest.hpp"

namespace atwood {

// "atwood-same-rate/rk4:1e-8" of "atwood/rk4:1e-8"; empty where no worker of `workers` offers it.
std::string same_rate_twin(const std::string& method, const std::vector<Worker>& workers);
// "atwood/rk4:1e-8" of "atwood-same-rate/rk4:1e-8"; any other id is itself.
std::string native_twin(const std::string& method);
// `workers` without the same-rate worker, which is not an engine of its own.
std::vector<Worker> without_same_rate(std::vector<Worker> workers);

// What a comparison ranks by. `twins`: ids to run beside the named ones.
struct RankedRates {
  bool same = false;
  std::string words;  // the headline: a sentence
  std::vector<std::string> twins;
};
// At the same rate where --same-rate asks for it, or where nothing but libraries' methods and ours that have a twin are
// compared, some of each, and times are measured. Throws InputError where --same-rate is asked of methods none of which
// has a twin. `methods`: ids, tolerances spelled out.
RankedRates choose_rates(const Options& options, const std::vector<std::string>& methods,
                         const std::vector<Worker>& workers);
// The rows that are ranked: without what evaluates a rate of its own. Where a twin has no run of a scenario (forces
// that switch, say), its native method keeps its place there; `notes` gets a sentence on each method that is left out
// or kept.
std::vector<Row> ranked_rows(const std::vector<Row>& rows, std::vector<std::string>& notes);

std::string overhead_text(const std::vector<MethodOverhead>& overheads, const std::string& scenario);

}  // namespace atwood
