// The parts that the JSON report and the data inside the HTML report have in common.
#pragma once

#include "json_text.hpp"
#include "ran_methods.hpp"
#include "reports/report.hpp"

namespace atwood {

void append_provenance(JsonText& json, const Provenance& provenance);
void append_scenarios(JsonText& json, const std::vector<Scenario>& scenarios);
void append_engines(JsonText& json, const std::vector<Engine>& engines);
void append_ran(JsonText& json, const std::vector<RanMethod>& ran);
void append_missing(JsonText& json, const std::vector<std::pair<std::string, std::string>>& missing);
void append_metrics(JsonText& json, const std::vector<MetricInfo>& metrics);
void append_verdicts(JsonText& json, const std::vector<Verdict>& verdicts);
void append_laws(JsonText& json, const std::vector<Law>& laws);
void append_bench(JsonText& json, const std::vector<BenchFigure>& bench);
void append_dominance(JsonText& json, const std::vector<Dominance>& tables,
                      std::size_t ranks);  // the best `ranks` of each
void append_audit(JsonText& json, const std::vector<AuditFinding>& findings);
void append_refused_truths(JsonText& json, const std::vector<RefusedTruth>& truths);
void append_claimed_orders(JsonText& json, const std::vector<ClaimedOrder>& orders);
void append_baseline(JsonText& json, const std::vector<BaselineChange>& changes);  // what is not unchanged
void append_overheads(JsonText& json, const std::vector<MethodOverhead>& overheads);
void append_goals(JsonText& json, const std::vector<GoalResult>& goals);

}  // namespace atwood
