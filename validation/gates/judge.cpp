// Judges rows by gates. A value is an interval [v - b, v + b]: if it lies inside the allowed range the gate passes, if
// it lies outside the gate fails, and if it contains a limit the gate is unverifiable.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <limits>
#include <map>
#include <set>
#include <tuple>

#include "validation/gates/gates.hpp"

namespace atwood {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

bool is_order(const std::string& metric) { return metric.starts_with("order-"); }

// Figures with the reason `inconclusive` have no value, so a gate on them is unverifiable. Any other NaN fails.
bool inconclusive(const Row& row) { return std::isnan(row.value) && row.reason.starts_with("inconclusive"); }

// A figure of the whole run; of probes there is a row each, named in `body`.
bool is_of_run(const Row& row) { return !row.t_s && (row.body.empty() || row.metric == "probe-error"); }

// Rows that follow each other and are of the same scenario and method.
using Ladder = std::span<const Row>;
std::vector<Ladder> ladders_in(std::span<const Row> rows) {
  std::vector<Ladder> ladders;
  for (std::size_t begin = 0, end; begin < rows.size(); begin = end) {
    for (end = begin + 1; end < rows.size(); ++end)
      if (rows[end].scenario != rows[begin].scenario || rows[end].method != rows[begin].method) break;
    ladders.push_back(rows.subspan(begin, end - begin));
  }
  return ladders;
}

bool matches_ladder(const Gate& gate, Ladder ladder) {
  return glob_match(gate.scenario, ladder.front().scenario) && glob_match(gate.method, ladder.front().method);
}

// Whether a row of a matching ladder is of a cell that the gate judges.
bool matches_cell(const Gate& gate, const Row& row) {
  return is_of_run(row) && (!gate.steps || row.steps == *gate.steps) &&
         (!gate.spacing_m || row.spacing_m == gate.spacing_m) &&
         (!gate.sound_speed_m_per_s || row.sound_speed_m_per_s == gate.sound_speed_m_per_s);
}

Verdict verdict_of(const Gate& gate, const Row& row) {
  Verdict v;
  v.gate = gate;
  v.scenario = row.scenario;
  v.method = row.method;
  v.metric = row.metric;
  v.unit = row.unit;
  v.steps = row.steps;
  v.spacing_m = row.spacing_m;
  v.sound_speed_m_per_s = row.sound_speed_m_per_s;
  v.value = row.value;
  v.bar = row.truth_bar;
  v.allowed_low = gate.kind == Gate::Kind::within || gate.kind == Gate::Kind::min ? gate.low : -kInfinity;
  v.allowed_high = gate.kind == Gate::Kind::min ? kInfinity : gate.high;
  v.rerun = rerun_words(row.scenario, row.method, row.steps, resolution_of(row));
  if (gate.kind == Gate::Kind::max_ratio)
    v.rerun.insert(v.rerun.begin() + 6, {"--method", gate.ratio_to});  // the rerun measures the other method too
  return v;
}

std::string allowed_text(const Verdict& v) {
  if (v.gate.kind == Gate::Kind::within)
    return "[" + six_digits(v.allowed_low) + ", " + six_digits(v.allowed_high) + "]";
  return v.gate.kind == Gate::Kind::min ? ">= " + six_digits(v.allowed_low) : "<= " + six_digits(v.allowed_high);
}

// Sets the judgement, the margin (distance of the value from the nearest limit, negative outside) and the text.
void conclude(Verdict& v, double low, double high, const std::string& measured, const std::string& note) {
  v.margin = std::min(v.value - v.allowed_low, v.allowed_high - v.value);
  if (low >= v.allowed_low && high <= v.allowed_high) v.judgement = Judgement::pass;
  else if (high < v.allowed_low || low > v.allowed_high) v.judgement = Judgement::fail;
  else v.judgement = Judgement::unverifiable;
  std::string text = "measured " + measured;
  if (v.judgement == Judgement::unverifiable && std::isnan(v.bar))
    text += ", allowed " + allowed_text(v) + ": a single repeat has no interval";
  else if (v.judgement == Judgement::unverifiable && note.empty())
    text += ", allowed " + allowed_text(v) + ": the bar reaches across the edge, margin " + six_digits(v.margin);
  else text += ", allowed " + allowed_text(v) + ", margin " + six_digits(v.margin);
  if (const std::string at = resolution_text({v.spacing_m, v.sound_speed_m_per_s}); !at.empty()) text += ", at " + at;
  v.text = note.empty() ? text : text + " (" + note + ")";
}

std::string measured_text(const Verdict& v) {
  std::string text = six_digits(v.value);
  if (v.bar > 0) text += " +/- " + six_digits(v.bar);
  return v.unit.empty() || v.unit == "1" ? text : text + " " + v.unit;
}

// An order's bar is the 95 % half-width of its fit. It passes when its whole interval lies inside the band, which it
// can only where the half-width is at most half the band; it fails when its whole interval lies outside; otherwise the
// ladder has not shown it.
void judge_order(Verdict& v, const std::string& window) {
  conclude(v, v.value - v.bar, v.value + v.bar, measured_text(v), window);
  if (v.judgement != Judgement::unverifiable) return;
  if (v.bar > (v.allowed_high - v.allowed_low) / 2) v.text += ": the half-width is more than half the band";
  else v.text += ": the interval reaches across the edge";
}

// The figures that ratios are taken to, by what they have in common with the row that is judged.
using RivalKey = std::tuple<std::string, std::string, std::int64_t, Resolution, std::string, std::string>;
using Rivals = std::map<RivalKey, const Row*>;

Rivals rivals_in(std::span<const Gate> gates, std::span<const Row> rows) {
  Rivals rivals;
  std::set<std::string> methods;
  for (const Gate& gate : gates)
    if (gate.kind == Gate::Kind::max_ratio) methods.insert(gate.ratio_to);
  if (methods.empty()) return rivals;
  for (const Row& r : rows)
    if (!r.t_s && r.status == Status::ok && methods.contains(r.method))
      rivals.try_emplace({r.scenario, r.method, r.steps, resolution_of(r), r.metric, r.body}, &r);
  return rivals;
}

void judge_ratio(Verdict& v, const Row& row, const Rivals& rivals) {
  const auto found = rivals.find({row.scenario, v.gate.ratio_to, row.steps, resolution_of(row), row.metric, row.body});
  if (found == rivals.end()) {
    v.judgement = Judgement::not_run;
    v.text = "no row of " + v.gate.ratio_to + " to compare with";
    return;
  }
  const Row* other = found->second;
  const double mine = std::fabs(row.value), theirs = std::fabs(other->value);
  const std::string measured = measured_text(v) + " against " + six_digits(other->value) + " of " + v.gate.ratio_to;
  if (!(theirs > 3 * other->truth_bar)) {  // also NaN and 0: a value below three bars has no ratio
    v.judgement = std::isnan(theirs) ? Judgement::fail : Judgement::unverifiable;
    v.text = "measured " + measured + ": no ratio is made of a value under three bars";
    return;
  }
  // Below three bars the value is only an upper limit: its lower end is zero.
  const double low = mine < 3 * row.truth_bar ? 0 : (mine - row.truth_bar) / (theirs + other->truth_bar);
  const double high = (mine + row.truth_bar) / (theirs - other->truth_bar);
  v.value = mine / theirs;
  v.bar = (high - low) / 2;
  v.unit = "1";
  conclude(v, low, high, "ratio " + six_digits(v.value) + " (" + measured + ")", "");
}

Verdict judge_row(const Gate& gate, const Row& row, const Rivals& rivals) {
  Verdict v = verdict_of(gate, row);
  if (row.status != Status::ok || (std::isnan(row.value) && !inconclusive(row))) {
    v.judgement = Judgement::fail;
    v.margin = -kInfinity;
    v.metric = row.metric == "status" ? gate.metric : row.metric;
    v.value = std::nan("");
    v.text = (row.status != Status::ok ? to_string(row.status) : "not a number") +
             (row.reason.empty() ? "" : ": " + row.reason);
    if (gate.kind != Gate::Kind::max_ratio) v.text += ", allowed " + allowed_text(v);
    return v;
  }
  if (inconclusive(row)) {
    v.judgement = Judgement::unverifiable;
    v.margin = -kInfinity;
    v.text = row.reason + ", allowed " + allowed_text(v);
    return v;
  }
  if (gate.kind == Gate::Kind::max_ratio) judge_ratio(v, row, rivals);
  else if (is_order(row.metric)) judge_order(v, row.reason);
  else conclude(v, v.value - v.bar, v.value + v.bar, measured_text(v), "");
  return v;
}

// Whether a cell that diverged or failed fails this gate: every gate on figures of the cell. A figure of the whole
// ladder is judged by the ladder's row, whose reason names the rungs that failed.
bool failed_cell(const Gate& gate, const Row& row) {
  return row.metric == "status" && row.status != Status::ok && row.status != Status::unsupported &&
         row.status != Status::not_built && !is_order(gate.metric) && gate.metric != "status";
}

// Rows of a cell or a probe that the engine does not support.
bool answers_nothing(const Gate& gate, const Row& row) {
  return (row.metric == "status" || glob_match(gate.metric, row.metric)) &&
         (row.status == Status::unsupported || row.status == Status::not_built);
}

// Whether the metric needs a truth.
bool needs_truth(const std::string& metric) {
  static const char* const kinds[] = {"error-", "order-", "growth-", "impact-", "apex-", "landing-", "tolerance-"};
  return std::any_of(std::begin(kinds), std::end(kinds), [&](const char* kind) { return metric.starts_with(kind); });
}

}  // namespace

// What is known of a gate once some rows were judged.
struct GateProgress {
  bool judged = false, unsupported = false, other = false;
  std::string ended;                                          // how the first cell that did not end ok ended
  std::map<std::string, Row> refused;                         // by scene: a row that says its truth was refused
  std::set<std::string> answered;                             // scenes with a figure
  std::set<std::pair<std::string, std::string>> ended_early;  // cells that did not run have no figures
};

namespace {

void note_truth(const Gate& gate, const Row& row, GateProgress& progress) {
  if (row.metric == "truth" && row.status != Status::ok && !progress.ended_early.contains({row.scenario, row.method}))
    progress.refused.emplace(row.scenario, row);
  if (row.metric != "status" && row.metric != "truth" && glob_match(gate.metric, row.metric))
    progress.answered.insert(row.scenario);
}

// `ladders`: all rows of each scenario and method in them.
void judge_ladders(const Gate& gate, std::span<const Ladder> ladders, const Rivals& rivals, GateProgress& progress,
                   std::vector<Verdict>& verdicts) {
  std::vector<const Row*> matching;
  for (const Ladder& ladder : ladders)
    if (matches_ladder(gate, ladder))
      for (const Row& row : ladder)
        if (matches_cell(gate, row)) matching.push_back(&row);
  const bool truths = needs_truth(gate.metric);
  if (truths) {
    for (const Row* row : matching)
      if (row->metric == "status" && row->status != Status::ok)
        progress.ended_early.insert({row->scenario, row->method});
  }
  for (const Row* each : matching) {
    const Row& row = *each;
    if (truths) note_truth(gate, row, progress);
    if (answers_nothing(gate, row)) {
      progress.unsupported = true;
      continue;
    }
    progress.other = true;
    if (row.metric == "status" && row.status != Status::ok && progress.ended.empty())
      progress.ended = ": " + to_string(row.status) + (row.reason.empty() ? "" : ", " + row.reason);
    if (failed_cell(gate, row) || (row.metric != "status" && glob_match(gate.metric, row.metric))) {
      verdicts.push_back(judge_row(gate, row, rivals));
      progress.judged = true;
    }
  }
}

// Once all rows were judged. Where the truth of a scene is unsupported, its cells run but have no errors: the gate is
// `not_run` there, also if it judged other scenes. One verdict per scene. A gate without any row is `not_run`, unless
// it is partial and all its cells ended ok.
void conclude_gate(const Gate& gate, const GateProgress& progress, std::vector<Verdict>& verdicts) {
  bool judged = progress.judged;
  for (const auto& [scenario, row] : progress.refused) {
    if (progress.answered.contains(scenario)) continue;
    Verdict v = verdict_of(gate, row);
    v.metric = gate.metric;
    v.judgement = Judgement::not_run;
    v.value = std::nan("");
    v.margin = -kInfinity;
    v.text = "no figure: the truth of this scene ended as " + to_string(row.status) +
             (row.reason.empty() ? "" : ": " + row.reason);
    verdicts.push_back(v);
    judged = true;
  }
  if (judged) return;
  if (progress.unsupported && !progress.other) return;  // an unsupported cell, or an engine that is not built
  if (gate.partial && progress.ended.empty()) return;   // a narrowed run, whose cells do not have this metric
  Verdict v;
  v.gate = gate;
  v.scenario = gate.scenario;
  v.method = gate.method;
  v.metric = gate.metric;
  v.steps = gate.steps.value_or(0);
  v.judgement = Judgement::not_run;
  v.value = std::nan("");
  v.margin = -kInfinity;
  v.text = "no rows match" + progress.ended;
  v.rerun = rerun_words(gate.scenario, gate.method, v.steps);
  verdicts.push_back(v);
}

}  // namespace

std::vector<Gate> gates_of_claims(std::span<const Gate> gates, std::span<const Claim> claims) {
  std::vector<Gate> resolved;
  for (const Gate& gate : gates) {
    if (gate.kind != Gate::Kind::within_claim) {
      resolved.push_back(gate);
      continue;
    }
    for (const Claim& claim : claims) {
      if (claim.motion != gate.claim || !glob_match(gate.scenario, claim.scenario) ||
          !glob_match(gate.method, claim.method))
        continue;
      Gate one = gate;
      const double give = std::max(0.1, 0.02 * claim.order);
      one.scenario = claim.scenario;
      one.method = claim.method;
      one.kind = Gate::Kind::within;
      one.low = claim.order - give;
      one.high = claim.order + give;
      resolved.push_back(one);
    }
  }
  return resolved;
}

std::vector<Verdict> judge(std::span<const Gate> gates, std::span<const Row> rows) {
  std::vector<Verdict> verdicts;
  const Rivals rivals = rivals_in(gates, rows);
  const std::vector<Ladder> ladders = ladders_in(rows);
  for (const Gate& gate : gates) {
    GateProgress progress;
    judge_ladders(gate, ladders, rivals, progress, verdicts);
    conclude_gate(gate, progress, verdicts);
  }
  return verdicts;
}

struct LadderJudge::State {
  std::vector<Gate> gates;
  std::vector<Row> rival_rows;
  Rivals rivals;
  std::vector<GateProgress> progress;
  std::map<std::string, std::vector<std::size_t>> of_scene;  // the gates whose scenario matches
};

LadderJudge::LadderJudge(std::vector<Gate> gates, std::vector<Row> rivals) : state_(new State) {
  state_->progress.resize(gates.size());
  state_->gates = std::move(gates);
  state_->rival_rows = std::move(rivals);
  state_->rivals = rivals_in(state_->gates, state_->rival_rows);
}
LadderJudge::~LadderJudge() = default;

std::vector<Verdict> LadderJudge::add(std::span<const Row> rows) {
  std::vector<Verdict> verdicts;
  if (rows.empty()) return verdicts;
  const std::vector<Ladder> ladders = ladders_in(rows);
  const auto [place, fresh] = state_->of_scene.try_emplace(rows.front().scenario);
  for (std::size_t i = 0; fresh && i < state_->gates.size(); ++i)
    if (glob_match(state_->gates[i].scenario, place->first)) place->second.push_back(i);
  for (const std::size_t i : place->second)
    judge_ladders(state_->gates[i], ladders, state_->rivals, state_->progress[i], verdicts);
  return verdicts;
}

std::vector<Verdict> LadderJudge::rest() const {
  std::vector<Verdict> verdicts;
  for (std::size_t i = 0; i < state_->gates.size(); ++i) conclude_gate(state_->gates[i], state_->progress[i], verdicts);
  return verdicts;
}

std::string to_string(Judgement judgement) {
  switch (judgement) {
    case Judgement::pass: return "pass";
    case Judgement::fail: return "fail";
    case Judgement::unverifiable: return "unverifiable";
    case Judgement::not_run: return "not_run";
  }
  return "";
}

// The usual two-pointer match: on a mismatch, go back to the last star and let it match one character more.
bool glob_match(const std::string& pattern, const std::string& text) {
  std::size_t p = 0, t = 0, star = std::string::npos, taken = 0;
  while (t < text.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      taken = t;
    } else if (p < pattern.size() && (pattern[p] == '?' || pattern[p] == text[t])) {
      ++p;
      ++t;
    } else if (star != std::string::npos) {
      p = star + 1;
      t = ++taken;
    } else {
      return false;
    }
  }
  while (p < pattern.size() && pattern[p] == '*') ++p;
  return p == pattern.size();
}

std::string six_digits(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

bool has_glob(const std::string& text) { return text.find_first_of("*?") != std::string::npos; }

}  // namespace atwood
