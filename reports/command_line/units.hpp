// What a user asks in units of their own: "1e-6rad", "0.1mm", 240 steps a second.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "reports/command_line/command_line.hpp"
#include "validation/metrics/work_precision.hpp"

namespace atwood {

// --metric, --error and --budget: the metric's full name (empty where neither a metric nor a unit names one), the error
// in that metric's unit, the budget in seconds. Of the coordinates of joints the unit chooses angles or offsets; both
// without one. Throws InputError: a number or a unit that is none, a unit that is not the metric's.
Question read_question(const Options& options);

// --hz: the scenarios' ladders become t_end_s times each frequency. Throws InputError, with the nearest frequency that
// works, where that is not a whole number or the scenario's samples do not divide it.
void set_frequency(Scenario& scenario, const std::vector<double>& hz);
// The same of many scenarios, whose blocks of the study then have no steps of their own. What is wrong with a scenario
// is returned by its id, for it may be one that has no cells; require_frequencies throws InputError if it has.
std::map<std::string, std::string> set_frequencies(std::vector<Scenario>& scenarios, const std::vector<double>& hz,
                                                   Study& study);
void require_frequencies(const std::vector<Cell>& cells, const std::map<std::string, std::string>& unfit);

}  // namespace atwood
