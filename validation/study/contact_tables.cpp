// Contacts compared with answers derived by hand.
#include <algorithm>
#include <filesystem>
#include <set>

#include "scene/files.hpp"
#include "validation/metrics/measurements.hpp"
#include "validation/metrics/pose_metrics.hpp"
#include "validation/study/pose_sweep.hpp"

namespace atwood {
namespace fs = std::filesystem;

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
