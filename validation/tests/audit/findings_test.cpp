#include <catch2/catch.hpp>
#include <cmath>

#include "reports/report.hpp"

using namespace atwood;

namespace {

Row order_row(const std::string& method, const std::string& scenario, double value,
              const std::string& metric = "order-position") {
  Row row;
  row.method = method;
  row.scenario = scenario;
  row.metric = metric;
  row.value = value;
  row.truth_bar = 0.01;
  row.reason = "60..480 steps";
  return row;
}

std::vector<Engine> library() {
  Engine engine, ours;
  engine.name = "lib";
  MethodInfo four, none;
  four.id = "lib/four";
  four.claimed_order["point-mass"] = 4;
  none.id = "lib/none";
  engine.methods = {four, none};
  ours.name = "atwood";
  four.id = "atwood/four";
  ours.methods = {four};
  return {ours, engine};
}

AuditVerdict verdict_of(const std::vector<double>& orders) {
  std::vector<Row> rows;
  for (std::size_t i = 0; i < orders.size(); ++i)
    rows.push_back(order_row("lib/four", "s" + std::to_string(i), orders[i]));
  const auto findings = audit_orders(library(), rows);
  REQUIRE(findings.size() == 1);
  CHECK(findings[0].claimed == 4);
  return findings[0].verdict;
}

}  // namespace

TEST_CASE("An executed order within a quarter of a whole one is evidence of that one") {
  const double nan = std::nan("");
  CHECK(verdict_of({4.2, 3.8}) == AuditVerdict::as_claimed);
  CHECK(verdict_of({3.05}) == AuditVerdict::lower);
  CHECK(verdict_of({4.98}) == AuditVerdict::higher);
  CHECK(verdict_of({3.5}) == AuditVerdict::inconclusive);  // between
  CHECK(verdict_of({nan}) == AuditVerdict::inconclusive);
  CHECK(verdict_of({4.0, nan}) == AuditVerdict::as_claimed);
  CHECK(verdict_of({4.0, 5.0, 3.0}) == AuditVerdict::lower);  // one problem is enough
  CHECK(verdict_of({4.0, 5.0}) == AuditVerdict::as_claimed);  // one above may be luck
  CHECK(verdict_of({4.0, 5.0, 5.0}) == AuditVerdict::higher);
  CHECK(verdict_of({nan, 5.0}) == AuditVerdict::higher);
  CHECK(verdict_of({-1.0}) == AuditVerdict::inconclusive);  // round-off
  CHECK(verdict_of({-0.02}) == AuditVerdict::lower);
}

TEST_CASE("The order of velocities is used where that of positions is inconclusive; a refusal keeps its reason") {
  std::vector<Row> rows = {
      order_row("lib/four@float", "a", std::nan("")), order_row("lib/four@float", "a", 4.1, "order-velocity"),
      order_row("lib/four@float", "c", std::nan("")), order_row("lib/four@float", "c", 3.0, "order-velocity")};
  Row refused;
  refused.method = "lib/four@float";
  refused.scenario = "b";
  refused.metric = "status";
  refused.status = Status::unsupported;
  refused.reason = "no such force";
  rows.push_back(refused);
  const auto findings = audit_orders(library(), rows);
  REQUIRE(findings.size() == 1);
  CHECK(findings[0].method == "lib/four@float");
  CHECK(findings[0].verdict == AuditVerdict::as_claimed);
  CHECK(findings[0].problems.at(0).quantity == "velocity");
  CHECK(findings[0].problems.at(2).verdict == AuditVerdict::inconclusive);  // alone, velocity is no finding
  CHECK(findings[0].problems.at(1).verdict == AuditVerdict::unsupported);
  CHECK(findings[0].problems.at(1).reason == "no such force");
}

TEST_CASE("An error that does not depend on its tolerance is a finding; an error far below its tolerance is not") {
  const auto verdict = [&](const std::vector<double>& errors) {
    std::vector<Row> rows;
    double tolerance = 1e-4;
    for (const double error : errors) {
      rows.push_back(
          order_row("lib/none:" + std::to_string(tolerance).substr(0, 10), "a", error, "error-position-max"));
      tolerance /= 10;
    }
    const auto findings = audit_orders(library(), rows);
    REQUIRE(findings.size() == 1);
    CHECK(findings[0].method == "lib/none:tol");
    return findings[0].verdict;
  };
  CHECK(verdict({1e-3, 1e-4, 1e-5}) == AuditVerdict::as_claimed);
  CHECK(verdict({1e-3, 1e-3, 1e-3}) == AuditVerdict::lower);
  CHECK(verdict({1e-3, 1e-2, 1e-3}) == AuditVerdict::lower);
  CHECK(verdict({1e-1, 1e-6, 1e-4}) == AuditVerdict::lower);  // falls on the whole, and follows nothing
  CHECK(verdict({1e-9, 1e-9, 1e-9}) == AuditVerdict::as_claimed);
  CHECK(verdict({1e-3, 1e-4}) == AuditVerdict::inconclusive);
}

TEST_CASE("Our own methods, methods without a claim are not audited") {
  const std::vector<Row> rows = {order_row("atwood/four", "a", 3), order_row("lib/none", "a", 3),
                                 order_row("atwood/four:1e-6", "a", 3, "error-position-max")};
  CHECK(audit_orders(library(), rows).empty());
}

TEST_CASE("The table names every departure, its claim and the command of its evidence") {
  const auto findings =
      audit_orders(library(), {order_row("lib/four", "a", 3.0), order_row("lib/four{x=1}", "a", 4.0)});
  const std::string table = render_audit_table(findings, false, 100);
  CHECK(table.find("lib/four ") != std::string::npos);
  CHECK(table.find("3.00") != std::string::npos);
  CHECK(table.find("lower") != std::string::npos);
  CHECK(table.find("2 methods: 1 lower, 1 as claimed") != std::string::npos);
  CHECK(table.find("describe lib/four --program") != std::string::npos);
  CHECK(table.find("lib/four{x=1}") == std::string::npos);  // as claimed: in the reports, not here
  ReportData data;
  data.audit = findings;
  CHECK(render_markdown(data).find("| `lib/four{x=1}` | 4 |") != std::string::npos);
  CHECK(render_json(data).find("\"verdict\": \"lower\"") != std::string::npos);
  data.audit.clear();
  CHECK(render_markdown(data).find("Library audit") == std::string::npos);
}
