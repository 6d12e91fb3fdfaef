// Documents against golden files, and what golden files cannot say: that other programs can read them back.
// ATWOOD_WRITE_GOLDEN=1 writes the golden files anew; read the difference before you commit it.
#include <catch2/catch.hpp>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <pugixml.hpp>
#include <sstream>

#include "reports/render/embedded_data.hpp"
#include "reports/render/ran_methods.hpp"
#include "reports/render/solver_table.hpp"
#include "reports/render/text.hpp"
#include "reports/render/wasm_table.hpp"
#include "synthetic.hpp"
#include "validation/study/write_file.hpp"

namespace {

using namespace atwood;

void check_golden(const std::string& name, const std::string& text) {
  const std::string path = std::string(ATWOOD_SOURCE_DIR) + "/validation/tests/reports/golden/" + name;
  if (std::getenv("ATWOOD_WRITE_GOLDEN") != nullptr) write_file(path, text);
  std::ifstream file(path, std::ios::binary);
  REQUIRE(file);
  const std::string golden((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  CHECK(text == golden);
}

// RFC 4180, written from the specification: records of fields.
std::vector<std::vector<std::string>> parse_csv(const std::string& text) {
  std::vector<std::vector<std::string>> records{{""}};
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted) {
      if (c != '"') records.back().back() += c;
      else if (i + 1 < text.size() && text[i + 1] == '"') records.back().back() += text[++i];
      else quoted = false;
    } else if (c == '"') {
      quoted = true;
    } else if (c == ',') {
      records.back().emplace_back();
    } else if (c == '\n') {
      records.push_back({""});
    } else {
      records.back().back() += c;
    }
  }
  records.pop_back();  // after the last line break
  return records;
}

std::size_t points(const std::string& line) {
  std::size_t count = 0;
  for (const char c : line) count += (static_cast<unsigned char>(c) & 0xC0) != 0x80;
  return count;
}

}  // namespace

TEST_CASE("every document of a report equals its golden file") {
  const ReportData data = small_report();
  check_golden("rows.csv", render_csv(data.rows));
  check_golden("report.json", render_json(data));
  check_golden("report.md", render_markdown(data));
  check_golden("junit.xml", render_junit(data.verdicts));
  check_golden("verdicts.txt", render_verdict_table(data.verdicts, data.rows, false, 80));
  check_golden("verdicts_colour.txt", render_verdict_table(data.verdicts, data.rows, true, 120));
}

TEST_CASE("tables of figures: aligned for a terminal, whole in JSON and Markdown, absent when there are none") {
  BenchTable table{"frame",
                   "What fits | a frame",
                   {"method", "N"},
                   {{"ours", 8000.0}, {"rival|two\nlines", std::nan("")}, {"small", 0.12345678901}},
                   {"How to read it."}};
  CHECK(render_bench_table(table) ==
        "What fits | a frame\n\n"
        "method               N\n"
        "ours              8000\n"
        "rival|two lines      -\n"
        "small            0.123\n"
        "\nHow to read it.\n");
  ReportData data;
  CHECK(render_json(data).find("\"tables\"") == std::string::npos);
  CHECK(render_markdown(data).find("What fits") == std::string::npos);
  data.tables = {table};
  const auto json = nlohmann::json::parse(render_json(data)).at("tables").at(0);
  CHECK(json.at("id") == "frame");
  CHECK(json.at("rows").at(0).at(1) == 8000);
  CHECK(json.at("rows").at(1).at(1).is_null());
  CHECK(json.at("rows").at(2).at(1) == 0.12345678901);
  const std::string markdown = render_markdown(data);
  CHECK(markdown.find("| ours | 8000 |\n| rival\\|two lines | - |\n") != std::string::npos);
}

TEST_CASE("solves that ended above their tolerance are told with solver, residual and its scale") {
  std::vector<Row> rows;
  const auto add = [&](std::int64_t steps, const std::string& solver, const std::string& metric, double value) {
    Row row;
    row.scenario = "stack";
    row.method = "atwood/rk4+impulse";
    row.steps = steps;
    row.body = solver;
    row.metric = metric;
    row.unit = "1";
    row.value = value;
    if (metric == "solver-residual-max") row.reason = "change | over the largest";
    rows.push_back(row);
  };
  const auto add_all = [&](std::int64_t steps, const std::string& solver, double capped, double residual) {
    add(steps, solver, "solver-converged", 5);
    add(steps, solver, "solver-stagnated", 0);
    add(steps, solver, "solver-capped", capped);
    add(steps, solver, "solver-iterations-max", 40);
    add(steps, solver, "solver-residual-max", residual);
  };
  add_all(60, "contact-newton", 0, 1e-13);
  CHECK(solvers_section(rows, 10).empty());
  CHECK(unconverged_words(rows).empty());
  add_all(60, "contact-sweeps", 3, 0.25);
  add_all(120, "contact-sweeps", 2, 0.5);
  add_all(60, "impact-time", 1, std::nan(""));
  const std::string section = solvers_section(rows, 10);
  CHECK(section.find("| stack | atwood/rk4+impulse | 120 | contact-sweeps | 2 | 7 | 40 | 0.5 | change \\| over the "
                     "largest |\n") != std::string::npos);
  CHECK(section.find("| 60 | contact-sweeps") == std::string::npos);  // the rung with the largest residual alone
  CHECK(section.find("contact-newton") == std::string::npos);
  CHECK(section.find("impact-time") < section.find("contact-sweeps"));  // NaN first
  CHECK(solvers_section(rows, 1).find("And 1 more.") != std::string::npos);
  CHECK(
      unconverged_words(rows).find("contact-sweeps: solves above the tolerance in 2 cells, residual up to 0.5 (stack, "
                                   "atwood/rk4+impulse, 120 steps)\n") != std::string::npos);
  ReportData data;
  data.rows = rows;
  CHECK(render_markdown(data).find("## Solves that ended above their tolerance") != std::string::npos);
}

TEST_CASE("the page counts every change and holds the first of them") {
  ReportData data = small_report();
  data.baseline_path = "run 12";
  const auto add = [&](BaselineChange::Kind kind, int count) {
    BaselineChange change;
    change.kind = kind;
    data.baseline.resize(data.baseline.size() + static_cast<std::size_t>(count), change);
  };
  data.baseline.clear();
  add(BaselineChange::Kind::unchanged, 9);
  add(BaselineChange::Kind::missing, 2);
  add(BaselineChange::Kind::improvement, 200);
  add(BaselineChange::Kind::regression, 300);
  const auto page = nlohmann::json::parse(embedded_json(data, {6, 3, 129, true, 8}));
  const nlohmann::json counts{{"regression", 300}, {"improvement", 200}, {"missing", 2}, {"added", 0}};
  CHECK(page["change_counts"] == counts);
  REQUIRE(page["changes"].size() == 400);
  CHECK(page["changes"][299]["kind"] == "regression");
  CHECK(page["changes"][399]["kind"] == "improvement");
}

TEST_CASE("every method that ran shows every setting of its scheme and of its response, and no other is shown") {
  ReportData data = small_report();
  Row row = data.rows.front();
  data.rows.clear();
  const auto add = [&](const std::string& method, Status status) {
    row.method = method;
    row.status = status;
    data.rows.push_back(row);
  };
  add("atwood/rk4+impulse{solver=direct,erp=0.5}", Status::ok);
  add("atwood/rk4+impulse{solver=direct,erp=0.5}", Status::crashed);
  add("atwood/heun", Status::unsupported);
  add("fcl/contacts", Status::ok);
  add("recorded elsewhere", Status::ok);
  data.engines[0].methods[0].settings["scalar"] = std::string("double");
  data.engines[0].methods[0].settings["rtol"] = 1e-10;
  add("atwood/rk4:1e-6@float", Status::ok);
  const std::vector<RanMethod> ran = ran_methods(data.engines, data.rows);
  REQUIRE(ran.size() == 3);
  CHECK(settings_words(ran[2].settings) ==
        "erp = 0.2, iterations = 10, rtol = 1e-06, scalar = float, sleeping = false, solver = a|b");
  CHECK(settings_words(ran[0].settings) ==
        "erp = 0.5, iterations = 10, rtol = 1e-10, scalar = double, sleeping = false, solver = direct");
  REQUIRE(ran[0].response != nullptr);
  CHECK(settings_words(ran[0].response_settings) == "rest_sweeps = 100, sleeping = false, solver = direct");
  CHECK(ran[1].scheme == nullptr);
  const std::vector<Engine> engines = engines_that_ran(data.engines, ran);
  REQUIRE(engines.size() == 2);
  REQUIRE(engines[0].methods.size() == 1);
  CHECK(engines[0].methods[0].id == "atwood/rk4");
  REQUIRE(engines[0].responses.size() == 1);
  CHECK(engines[0].responses[0].id == "+impulse");
  CHECK(engines[1].methods.empty());

  const auto json = nlohmann::json::parse(render_json(data));
  CHECK(json.at("ran").at(0).at("response_settings").at("rest_sweeps") == 100);
  CHECK(json.at("engines").at(0).at("responses").size() == 2);  // the document for programs keeps all that is offered
  const auto page = nlohmann::json::parse(embedded_json(data, {6, 3, 129, true, 8}));
  CHECK(page.at("engines").at(0).at("methods").size() == 1);
  CHECK(page.at("ran") == json.at("ran"));
  const std::string markdown = render_markdown(data);
  CHECK(markdown.find("sweeps = 100, sleeping = false, solver = direct |") != std::string::npos);
  CHECK(markdown.find("Impulses \\| in substeps.") != std::string::npos);
  CHECK(markdown.find("idle_setting") == std::string::npos);
}

TEST_CASE("an order that the runs do not tell reads as inconclusive") {
  CHECK(order_words(3.98, 0.02) == "3.98");
  CHECK(order_words(0.93, 0.4) == "inconclusive (+/- 0.4)");
  CHECK(order_words(0.0, 0.0) == "inconclusive (no convergence)");
  CHECK(order_words(-0.5, 0.1) == "-0.50");  // the error grows as h shrinks: that is a finding
  CHECK(order_words(std::nan(""), 0) == "inconclusive");
  ReportData data = small_report();
  for (Row& row : data.rows)
    if (row.metric == "order-position") row.truth_bar = 0.3;
  CHECK(render_markdown(data).find("| kepler-e0.6 | inconclusive (+/- 0.3) |") != std::string::npos);
}

TEST_CASE("CSV has the contract's columns and reads back exactly") {
  const ReportData data = small_report();
  const auto records = parse_csv(render_csv(data.rows));
  REQUIRE(records.size() == data.rows.size() + 1);
  CHECK(records[0] ==
        std::vector<std::string>{
            "scenario", "method",   "steps",     "h_s",    "body",   "t_s",           "metric",
            "unit",     "value",    "truth_bar", "status", "reason", "settings_hash", "engine_version",
            "commit",   "compiler", "flags",     "cpu",    "run_id", "spacing_m",     "sound_speed_m_per_s"});
  for (std::size_t i = 0; i < data.rows.size(); ++i) {
    const Row& row = data.rows[i];
    const auto& record = records[i + 1];
    REQUIRE(record.size() == 21);
    CHECK(record[19].empty());  // of fluids alone
    CHECK(record[20].empty());
    CHECK(record[1] == row.method);
    CHECK(record[4] == row.body);
    CHECK(record[5].empty() == !row.t_s.has_value());
    CHECK((std::stod(record[8]) == row.value || std::isnan(row.value)));
    CHECK(std::stod(record[3]) == row.h_s);
    if (row.status != Status::crashed) CHECK(record[11] == row.reason);
    CHECK(record[17] == row.provenance->cpu);
  }
  CHECK(records[3][11] == "line one\nline \xEF\xBF\xBD[31m two, \"quoted\" \xEF\xBF\xBD");
}

TEST_CASE("rows of fluids carry their resolution; the table says what is lost to what") {
  ReportData data = small_report();
  const auto add = [&](const char* metric, std::int64_t steps, double value, const char* body = "") {
    Row& row = data.rows.emplace_back();
    row.scenario = "vortices", row.method = "atwood/rk4+sph", row.metric = metric, row.unit = "1";
    row.steps = steps, row.value = value, row.body = body;
    row.spacing_m = 0.02, row.sound_speed_m_per_s = 20;
  };
  add("velocity-l1", 640, 0.011);
  add("velocity-l1", 320, 0.099);
  add("model-error", 640, 0.001);
  add("space-error", 640, 0.012);
  add("space-error", 640, 0.77, "linf");
  add("time-error", 640, 3.3e-7);
  add("order-time", 0, 4.01);
  add("fluid-momentum-error", 640, 2e-16);
  const auto records = parse_csv(render_csv(data.rows));
  CHECK(records.back()[19] == "0.02");
  CHECK(records.back()[20] == "20");
  const auto json = nlohmann::json::parse(render_json(data));
  CHECK(json["rows"].back()["spacing_m"] == 0.02);
  CHECK_FALSE(json["rows"][0].contains("spacing_m"));
  const std::string markdown = render_markdown(data);
  CHECK(markdown.find("| vortices | atwood/rk4+sph | 0.02 | 20 | 640 | 0.011 | 0.001 | 0.012 | 3.3e-07 | time 4.01 | "
                      "momentum 2e-16 |") != std::string::npos);
  CHECK(render_html(data).find("<section id=\"fluids\">") != std::string::npos);
  CHECK(render_html(data).find("<td data-head=\"time\">3.3e-07</td>") != std::string::npos);
  CHECK(render_markdown(small_report()).find("## Fluids") == std::string::npos);
  // In words which line separates the losses; a scene whose steps' error is part of space stands after it.
  CHECK_THAT(markdown,
             Catch::Contains("What is lost to what, for example in vortices by atwood/rk4+sph at a spacing of 0.02 m "
                             "and c = 20 m/s: of the error of 0.011, the Mach number makes 0.001, space 0.012 and "
                             "time 3.3e-07; parts of opposite signs cancel."));
  ReportData mixed = small_report();
  for (const Row& row : data.rows) {
    if (row.scenario != "vortices") continue;
    mixed.rows.push_back(row);
    mixed.rows.back().scenario = "a-drop";
  }
  std::erase_if(mixed.rows, [](const Row& row) { return row.metric == "time-error"; });
  CHECK(render_markdown(mixed).find("What is lost to what") == std::string::npos);
  for (const Row& row : data.rows)
    if (row.scenario == "vortices") mixed.rows.push_back(row);
  const std::string both = render_markdown(mixed), table = both.substr(both.find("## Fluids"));
  CHECK(table.find("| vortices |") < table.find("| a-drop |"));
}

TEST_CASE("JSON parses, keeps every digit, and spells non-finite numbers as strings") {
  const ReportData data = small_report();
  const auto json = nlohmann::json::parse(render_json(data));
  REQUIRE(json["rows"].size() == data.rows.size());
  CHECK(json["rows"][0]["value"].get<double>() == data.rows[0].value);
  CHECK(json["rows"][0]["t_s"].is_null());
  CHECK(json["rows"][1]["t_s"].get<double>() == 0.1);
  CHECK(json["rows"][3]["value"] == "nan");
  CHECK(json["rows"][3]["status"] == "not finite");
  CHECK(json["verdict"] == nlohmann::json{{"pass", 1}, {"fail", 1}, {"unverifiable", 1}, {"not_run", 1}});
  CHECK(json["engines"][0]["methods"][0]["settings"]["iterations"] == 10);
  CHECK(json["series"][0]["energy"].size() == 3);
}

TEST_CASE("JUnit counts all that did not pass as failures and carries the command") {
  const ReportData data = small_report();
  pugi::xml_document document;
  REQUIRE(document.load_string(render_junit(data.verdicts).c_str()));
  const pugi::xml_node root = document.child("testsuites");
  CHECK(root.attribute("tests").as_int() == 4);
  CHECK(root.attribute("failures").as_int() == 3);
  const auto failures = root.select_nodes("//failure");
  REQUIRE(failures.size() == 3);
  std::size_t next = 0;
  for (const Verdict& verdict : data.verdicts) {
    if (verdict.judgement == Judgement::pass) continue;
    // XPath answers in document order, suites stand in the order of their first verdict: the fail shares a suite.
    CHECK(std::string(failures[next].node().text().get()).find("rerun: " + shell_line(verdict.rerun)) !=
          std::string::npos);
    ++next;
  }
  CHECK(std::string(root.child("testsuite").next_sibling().attribute("name").value()) == "a <b> & \"c\" | d");
}

TEST_CASE("the verdict table fits, hides no failing gate, and lets no control character through") {
  const ReportData data = small_report();
  for (const int width : {60, 80, 120}) {
    std::istringstream plain(render_verdict_table(data.verdicts, data.rows, false, width));
    std::string line, all;
    while (std::getline(plain, line)) {
      all += line + '\n';
      CHECK(line.find('\x1b') == std::string::npos);
      if (line.find("atwood run") == std::string::npos) CHECK(points(line) <= static_cast<std::size_t>(width));
    }
    for (const Verdict& verdict : data.verdicts) {
      if (verdict.judgement != Judgement::pass) CHECK(all.find(shell_line(verdict.rerun)) != std::string::npos);
    }
    CHECK(all.find("FAIL") < all.find("4 gates: 1 pass, 1 fail, 1 unverifiable, 1 not run"));
    CHECK(all.find("fail ") < all.find("unverifiable"));
  }
  CHECK(render_verdict_table(data.verdicts, data.rows, true, 80).find("\x1b[31m") != std::string::npos);
  CHECK(render_verdict_table({}, {}, false, 80).find("NO GATES") != std::string::npos);
  const std::vector<Verdict> passing{data.verdicts[0]};
  CHECK(render_verdict_table(passing, {}, false, 80).find("PASS  1 gate:") != std::string::npos);
}

TEST_CASE("HTML is one small file in which hostile text stays text") {
  const ReportData data = synthetic_report({40, 20, 10, 128});
  REQUIRE(data.rows.size() > 60000);
  const std::string html = render_html(data);
  CHECK(html.size() < 3'000'000);
  CHECK(html.find("default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:") !=
        std::string::npos);
  CHECK(html.find("<img src=x") == std::string::npos);
  CHECK(html.find("src=\"http") == std::string::npos);
  std::size_t closed = 0;
  for (std::size_t at = html.find("</script"); at != std::string::npos; at = html.find("</script", at + 1)) ++closed;
  CHECK(closed == 2);  // the data's and the program's
  const std::string title = render_html([] {
    ReportData hostile;
    hostile.title = "</title><script>alert(1)</script>";
    return hostile;
  }());
  CHECK(title.find("<script>alert") == std::string::npos);
  CHECK(title.find("No gates") != std::string::npos);
}

TEST_CASE("a report of some ladders of many cells tells the counts of all, scene by scene") {
  ReportData data = small_report();
  data.counted_in_all.pass = 99'856;
  SceneCounts counts;
  counts.ladders = 12'500, counts.shown = 12, counts.cells = 62'500, counts.pass = 6'241;
  data.counted.push_back({"<orbit>", counts, "atwood report study.toml --scenario orbit"});
  const std::string page = render_html(data);
  CHECK(page.find("All 99856 gates pass.") != std::string::npos);
  CHECK(page.find("<td>&lt;orbit&gt;</td><td class=\"number\">12500</td><td class=\"number\">12</td>"
                  "<td class=\"number\">62500</td>") != std::string::npos);
  CHECK(page.find("<code>atwood report study.toml --scenario orbit</code>") != std::string::npos);
  const std::string summary = render_step_summary(data);
  CHECK(summary.find("99856 gates: 99856 pass, 0 fail") != std::string::npos);
  CHECK(summary.find("| 12500 | 12 | 62500 | 0 | 0 | 6241 | 0 | 0 | 0 |") != std::string::npos);
  data.counted_in_all.fail = 3;
  CHECK(render_html(data).find("3 of 99859 gates did not pass.") != std::string::npos);
}

TEST_CASE("times under WebAssembly are a table of their own: the most steps, the call told apart") {
  std::vector<Row> rows;
  const auto add = [&](const char* method, std::int64_t steps, const char* metric, double value) {
    Row row;
    row.scenario = "bounce", row.method = method, row.steps = steps, row.metric = metric, row.value = value,
    row.unit = "s";
    rows.push_back(row);
  };
  CHECK(wasm_tables(rows).empty());
  add("bullet32/default", 240, "step-time", 2e-6);
  CHECK(wasm_tables(rows).empty());
  for (const std::int64_t steps : {240, 480, 120}) {
    add("rapier/default", steps, "step-time-wasm", 1e-8 * static_cast<double>(steps));
    add("rapier/default", steps, "call-time-wasm", 1e-6);
  }
  const std::vector<BenchTable> tables = wasm_tables(rows);
  REQUIRE(tables.size() == 1);
  REQUIRE(tables[0].rows.size() == 1);
  const std::vector<TableCell>& line = tables[0].rows[0];
  CHECK(std::get<std::string>(line[1]) == "rapier/default");
  CHECK(std::get<double>(line[2]) == 480);
  CHECK(std::get<double>(line[3]) == Approx(4.8));
  CHECK(std::get<double>(line[4]) == Approx(1));
  CHECK(std::get<double>(line[5]) == Approx(3.8));
}
