// Verdicts by the interval rule, orders, ratios, and what can't be judged.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <limits>

#include "validation/gates/gates.hpp"

using namespace atwood;

namespace {

Row row_of(const std::string& metric, double value, double bar = 0, const std::string& method = "atwood/rk4",
           std::int64_t steps = 960) {
  Row r;
  r.scenario = "kepler-e0.6";
  r.method = method;
  r.steps = steps;
  r.metric = metric;
  r.unit = "m";
  r.value = value;
  r.truth_bar = bar;
  return r;
}

Gate gate_of(Gate::Kind kind, double low, double high, const std::string& metric = "error-position-end") {
  Gate g;
  g.scenario = "kepler-*";
  g.method = "atwood/rk4";
  g.metric = metric;
  g.kind = kind;
  g.low = low;
  g.high = high;
  g.reason = "a test";
  return g;
}

Verdict only(const Gate& gate, const std::vector<Row>& rows) {
  const std::vector<Verdict> verdicts = judge(std::vector<Gate>{gate}, rows);
  REQUIRE(verdicts.size() == 1);
  return verdicts[0];
}
Judgement judged(const Gate& gate, const std::vector<Row>& rows) { return only(gate, rows).judgement; }

}  // namespace

TEST_CASE("judge: the interval inside passes, wholly outside fails, across the edge is unverifiable") {
  using Kind = Gate::Kind;
  const Gate within = gate_of(Kind::within, 1, 2), max = gate_of(Kind::max, 0, 2), min = gate_of(Kind::min, 1, 0);
  const auto row = [](double v, double b) { return std::vector<Row>{row_of("error-position-end", v, b)}; };
  CHECK(judged(within, row(1.5, 0.5)) == Judgement::pass);
  CHECK(judged(within, row(1.5, 0.6)) == Judgement::unverifiable);
  CHECK(judged(within, row(0.5, 0.4)) == Judgement::fail);
  CHECK(judged(within, row(2.5, 0.4)) == Judgement::fail);
  CHECK(judged(within, row(2.5, 0.6)) == Judgement::unverifiable);
  CHECK(judged(max, row(2, 0)) == Judgement::pass);
  CHECK(judged(max, row(1.9, 0.2)) == Judgement::unverifiable);
  CHECK(judged(max, row(2.1, 0.05)) == Judgement::fail);
  CHECK(judged(max, row(1e-9, 10)) == Judgement::unverifiable);  // a gate tighter than its bar
  CHECK(judged(min, row(1, 0)) == Judgement::pass);
  CHECK(judged(min, row(0.9, 0)) == Judgement::fail);
  CHECK(judged(min, row(1.1, 0.2)) == Judgement::unverifiable);
}

TEST_CASE("judge: a time of a single repeat has no interval, so a gate on it is unverifiable and says why") {
  const Verdict v = only(gate_of(Gate::Kind::max, 0, 2e-6, "step-time"), {row_of("step-time", 1e-6, std::nan(""))});
  CHECK(v.judgement == Judgement::unverifiable);
  CHECK(v.text == "measured 1e-06 m, allowed <= 2e-06: a single repeat has no interval");
}

TEST_CASE("judge: a failure says what was measured, allowed, by what margin, and how to run it again") {
  const Verdict v = only(gate_of(Gate::Kind::max, 0, 2e-6), {row_of("error-position-end", 3e-6)});
  CHECK(v.judgement == Judgement::fail);
  CHECK(v.text == "measured 3e-06 m, allowed <= 2e-06, margin -1e-06");
  CHECK(v.margin == Approx(-1e-6));
  CHECK(shell_line(v.rerun) == "atwood run --scenario kepler-e0.6 --method atwood/rk4 --steps 960");
  Row odd = row_of("error-position-end", 1, 0, "ode/default{erp=0.1}");
  Gate any = gate_of(Gate::Kind::max, 0, 2);
  any.method = "ode/*";
  CHECK(shell_line(only(any, {odd}).rerun) ==
        "atwood run --scenario kepler-e0.6 --method 'ode/default{erp=0.1}' --steps 960");
}

TEST_CASE("judge: orders on both sides, with a half-width of at most half the band") {
  const Gate gate = gate_of(Gate::Kind::within, 3.9, 4.2, "order-position");
  const auto order = [](double v, double half) {
    return std::vector<Row>{row_of("order-position", v, half, "atwood/rk4", 0)};
  };
  CHECK(judged(gate, order(4.05, 0.03)) == Judgement::pass);
  CHECK(judged(gate, order(4.05, 0.14)) == Judgement::pass);
  // The order inside, its interval across the edge: not shown.
  CHECK(judged(gate, order(4.19, 0.1)) == Judgement::unverifiable);
  CHECK(judged(gate, order(3.905, 0.01)) == Judgement::unverifiable);
  CHECK(only(gate, order(4.19, 0.1)).text.ends_with("the interval reaches across the edge"));
  CHECK(judged(gate, order(4.05, 0.16)) == Judgement::unverifiable);
  CHECK(judged(gate, order(3.0, 0.05)) == Judgement::fail);
  CHECK(judged(gate, order(6.0, 0.05)) == Judgement::fail);
  CHECK(judged(gate, order(4.25, 0.1)) == Judgement::unverifiable);
  CHECK(shell_line(only(gate, order(3.0, 0.05)).rerun) == "atwood run --scenario kepler-e0.6 --method atwood/rk4");
  std::vector<Row> nothing = order(std::nan(""), 0);
  nothing[0].reason = "inconclusive: 2 of 5 rungs lie above 30 x the floor";
  CHECK(judged(gate, nothing) == Judgement::unverifiable);
}

TEST_CASE("judge: NaN fails, failed cells fail, and a gate without rows is not_run") {
  const Gate gate = gate_of(Gate::Kind::max, 0, 2);
  CHECK(judged(gate, {row_of("error-position-end", std::nan(""))}) == Judgement::fail);
  CHECK(judged(gate, {row_of("error-position-end", std::numeric_limits<double>::infinity())}) == Judgement::fail);
  for (const Status status : {Status::diverged, Status::not_finite, Status::timeout, Status::crashed}) {
    Row row = row_of("status", 0);
    row.status = status;
    row.reason = "late in the run";
    const Verdict v = only(gate, {row});
    CHECK(v.judgement == Judgement::fail);
    CHECK(v.metric == "error-position-end");
    CHECK(v.text.find("late in the run") != std::string::npos);
  }
  CHECK(judged(gate, {}) == Judgement::not_run);
  CHECK(judged(gate, {row_of("error-velocity-end", 1)}) == Judgement::not_run);
  Gate other_steps = gate;
  other_steps.steps = 1920;
  CHECK(judged(other_steps, {row_of("error-position-end", 1)}) == Judgement::not_run);
  // A ladder whose cells all blew up has no order: not a pass.
  Row blown = row_of("status", 0);
  blown.status = Status::diverged;
  CHECK(judged(gate_of(Gate::Kind::within, 3.9, 4.2, "order-position"), {blown}) == Judgement::not_run);
}

TEST_CASE("judge: a gate whose globs reach beyond a narrowed run says nothing where the run has no such figure") {
  Gate partial = gate_of(Gate::Kind::max, 0, 2);
  partial.partial = true;
  const auto verdicts = [&](std::vector<Row> rows) { return judge(std::vector<Gate>{partial}, rows); };
  CHECK(verdicts({row_of("error-velocity-end", 1)}).empty());
  CHECK(judged(partial, {row_of("error-position-end", 1)}) == Judgement::pass);
  CHECK(judged(partial, {row_of("error-position-end", 3)}) == Judgement::fail);
  Row blown = row_of("status", 0);
  blown.status = Status::diverged;
  CHECK(judged(partial, {blown}) == Judgement::fail);
  partial.kind = Gate::Kind::within;
  partial.metric = "order-position";
  CHECK(judged(partial, {blown}) == Judgement::not_run);
}

TEST_CASE("judge: unsupported and not built cells give no verdict, unless another cell was run") {
  Row refused = row_of("status", 0);
  refused.status = Status::unsupported;
  const Gate gate = gate_of(Gate::Kind::max, 0, 2);
  CHECK(judge(std::vector<Gate>{gate}, std::vector<Row>{refused}).empty());
  refused.status = Status::not_built;
  CHECK(judge(std::vector<Gate>{gate}, std::vector<Row>{refused}).empty());
  CHECK(judged(gate, {refused, row_of("error-position-end", 3)}) == Judgement::fail);
  CHECK(judged(gate, {refused, row_of("error-velocity-end", 3)}) == Judgement::not_run);
}

TEST_CASE("judge: one verdict a matching row; rows of single bodies and instants are not judged") {
  Gate gate = gate_of(Gate::Kind::max, 0, 2);
  gate.method = "*";
  std::vector<Row> rows = {row_of("error-position-end", 1), row_of("error-position-end", 3, 0, "ode/default")};
  Row body = row_of("error-position-end", 9);
  body.body = "moon";
  Row instant = row_of("error-position-end", 9);
  instant.t_s = 0.5;
  rows.push_back(body);
  rows.push_back(instant);
  const std::vector<Verdict> verdicts = judge(std::vector<Gate>{gate}, rows);
  REQUIRE(verdicts.size() == 2);
  CHECK(verdicts[0].judgement == Judgement::pass);
  CHECK(verdicts[1].judgement == Judgement::fail);
}

TEST_CASE("judge: ratios to another method's row of the same cell; none for values below three bars") {
  Gate gate = gate_of(Gate::Kind::max_ratio, 0, 0.1);
  gate.ratio_to = "ode/default";
  const auto rows = [](double mine, double bar, double theirs, double their_bar) {
    return std::vector<Row>{row_of("error-position-end", mine, bar),
                            row_of("error-position-end", theirs, their_bar, "ode/default")};
  };
  CHECK(judged(gate, rows(1, 0, 20, 0)) == Judgement::pass);
  CHECK(judged(gate, rows(3, 0, 20, 0)) == Judgement::fail);
  CHECK(judged(gate, rows(1.9, 0.2, 20, 0)) == Judgement::unverifiable);
  CHECK(judged(gate, rows(1, 0, 20, 10)) == Judgement::unverifiable);
  CHECK(judged(gate, rows(1, 0, 0, 0)) == Judgement::unverifiable);
  CHECK(judged(gate, rows(1, 0.5, 20, 0)) == Judgement::pass);          // 1.5 / 20 at most
  CHECK(judged(gate, rows(2.5, 1, 20, 0)) == Judgement::unverifiable);  // at most 3.5 / 20, at least nothing
  CHECK(judged(gate, {row_of("error-position-end", 1)}) == Judgement::not_run);
  std::vector<Row> coarser = rows(1, 0, 20, 0);
  coarser[1].steps = 480;
  CHECK(judged(gate, coarser) == Judgement::not_run);
}

TEST_CASE("a gate on claims becomes one gate a claimed ladder: the claimed order, give or take max(0.1, 2 %)") {
  Gate claimed = gate_of(Gate::Kind::within_claim, 0, 0, "order-position");
  claimed.scenario = "*";
  claimed.method = "atwood/*";
  claimed.claim = "point-mass";
  const Gate other = gate_of(Gate::Kind::max, 0, 1);
  const std::vector<Claim> claims = {{"kepler-e0.6", "atwood/rk4", "point-mass", 4},
                                     {"kepler-e0.6", "atwood/radau15@quad", "point-mass", 15},
                                     {"free-box", "atwood/rk4", "rotation", 4},
                                     {"kepler-e0.6", "cvode/adams", "point-mass", 5}};
  const std::vector<Gate> gates = gates_of_claims(std::vector<Gate>{claimed, other}, claims);
  REQUIRE(gates.size() == 3);
  CHECK(gates[0].method == "atwood/rk4");
  CHECK(gates[0].kind == Gate::Kind::within);
  CHECK(gates[0].low == Approx(3.9));
  CHECK(gates[0].high == Approx(4.1));
  CHECK(gates[1].method == "atwood/radau15@quad");
  CHECK(gates[1].low == Approx(14.7));
  CHECK(gates[1].high == Approx(15.3));
  CHECK(gates[2].kind == Gate::Kind::max);
  CHECK(judged(gates[0], {row_of("order-position", 4.2, 0.02)}) == Judgement::fail);
  CHECK(gates_of_claims(std::vector<Gate>{claimed}, {}).empty());
}

TEST_CASE("judge: a truth that refuses leaves the gates that need it not run, scene by scene") {
  Gate gate = gate_of(Gate::Kind::max, 0, 2);
  gate.scenario = "*";
  Row refused = row_of("truth", 0);
  refused.scenario = "pile";
  refused.status = Status::unsupported;
  refused.reason = "bodies may meet";
  Row energy = row_of("energy-max", 1e-3);
  energy.scenario = "pile";
  const std::vector<Row> rows = {row_of("error-position-end", 1), energy, refused};
  const std::vector<Verdict> verdicts = judge(std::vector<Gate>{gate}, rows);
  REQUIRE(verdicts.size() == 2);  // another scene's pass hides nothing
  CHECK(verdicts[0].judgement == Judgement::pass);
  CHECK(verdicts[1].judgement == Judgement::not_run);
  CHECK(verdicts[1].scenario == "pile");
  CHECK(verdicts[1].text.find("bodies may meet") != std::string::npos);
  gate.metric = "energy-max";  // needs no truth
  CHECK(judge(std::vector<Gate>{gate}, rows).size() == 1);
  gate.metric = "error-position-end";
  Row cannot = row_of("status", 0);  // nor does an engine that cannot do the scene
  cannot.scenario = "pile";
  cannot.status = Status::unsupported;
  CHECK(judge(std::vector<Gate>{gate}, std::vector<Row>{rows[0], refused, cannot}).size() == 1);
}

TEST_CASE("rerun: words of any bytes come out of a shell as they went in") {
  const std::vector<std::string> plain{"/usr/bin/atwood", "run", "--scenario", "kepler-e0.6", "a=b"};
  CHECK(shell_line(plain) == "/usr/bin/atwood run --scenario kepler-e0.6 a=b");
  CHECK(shell_line(std::vector<std::string>{"a=b", ""}) == "'a=b' ''");
  CHECK(shell_line(std::vector<std::string>{"x", "it's"}) == "x 'it'\\''s'");
  const std::vector<std::string> words{"printf",
                                       "%s|",
                                       "it's",
                                       "$(touch x)",
                                       "`id`",
                                       "a b\tc",
                                       "two\nlines",
                                       "ends\n\n",
                                       "\x1b[31mred",
                                       "\\0 %d",
                                       "caf\xc3\xa9",
                                       "\xc2\x9b"
                                       "31m",
                                       "broken\xff",
                                       "-",
                                       "*",
                                       "~",
                                       "!x",
                                       "\n",
                                       "\xe2\x80\xae"
                                       "live"};
  const std::string line = shell_line(words);
  for (const char c : line.substr(0, line.find("ends")))
    CHECK(static_cast<unsigned char>(c) >= 0x20);  // no byte that a terminal acts upon
  CHECK(line.find('\x1b') == std::string::npos);
  CHECK(line.find("\xc2\x9b") == std::string::npos);
  CHECK(line.find("caf\xc3\xa9") != std::string::npos);
  std::string expected, found;
  for (std::size_t i = 2; i < words.size(); ++i) expected += words[i] + "|";
  FILE* pipe = popen(line.c_str(), "r");  // /bin/sh
  REQUIRE(pipe != nullptr);
  for (int c; (c = std::fgetc(pipe)) != EOF;) found += static_cast<char>(c);
  CHECK(pclose(pipe) == 0);
  CHECK(found == expected);
}

TEST_CASE("a glob matches with * and ? and literal text") {
  CHECK(glob_match("kepler-*", "kepler-e0.6"));
  CHECK(glob_match("*", ""));
  CHECK(glob_match("a*b*c", "axxbyybzc"));
  CHECK_FALSE(glob_match("a*b*c", "axxbyybz"));
  CHECK(glob_match("kepler-e0.?", "kepler-e0.6"));
  CHECK_FALSE(glob_match("kepler-e0.?", "kepler-e0.66"));
  CHECK_FALSE(glob_match("atwood/rk4", "atwood/rk4+event"));
  CHECK_FALSE(glob_match("", "x"));
  CHECK(glob_match("ode/default{erp=0.[12]}", "ode/default{erp=0.[12]}"));
}

TEST_CASE("judge: ladder by ladder gives the verdicts of all rows together") {
  using Kind = Gate::Kind;
  Gate ratio = gate_of(Kind::max_ratio, 0, 2);
  ratio.method = "atwood/*";
  ratio.ratio_to = "ode/step";
  Gate nothing = gate_of(Kind::max, 0, 1, "energy-max");
  Gate truth = gate_of(Kind::max, 0, 1, "order-position");
  Gate fails = gate_of(Kind::max, 0, 1);
  fails.method = "*";
  const std::vector<Gate> gates{ratio, nothing, truth, fails};
  Row refused = row_of("truth", 0, 0, "atwood/heun");
  refused.status = Status::unsupported;
  refused.reason = "no truth";
  Row ended = row_of("status", 0, 0, "atwood/diverges");
  ended.status = Status::diverged;
  const std::vector<std::vector<Row>> ladders{
      {row_of("error-position-end", 0.5), row_of("error-position-end", 3, 0, "atwood/rk4", 480)},
      {row_of("error-position-end", 1, 0, "atwood/heun"), refused},
      {ended},
      {row_of("error-position-end", 0.4, 0, "ode/step"), row_of("error-position-end", 1, 0, "ode/step", 480)}};
  std::vector<Row> all;
  for (const auto& ladder : ladders) all.insert(all.end(), ladder.begin(), ladder.end());
  const auto texts = [](const std::vector<Verdict>& verdicts) {
    std::vector<std::string> lines;
    for (const Verdict& v : verdicts)
      lines.push_back(v.gate.metric + " " + v.scenario + " " + v.method + " " + std::to_string(v.steps) + " " +
                      to_string(v.judgement) + " " + v.text);
    std::sort(lines.begin(), lines.end());
    return lines;
  };
  LadderJudge judge_ladders(gates, ladders.back());
  std::vector<Verdict> found;
  for (const auto& ladder : ladders)
    for (const Verdict& v : judge_ladders.add(ladder)) found.push_back(v);
  for (const Verdict& v : judge_ladders.rest()) found.push_back(v);
  const std::vector<std::string> expected = texts(judge(gates, all));
  CHECK(expected.size() > 8);
  CHECK(texts(found) == expected);
}
