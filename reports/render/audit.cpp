// Claimed beside executed order: from rows and what the engines say of themselves.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>

#include "reports/report.hpp"
#include "text.hpp"
#include "validation/metrics/work_precision.hpp"

namespace atwood {
namespace {

constexpr double kQuarter = 0.25;
constexpr double kFarOff = 100,
                 kStray = 1000;  // error over tolerance: too large; too uneven from one tolerance to another
constexpr double kRoundOff =
    -0.5;  // an order below this is round-off that grows with the number of steps, not a method's

struct OwnClaim {
  double order = 0;
  std::string from;
};

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
  if (!std::isfinite(executed) || executed < kRoundOff) return AuditVerdict::inconclusive;
  if (std::fabs(executed - claimed) <= kQuarter) return AuditVerdict::as_claimed;
  if (std::fabs(executed - std::round(executed)) > kQuarter) return AuditVerdict::inconclusive;
  return executed < claimed ? AuditVerdict::lower : AuditVerdict::higher;
}

// Position's order where there is one, else velocity's.
struct Figures {
  const Row *position = nullptr, *velocity = nullptr, *refusal = nullptr, *trouble = nullptr;
};

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
  const bool departs = made.verdict == AuditVerdict::lower || made.verdict == AuditVerdict::higher;
  if (departs && chosen == figures.velocity)
    made.verdict = AuditVerdict::inconclusive;  // alone, velocity is not a finding
  made.order = chosen->value;
  made.half_width_95 = chosen->truth_bar;
  made.reason = chosen->reason;
  if (made.verdict == AuditVerdict::inconclusive && std::isfinite(made.order))
    made.reason = (made.order < kRoundOff        ? "round-off that grows with the steps; "
                   : made.quantity == "velocity" ? "the position error is inconclusive; by velocity: "
                                                 : "between whole orders; ") +
                  made.reason;
  return made;
}

AuditVerdict overall(const std::vector<AuditProblem>& problems) {
  const auto count = [&](AuditVerdict verdict) {
    return std::count_if(problems.begin(), problems.end(), [&](const AuditProblem& p) { return p.verdict == verdict; });
  };
  if (count(AuditVerdict::lower) > 0) return AuditVerdict::lower;
  // One problem above may be coincidence; two, or the only one that tells, are a finding.
  const auto higher = count(AuditVerdict::higher), as_claimed = count(AuditVerdict::as_claimed);
  if (higher >= 2 || (higher == 1 && as_claimed == 0)) return AuditVerdict::higher;
  if (as_claimed > 0) return AuditVerdict::as_claimed;
  return count(AuditVerdict::inconclusive) > 0 ? AuditVerdict::inconclusive : AuditVerdict::unsupported;
}

// ---- forms that choose their steps ----------------------------------------------------------------------------------
struct Tolerances {
  std::map<double, double> error;
  const Row* refusal = nullptr;
  const Row* trouble = nullptr;
};

// log error on log tolerance, least squares.
double exponent(const std::map<double, double>& error) {
  double n = 0, mx = 0, my = 0, sxx = 0, sxy = 0;
  for (const auto& [tolerance, e] : error) {
    ++n;
    mx += std::log(tolerance);
    my += std::log(e);
  }
  for (const auto& [tolerance, e] : error) {
    const double dx = std::log(tolerance) - mx / n;
    sxx += dx * dx;
    sxy += dx * (std::log(e) - my / n);
  }
  return sxy / sxx;
}

AuditProblem tolerance_problem(const std::string& scenario, const Tolerances& run) {
  AuditProblem made;
  made.scenario = scenario;
  made.quantity = "position";
  made.order = std::nan("");
  if (run.error.size() < 3) {
    made.verdict = run.refusal ? AuditVerdict::unsupported : AuditVerdict::inconclusive;
    const Row* why = run.refusal ? run.refusal : run.trouble;
    made.reason = why ? why->reason : "fewer than three tolerances";
    return made;
  }
  made.order = exponent(run.error);
  // An error that stays far under its tolerance, because samples bound the step, has nothing to follow.
  double least = HUGE_VAL, most = 0;
  for (const auto& [tolerance, error] : run.error) {
    least = std::min(least, error / tolerance);
    most = std::max(most, error / tolerance);
  }
  const bool strays = made.order < 0.5 || most > kStray * least;
  made.verdict = most > kFarOff && strays ? AuditVerdict::lower : AuditVerdict::as_claimed;
  for (const auto& [tolerance, error] : run.error) {
    made.reason += (made.reason.empty() ? "error " : ", ") + figure(error, 3) + " at " + figure(tolerance, 3);
  }
  return made;
}

void append_tolerances(const std::vector<Row>& rows, const std::vector<Engine>& engines,
                       std::vector<AuditFinding>& findings) {
  std::vector<std::string> methods;
  std::map<std::string, std::map<std::string, Tolerances>> found;
  for (const Row& row : rows) {
    const std::size_t colon = row.method.find(':');
    const bool known = std::any_of(engines.begin(), engines.end(), [&](const Engine& e) {
      return e.name != "atwood" && row.method.rfind(e.name + "/", 0) == 0;
    });
    if (colon == std::string::npos || !known || (row.metric != "error-position-max" && row.status == Status::ok) ||
        !row.body.empty())
      continue;
    const std::size_t end = std::min(row.method.find_first_of("+@{", colon), row.method.size());
    const std::string family = row.method.substr(0, colon) + ":tol" + row.method.substr(end);
    if (!found.contains(family)) methods.push_back(family);
    Tolerances& run = found[family][row.scenario];
    if (row.status == Status::unsupported) run.refusal = &row;
    else if (row.status != Status::ok) run.trouble = &row;
    else if (row.value > 0) run.error[std::strtod(row.method.c_str() + colon + 1, nullptr)] = row.value;
  }
  for (const std::string& method : methods) {
    AuditFinding made;
    made.method = method;
    made.claim = "error in proportion to its tolerance";
    made.claimed = 1;
    for (const auto& [scenario, run] : found.at(method)) made.problems.push_back(tolerance_problem(scenario, run));
    made.verdict = overall(made.problems);
    findings.push_back(made);
  }
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
    for (const auto& [scenario, figures] : found.at(method))
      made.problems.push_back(problem(scenario, claim.order, figures));
    made.verdict = overall(made.problems);
    findings.push_back(made);
  }
  append_tolerances(rows, engines, findings);
  return findings;
}

}  // namespace atwood
