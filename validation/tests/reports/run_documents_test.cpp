// Documents of one small run: the text at the end of a run, JUnit XML, annotations of GitHub, changes of a baseline.
#include <catch2/catch.hpp>
#include <pugixml.hpp>

#include "reports/render/figures_table.hpp"
#include "reports/render/text.hpp"
#include "synthetic.hpp"

using namespace atwood;

namespace {

Row figure_row(const std::string& method, std::int64_t steps, const std::string& metric, double value, double bar = 0,
               const std::string& unit = "m") {
  Row row;
  row.scenario = "orbit";
  row.method = method;
  row.steps = steps;
  row.metric = metric;
  row.unit = unit;
  row.value = value;
  row.truth_bar = bar;
  return row;
}

// Two methods on one scene: ours as it claims, the user's below its claim, and blown up on its coarsest rung.
ReportData small_run() {
  ReportData data;
  data.title = "mine";
  for (const std::int64_t steps : {64, 128}) {
    data.rows.push_back(figure_row("atwood/rk4", steps, "error-position-max", steps == 64 ? 1.6e-5 : 1e-6));
    data.rows.push_back(figure_row("atwood/rk4", steps, "energy-max", 2e-7, 0, "1"));
    data.rows.push_back(figure_row("atwood/rk4", steps, "step-time", 257e-9, 0, "s"));
  }
  data.rows.push_back(figure_row("atwood/rk4", 0, "order-position", 4, 0.02, "1"));
  data.rows.push_back(figure_row("odd/one", 128, "error-position-max", 0.5));
  data.rows.push_back(figure_row("odd/one", 64, "status", 0));
  data.rows.back().status = Status::diverged;
  data.rows.push_back(figure_row("odd/one", 0, "order-position", 0.98, 0.02, "1"));
  data.claimed_orders = {{"orbit", "atwood/rk4", "order-position", 4, 4, 0.02, false},
                         {"orbit", "odd/one", "order-position", 2, 0.98, 0.02, true}};
  Verdict pass;
  pass.scenario = "orbit";
  pass.method = "atwood/rk4";
  pass.metric = "error-position-max";
  pass.judgement = Judgement::pass;
  Verdict blown = pass;
  blown.method = "odd/one";
  blown.metric = "status";
  blown.steps = 64;
  blown.judgement = Judgement::fail;
  blown.of_cell = true;
  blown.text = "diverged: too far";
  blown.rerun = rerun_words("orbit", "odd/one", 64);
  data.verdicts = {pass, blown};
  data.cells = {{"orbit", "atwood/rk4", 64},
                {"orbit", "atwood/rk4", 128},
                {"orbit", "odd/one", 64, Status::diverged, "too far"},
                {"orbit", "odd/one", 128},
                {"orbit", "dart/default", 64, Status::unsupported, "no orbits"}};
  data.cells[2].fails = true;
  return data;
}

}  // namespace

TEST_CASE("a small run ends with its figures, its claims and a sentence on what failed") {
  ReportData data = small_run();
  data.refused_truths = {
      {"pile", "`extended`", Status::unsupported, "bodies may meet", "What covers it: `kind = \"cvode\"`."}};
  data.notes = {"12 gates left out by the filter."};
  const std::string text = render_run_table(data, false, 120);
  for (const char* words :
       {"orbit  (error: position, largest over the run, at the finest rung)", "1e-06 m", "4.00 +/- 0.02 (claims 4)",
        "0.98 +/- 0.02 (claims 2)", "2e-07", "257 ns", "  pass\n", "1 of 2 diverged", "diverged: too far",
        "atwood run --scenario orbit --method odd/one --steps 64", "claims 2, observed 0.98 +/- 0.02: below its claim.",
        "bodies may meet", "`kind = \"cvode\"`", "12 gates left out by the filter.", "FAIL  2 gates: 1 pass, 1 fail"}) {
    INFO(words << "\n" << text);
    CHECK(text.find(words) != std::string::npos);
  }
  CHECK(text.find("rk4  order-position: claims") == std::string::npos);  // as claimed: nothing to say
  for (int i = 0; i < 40; ++i) data.rows.push_back(figure_row("odd/" + std::to_string(i), 64, "error-position-max", 1));
  const std::string large = render_run_table(data, false, 120);
  CHECK(large.find("largest over the run") == std::string::npos);
  CHECK(large.find("scenario  ") != std::string::npos);
  const std::string quiet = render_quiet(data, "report: x");
  CHECK(quiet.find("diverged: too far") != std::string::npos);
  CHECK(quiet.ends_with("FAIL  2 gates: 1 pass, 1 fail, 0 unverifiable, 0 not run; report: x\n"));
}

TEST_CASE("what is said of a missing truth is what was measured without it") {
  RefusedTruth refused{"vortices", "`semi-discrete`", Status::unsupported, "no response", "", "known/one", true};
  const std::string some = refused_words(refused);
  CHECK(some.find("(`semi-discrete`) for known/one ended as unsupported: no response.") != std::string::npos);
  CHECK(some.find("the errors against the exact field are measured") != std::string::npos);
  CHECK(some.find("are not measured") == std::string::npos);
  refused.method.clear(), refused.has_errors = false;
  const std::string none = refused_words(refused);
  CHECK(none.find("(`semi-discrete`) ended as unsupported") != std::string::npos);
  CHECK(none.find("Errors, orders and what else needs a truth are not measured.") != std::string::npos);
}

TEST_CASE("JUnit holds a case a cell: what failed fails once, what an engine cannot do is skipped") {
  const ReportData data = small_run();
  pugi::xml_document document;
  REQUIRE(document.load_string(render_junit(data.verdicts, data.cells).c_str()));
  const pugi::xml_node root = document.child("testsuites");
  CHECK(root.attribute("tests").as_int() == 6);
  CHECK(root.attribute("failures").as_int() == 1);
  CHECK(root.attribute("skipped").as_int() == 1);
  CHECK(root.select_nodes("//testcase").size() == 6);
  REQUIRE(root.select_nodes("//failure").size() == 1);
  const pugi::xml_node failure = root.select_nodes("//failure")[0].node();
  CHECK(std::string(failure.parent().attribute("name").value()) == "odd/one runs at 64 steps");
  CHECK(std::string(failure.text().get()).find("rerun: atwood run") != std::string::npos);
}

TEST_CASE("annotations keep GitHub's rules: at most ten, escaped, a file of the workspace") {
  ReportData data = small_run();
  data.verdicts[1].text = "100 % lost\r\nat: a, b";
  data.verdicts[1].gate.named = true;
  data.verdicts[1].gate.origin = "/home/me/repo/tol, 1.toml:7";
  const std::string text = render_github_annotations(data, "/home/me/repo");
  CHECK(text.find(
            "::error file=tol%2C 1.toml,line=7,title=atwood fail%3A orbit odd/one status at 64 steps::100 %25 lost") ==
        0);
  CHECK(text.find("%0Aat: a, b%0Arerun: atwood run") != std::string::npos);
  CHECK(text.find("::warning title=atwood%3A orbit odd/one order-position::claims 2") != std::string::npos);
  CHECK(text.find('\r') == std::string::npos);
  CHECK(render_github_annotations(data, "/elsewhere").find("file=") == std::string::npos);  // outside the workspace
  for (int i = 0; i < 30; ++i) data.verdicts.push_back(data.verdicts[1]);
  const std::string many = render_github_annotations(data, "");
  CHECK(std::count(many.begin(), many.end(), '\n') == 10);
  CHECK(many.find("and 23 more") != std::string::npos);
  CHECK(render_step_summary(data).find("claims") == std::string::npos);
  CHECK(render_step_summary(data).find("below its claim") != std::string::npos);
}

TEST_CASE("a baseline's changes: a line a scenario and method, the worst first, the rest counted by scenario") {
  const auto change = [](BaselineChange::Kind kind, const std::string& method, const std::string& metric,
                         double ratio) {
    BaselineChange c;
    c.kind = kind;
    c.scenario = "orbit";
    c.method = method;
    c.metric = metric;
    c.steps = 64;
    c.before = 1;
    c.now = ratio;
    c.allowed = 1.001;
    c.ratio = ratio;
    c.unit = "m";
    c.rerun = rerun_words("orbit", method, 64);
    return c;
  };
  using Kind = BaselineChange::Kind;
  const std::vector<BaselineChange> changes{change(Kind::regression, "a/mild", "error-position-max", 1.5),
                                            change(Kind::regression, "a/bad", "error-position-end", 2),
                                            change(Kind::regression, "a/bad", "error-position-max", 7),
                                            change(Kind::missing, "a/gone", "error-position-max", 1),
                                            change(Kind::missing, "a/gone", "error-position-end", 1),
                                            change(Kind::added, "a/new", "error-position-max", 1)};
  CHECK(
      render_baseline_table("b.tsv", changes, false) ==
      "regression   orbit  a/bad  error-position-max at 64 steps: 1 -> 7 m, allowed 1.001, 7 x as bad; 1 more figure\n"
      "             atwood run --scenario orbit --method a/bad --steps 64\n"
      "regression   orbit  a/mild  error-position-max at 64 steps: 1 -> 1.5 m, allowed 1.001, 1.5 x as bad\n"
      "             atwood run --scenario orbit --method a/mild --steps 64\n"
      "missing      orbit: 2 figures of a/gone\n"
      "new          orbit: 1 figure of a/new\n"
      "3 regressions, 2 missing, 0 improvements, 1 new, 0 unchanged against b.tsv\n");
}
