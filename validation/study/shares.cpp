#include "validation/study/shares.hpp"

#include <algorithm>
#include <charconv>
#include <numeric>

#include "scene/files.hpp"
#include "scene/printable.hpp"
#include "validation/metrics/order_statistics.hpp"
#include "validation/study/content_hash.hpp"
#include "validation/study/key_table.hpp"

namespace atwood {
namespace {

// A whole number from 0 to 10^9, or nothing.
std::optional<int> whole(const std::string& text) {
  int value = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < 0 || value > 1'000'000'000)
    return std::nullopt;
  return value;
}

using Variable = std::function<std::string(const std::string&)>;

int required(const Variable& variable, const std::string& name, const std::string& beside) {
  const std::string text = variable(name);
  if (text.empty())
    throw InputError(beside + " is set and " + name +
                     " is not, so that the number of shares is unknown; set it, or give " +
                     "--shard I/N (--shard 1/1: all cells)");
  const auto value = whole(text);
  if (!value) throw InputError(name + " is `" + printable(text) + "`; expected a whole number");
  return *value;
}

// A rank that counts from 0, and the number of ranks.
StudyShare ranked(const Variable& variable, const std::string& rank_name, const std::string& count_name) {
  const int rank = required(variable, rank_name, rank_name), count = required(variable, count_name, rank_name);
  if (rank >= count)
    throw InputError(rank_name + " is " + std::to_string(rank) + " and " + count_name + " is " + std::to_string(count) +
                     "; expected a smaller rank");
  return {rank + 1, count, rank_name};
}

// Slurm's tasks of an array are numbered MIN, MIN + STEP, ...
StudyShare of_array(const Variable& variable) {
  const std::string id_name = "SLURM_ARRAY_TASK_ID";
  const int id = required(variable, id_name, id_name), count = required(variable, "SLURM_ARRAY_TASK_COUNT", id_name),
            least = required(variable, "SLURM_ARRAY_TASK_MIN", id_name);
  const std::string step_text = variable("SLURM_ARRAY_TASK_STEP"), most_text = variable("SLURM_ARRAY_TASK_MAX");
  const int step = step_text.empty() ? 1 : required(variable, "SLURM_ARRAY_TASK_STEP", id_name);
  const int place = step > 0 && id >= least ? (id - least) / step : -1;
  const bool even =
      step > 0 && place >= 0 && place < count && least + place * step == id &&
      (most_text.empty() || required(variable, "SLURM_ARRAY_TASK_MAX", id_name) == least + (count - 1) * step);
  if (!even)
    throw InputError("the tasks of the Slurm array are not numbered evenly (SLURM_ARRAY_TASK_ID " + std::to_string(id) +
                     ", _MIN " + std::to_string(least) + ", _COUNT " + std::to_string(count) +
                     "); expected --array=0-N, or --shard I/N");
  return {place + 1, count, id_name};
}

std::optional<StudyShare> of_ranks(const Variable& variable) {
  const auto set = [&](const char* name) { return !variable(name).empty(); };
  if (set("OMPI_COMM_WORLD_RANK")) return ranked(variable, "OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE");
  if (set("PMI_RANK")) return ranked(variable, "PMI_RANK", "PMI_SIZE");
  // Slurm sets rank 0 in a batch script too, which runs once for all of the job's tasks; srun sets a step's number.
  const bool batch_script = set("SLURM_JOB_ID") && !set("SLURM_STEP_ID");
  if (set("SLURM_PROCID") && !batch_script) return ranked(variable, "SLURM_PROCID", "SLURM_NTASKS");
  return std::nullopt;
}

}  // namespace

StudyShare parse_share(const std::string& text) {
  const std::size_t slash = text.find('/');
  const auto number = whole(text.substr(0, slash));
  const auto count = slash == std::string::npos ? std::nullopt : whole(text.substr(slash + 1));
  if (!number || !count || *number < 1 || *number > *count)
    throw InputError("--shard " + printable(text) + ": expected I/N with I from 1 to N, as in --shard 2/8");
  return {*number, *count, "--shard"};
}

std::optional<StudyShare> share_of_launcher(const Variable& variable) {
  std::optional<StudyShare> ranks = of_ranks(variable), array;
  if (!variable("SLURM_ARRAY_TASK_ID").empty()) array = of_array(variable);
  if (!variable("JOB_COMPLETION_INDEX").empty()) array = ranked(variable, "JOB_COMPLETION_INDEX", "JOB_COMPLETIONS");
  if (!array || array->count == 1) return ranks && ranks->count > 1 ? ranks : array ? array : ranks;
  if (!ranks || ranks->count == 1) return array;
  if (array->count > 1'000'000'000 / ranks->count) throw InputError("the launcher has more than 10^9 processes");
  return StudyShare{(array->number - 1) * ranks->count + ranks->number, array->count * ranks->count,
                    array->source + " and " + ranks->source};
}

// ---- the split ----------------------------------------------------------------------------------------------------
std::string ladder_name(const Cell& cell) {
  std::string name = cell.scenario->id + ", " + cell.method;
  if (cell.probe != Probe::none) name += std::string(", ") + to_string(cell.probe);
  if (const std::string at = resolution_text(resolution_of(cell)); !at.empty()) name += ", " + at;
  return name;
}

namespace {

double step_ns(const std::map<std::int64_t, double>& rungs) {
  const auto& [steps, ns] = *rungs.rbegin();
  return ns / static_cast<double>(std::max<std::int64_t>(1, steps));
}

double cost_in(const std::map<std::int64_t, double>& rungs, std::int64_t steps) {
  const auto known = rungs.find(steps);
  return known != rungs.end() ? known->second : step_ns(rungs) * static_cast<double>(steps);
}

double bodies_of(const Cell& cell) {
  double count = static_cast<double>(cell.scenario->scene.bodies.size());
  for (const Fluid& fluid : cell.scenario->scene.fluids) count += static_cast<double>(fluid.particles.mass_kg.size());
  return std::max(1.0, count);
}

// Of a step of a ladder that the file does not have; 0: the file is empty.
double usual_step_ns(const Costs& costs) {
  std::vector<double> all;
  for (const auto& [name, rungs] : costs.ladder_ns)
    if (!rungs.empty()) all.push_back(step_ns(rungs));
  return metrics::median_in_place(all);
}

double cost_of(const Cell& cell, const std::string& ladder, const Costs& costs, double usual_ns) {
  const auto known = costs.ladder_ns.find(ladder);
  if (known != costs.ladder_ns.end() && !known->second.empty()) return cost_in(known->second, cell.plan.steps);
  return static_cast<double>(cell.plan.steps) * (usual_ns > 0 ? usual_ns : bodies_of(cell));
}

}  // namespace

std::vector<double> expected_costs_ns(const std::vector<const Cell*>& cells, const Costs& costs) {
  const double usual_ns = usual_step_ns(costs);
  std::vector<double> cost_ns;
  cost_ns.reserve(cells.size());
  for (const Cell* cell : cells) cost_ns.push_back(cost_of(*cell, ladder_name(*cell), costs, usual_ns));
  return cost_ns;
}

Ladders ladders_by_cost(const std::vector<Cell>& cells, const Costs& costs) {
  Ladders found;
  std::vector<std::string> names;
  KeyTable<std::size_t> index;
  const double usual_ns = usual_step_ns(costs);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (cells[i].worker < 0) continue;
    const std::string name = ladder_name(cells[i]);
    const auto [place, fresh] = index.insert(key_sum(name), names.size());
    if (fresh) names.push_back(name), found.cells.emplace_back(), found.cost_ns.push_back(0);
    found.cells[*place].push_back(i);
    found.cost_ns[*place] += cost_of(cells[i], name, costs, usual_ns);
  }
  std::vector<std::size_t> order(names.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    if (found.cost_ns[a] != found.cost_ns[b]) return found.cost_ns[a] > found.cost_ns[b];
    return names[a] < names[b];
  });
  Ladders sorted;
  for (const std::size_t i : order) {
    sorted.cells.push_back(std::move(found.cells[i]));
    sorted.cost_ns.push_back(found.cost_ns[i]);
  }
  return sorted;
}

std::vector<int> deal(std::size_t ladders, int count) {
  std::vector<int> shares(ladders);
  const auto n = static_cast<std::size_t>(std::max(1, count));
  for (std::size_t i = 0; i < ladders; ++i) {
    const std::size_t place = i % n;
    shares[i] = static_cast<int>(i / n % 2 == 0 ? place : n - 1 - place);
  }
  return shares;
}

std::vector<std::vector<std::size_t>> chunks(const Ladders& ladders, std::size_t most) {
  std::vector<std::vector<std::size_t>> all;
  const double total = std::accumulate(ladders.cost_ns.begin(), ladders.cost_ns.end(), 0.0);
  const double wanted = total / static_cast<double>(std::max<std::size_t>(1, most));
  double cost = 0;
  for (std::size_t i = 0; i < ladders.cells.size(); ++i) {
    if (all.empty() || (cost >= wanted && all.size() < most)) {
      all.emplace_back();
      cost = 0;
    }
    all.back().insert(all.back().end(), ladders.cells[i].begin(), ladders.cells[i].end());
    cost += ladders.cost_ns[i];
  }
  return all;
}

std::string plan_hash(const std::vector<Cell>& cells) {
  std::string all;
  for (const Cell& cell : cells)
    all.append(ladder_name(cell)).append(", " + std::to_string(cell.plan.steps) + " ").append(cell.accuracy_hash) +=
        '\n';
  return content_hash(std::string_view(all));
}

}  // namespace atwood
