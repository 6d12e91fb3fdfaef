// Contacts compared with answers derived by hand.
#include <algorithm>
#include <filesystem>
#include <set>
#include <sstream>

#include <toml++/toml.h>

#include "scene/files.hpp"
#include "scene/input_file.hpp"
#include "validation/metrics/measurements.hpp"
#include "validation/metrics/pose_metrics.hpp"
#include "validation/study/pose_sweep.hpp"

namespace atwood {
namespace {

namespace fs = std::filesystem;

constexpr const char* kHead =
    "id = \"case\"\ntitle = \"A case of a table\"\nclaim = \"The answer by hand\"\nsource = \"by hand\"\n"
    "[run]\nt_end_s = 1.0\nsteps = [1]\nsamples = 1\n[world]\ngravity_m_per_s2 = [0, 0, 0]\n[truth]\nkind = \"none\"\n";

ContactCase read_case(const toml::table& table, const std::string& path, int number) {
  const std::string where = path + ": case " + std::to_string(number);
  ContactCase read;
  const auto name = table["name"].value<std::string>();
  const auto gap = table["gap_m"].value<double>();
  const toml::array* bodies = table["body"].as_array();
  if (!name || !gap || !bodies || bodies->size() != 2)
    throw InputError(where + ": expected `name`, `gap_m` and two [[case.body]]");
  read.name = *name;
  read.answer.gap_m = *gap;
  read.answer.hit = *gap <= 0;
  if (const toml::array* normal = table["normal"].as_array()) {
    if (normal->size() != 3) throw InputError(where + ": `normal`: expected three numbers");
    for (std::size_t i = 0; i < 3; ++i) read.answer.normal[i] = normal->get(i)->value<double>().value_or(0);
    read.answer.margin_m = HUGE_VAL;  // a normal that the case gives is unique
  }
  std::ostringstream text;  // a scenario of the two bodies
  text << kHead << toml::table{{"body", *bodies}} << "\n";
  read.scene = read_scenario_text(text.str(), where, fs::path(path).parent_path().string()).scene;
  return read;
}

}  // namespace

std::vector<ContactCase> read_contact_cases(const std::string& path) {
  const std::string text = read_input_file(path, "a table of contacts (TOML)", largest::kSettings);
  require_shallow_toml(text, path);
  toml::table root;
  try {
    root = toml::parse(text, path);
  } catch (const toml::parse_error& error) {
    throw InputError(path + ":" + std::to_string(error.source().begin.line) + ": " + std::string(error.description()));
  }
  const toml::array* list = root["case"].as_array();
  if (!list || list->empty()) throw InputError(path + ": no [[case]]; expected at least one");
  std::vector<ContactCase> cases;
  for (const toml::node& each : *list)
    cases.push_back(read_case(*each.as_table(), path, static_cast<int>(cases.size()) + 1));
  return cases;
}

std::vector<Row> table_rows(const Cell& cell, WorkerClient& client, const std::string& folder, double limit_s,
                            const std::string& scalar, Outcome& outcome) {
  const std::string test = cell.method.substr(cell.method.find('/') + 1);
  std::set<std::string> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".toml") files.insert(entry.path().string());
  std::vector<Row> rows;
  Recording all;  // of all cases: how the engine's solvers ended
  for (const std::string& file : files) {
    const std::vector<ContactCase> cases = read_contact_cases(file);
    const std::string pair = fs::path(file).stem().string();
    std::vector<PoseAnswer> answers, truths;
    Outcome failed;
    for (const ContactCase& each : cases) {
      const ContactAnswer found = client.contacts(scene_to_json(each.scene), 2, {}, limit_s, test);
      if (found.outcome.status != Status::ok) failed = found.outcome;
      for (const auto& [solver, tally] : found.outcome.solvers) all.outcome.solvers[solver].add(tally);
      answers.push_back(deepest_contact(found));
      truths.push_back(each.answer);
    }
    if (failed.status != Status::ok) {
      Row row = metrics::row("contact-misses", 0, 0, failed.reason);
      row.body = pair;
      row.status = failed.status;
      rows.push_back(row);
      if (failed.status != Status::unsupported) outcome = failed;
      continue;
    }
    const auto scene_of = [&](std::int64_t k) { return cases[static_cast<std::size_t>(k)].scene; };
    const PoseRows measured = measure_poses(pair, false, scene_of, answers, truths, input_rounding(scalar, test));
    rows.insert(rows.end(), measured.rows.begin(), measured.rows.end());
  }
  const std::vector<Row> whole = over_all_pairs(rows);
  rows.insert(rows.begin(), whole.begin(), whole.end());
  metrics::append_solver_figures(all, rows);
  return rows;
}

}  // namespace atwood
