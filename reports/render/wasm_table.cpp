#include "wasm_table.hpp"

#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace atwood {
namespace {

struct Times {
  std::int64_t steps = -1;
  double step_s = std::numeric_limits<double>::quiet_NaN(), call_s = step_s;
};

}  // namespace

std::vector<BenchTable> wasm_tables(const std::vector<Row>& rows) {
  std::vector<std::pair<std::string, std::string>> order;  // scenario, method
  std::map<std::pair<std::string, std::string>, Times> all;
  for (const Row& row : rows) {
    const bool step = row.metric == "step-time-wasm", call = row.metric == "call-time-wasm";
    if ((!step && !call) || row.status != Status::ok) continue;
    const auto [place, fresh] = all.try_emplace({row.scenario, row.method});
    if (fresh) order.push_back(place->first);
    Times& times = place->second;
    if (row.steps < times.steps) continue;
    if (row.steps > times.steps) times = {row.steps};
    (step ? times.step_s : times.call_s) = row.value;
  }
  if (order.empty()) return {};
  BenchTable table{
      "wasm-times",
      "Times under WebAssembly",
      {"scenario", "method", "steps", "step [us]", "of it the call [us]", "less the call [us]"},
      {},
      {"What these times tell: what a step costs in a page or in a program under Node.js on this machine, and which of two "
       "settings of one engine costs more.",
       "What they do not tell: how long the same engine takes when it is built for the processor. No table, ranking or "
       "goal sets them beside times of native engines. Errors, drifts and orders are the engine's own: arithmetic in "
       "WebAssembly is that of the processor.",
       "The call: a step of a world without bodies, which is the way from JavaScript into the engine and what it does in "
       "any step. The rest holds what the adapter evaluates in JavaScript: forces that the engine lacks."}};
  for (const auto& key : order) {
    const Times& times = all.at(key);
    table.rows.push_back({key.first, key.second, static_cast<double>(times.steps), 1e6 * times.step_s,
                          1e6 * times.call_s, 1e6 * (times.step_s - times.call_s)});
  }
  return {table};
}

}  // namespace atwood
