// Files of settings: studies, gates, baselines, costs, cases of contacts.
#include <algorithm>
#include <tuple>

#include "scene/files.hpp"
#include "validation/gates/gates.hpp"
#include "validation/study/pose_sweep.hpp"
#include "validation/study/shares.hpp"
#include "validation/study/study.hpp"
#include "validation/tests/fuzz/target.hpp"

namespace atwood::fuzz {

void read_study_file(std::string_view bytes) {
  const std::string path = file("study.toml", bytes);
  const auto study = read_or_refuse<InputError>([&] { return read_study(path); });
  if (study) require(!study->id.empty() && !study->cells.empty(), "a study has a name and cells");
}

void read_gates_file(std::string_view bytes) {
  const std::string path = file("gates.toml", bytes);
  const auto gates = read_or_refuse<InputError>([&] { return read_gates(path); });
  if (!gates) return;
  require(!gates->empty(), "a file of gates has a gate");
  for (const Gate& gate : *gates) require(!gate.reason.empty(), "a gate has a reason");
}

// What follows the first zero byte is the environment beside the figures.
void read_baseline_file(std::string_view bytes) {
  const std::size_t end = std::min(bytes.find('\0'), bytes.size());
  const std::string path = file("baseline.tsv", bytes.substr(0, end));
  file("baseline.tsv.env", bytes.substr(std::min(end + 1, bytes.size())));
  const auto baseline = read_or_refuse<InputError>([&] { return read_baseline(path); });
  if (!baseline) return;
  const auto before = [](const BaselineEntry& a, const BaselineEntry& b) {
    return std::tie(a.scenario, a.method, a.steps, a.metric) < std::tie(b.scenario, b.method, b.steps, b.metric);
  };
  require(std::is_sorted(baseline->entries.begin(), baseline->entries.end(), before), "a baseline is sorted");
}

void read_costs_file(std::string_view bytes) {
  const std::string path = file("costs.json", bytes);
  const auto costs = read_or_refuse<InputError>([&] { return read_costs(path); });
  if (!costs) return;
  const std::string text = costs_to_json(*costs);
  require(costs_to_json(read_costs(file("costs.json", text))) == text, "costs that were written read the same");
}

void read_contact_case_file(std::string_view bytes) {
  const std::string path = file("cases.toml", bytes);
  const auto cases = read_or_refuse<InputError>([&] { return read_contact_cases(path); });
  if (!cases) return;
  for (const ContactCase& each : *cases) require(each.scene.bodies.size() == 2, "a case has two bodies");
}

}  // namespace atwood::fuzz
