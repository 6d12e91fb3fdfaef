// Claimed beside executed order: from rows and what the engines say of themselves.
#include <algorithm>
#include <cmath>
#include <map>

#include "reports/report.hpp"

namespace atwood {
namespace {

constexpr double kQuarter = 0.25;

struct OwnClaim { double order = 0; std::string from; };

// "odeint/rk4@long-double{in_place=true}" -> "odeint/rk4"
std::string base_of(const std::string& method) { return method.substr(0, method.find_first_of(":+@{")); }

std::map<std::string, OwnClaim> claims_of(const std::vector<Engine>& engines) {
  std::map<std::string, OwnClaim> claims;
  for (const Engine& engine : engines) {
    if (engine.name == "atwood") continue;
    for (const MethodInfo& info : engine.methods) {
      double order = 0;  // one claim a method: a library's does not depend on the motion
      for (const auto& [motion, claimed] : info.claimed_order) order = std::max(order, claimed);
      if (order <= 0) continue;
      const auto from = info.settings.find("claim");
      const auto* words = from == info.settings.end() ? nullptr : std::get_if<std::string>(&from->second);
      claims[info.id] = {order, words ? *words : "the q of its table"};
    }
  }
  return claims;
}

AuditVerdict judge(double claimed, double executed) {
  if (!std::isfinite(executed)) return AuditVerdict::inconclusive;
  if (std::fabs(executed - claimed) <= kQuarter) return AuditVerdict::as_claimed;
  if (std::fabs(executed - std::round(executed)) > kQuarter) return AuditVerdict::inconclusive;
  return executed < claimed ? AuditVerdict::lower : AuditVerdict::higher;
}

// Position's order where there is one, else velocity's.
struct Figures { const Row *position = nullptr, *velocity = nullptr, *refusal = nullptr, *trouble = nullptr; };

AuditProblem problem(const std::string& scenario, double claimed, const Figures& figures) {
  AuditProblem made;
  made.scenario = scenario;
  made.order = std::nan("");
  const Row* chosen = figures.position;
  made.quantity = "position";
  if ((!chosen || !std::isfinite(chosen->value)) && figures.velocity && std::isfinite(figures.velocity->value)) {
    chosen = figures.velocity;
    made.quantity = "velocity";
  }
  if (!chosen) {
    const Row* why = figures.refusal ? figures.refusal : figures.trouble;
    made.verdict = figures.refusal ? AuditVerdict::unsupported : AuditVerdict::inconclusive;
    made.reason = why ? why->reason : "no rung of the ladder ended well";
    return made;
  }
  made.verdict = judge(claimed, chosen->value);
  made.order = chosen->value;
  made.half_width_95 = chosen->truth_bar;
  made.reason = chosen->reason;
  if (made.verdict == AuditVerdict::inconclusive && std::isfinite(made.order)) made.reason = "between whole orders; " + made.reason;
  return made;
}

AuditVerdict overall(const std::vector<AuditProblem>& problems) {
  for (const AuditVerdict worst : {AuditVerdict::lower, AuditVerdict::higher, AuditVerdict::as_claimed, AuditVerdict::inconclusive}) {
    if (std::any_of(problems.begin(), problems.end(), [&](const AuditProblem& p) { return p.verdict == worst; })) return worst;
  }
  return AuditVerdict::unsupported;
}

}  // namespace

std::string to_string(AuditVerdict verdict) {
  switch (verdict) {
    case AuditVerdict::as_claimed: return "as claimed";
    case AuditVerdict::lower: return "lower";
    case AuditVerdict::higher: return "higher";
    case AuditVerdict::inconclusive: return "inconclusive";
    case AuditVerdict::unsupported: return "unsupported";
  }
  return "";
}

std::vector<AuditFinding> audit_orders(const std::vector<Engine>& engines, const std::vector<Row>& rows) {
  const std::map<std::string, OwnClaim> claims = claims_of(engines);
  std::vector<std::string> methods;
  std::map<std::string, std::map<std::string, Figures>> found;  // method -> scenario
  for (const Row& row : rows) {
    if (row.method.find(':') != std::string::npos || !claims.contains(base_of(row.method))) continue;
    if (!found.contains(row.method)) methods.push_back(row.method);
    Figures& figures = found[row.method][row.scenario];
    if (row.metric == "order-position") figures.position = &row;
    if (row.metric == "order-velocity") figures.velocity = &row;
    if (row.status == Status::unsupported) figures.refusal = &row;
    else if (row.status != Status::ok && !figures.trouble) figures.trouble = &row;
  }
  std::vector<AuditFinding> findings;
  for (const std::string& method : methods) {
    const OwnClaim& claim = claims.at(base_of(method));
    AuditFinding made;
    made.method = method;
    made.claim = claim.from;
    made.claimed = claim.order;
    for (const auto& [scenario, figures] : found.at(method)) made.problems.push_back(problem(scenario, claim.order, figures));
    made.verdict = overall(made.problems);
    findings.push_back(made);
  }
  return findings;
}

}  // namespace atwood
