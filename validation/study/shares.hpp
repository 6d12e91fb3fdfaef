// Splits the cells of a study into shares, one for each process of a launcher (Slurm, MPI, Kubernetes, GNU parallel).
//
// The split is a pure function of the cells' names, the number of shares and the costs, so that processes that never
// talk to each other agree on it. A ladder (scenario, method, resolution) stays in one share: its coarse rungs decide
// whether its fine ones are tried.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "validation/study/study.hpp"

namespace atwood {

struct StudyShare {
  int number = 1, count = 1;  // 1 <= number <= count
  std::string source;         // who said so: "--shard", "SLURM_ARRAY_TASK_ID"
};
// "2/8". InputError where it is not a share.
StudyShare parse_share(const std::string& text);
// The share that the launcher of this process gives it, from its environment; empty: there is no launcher. `variable`
// returns the value of an environment variable, or "". InputError where the variables contradict each other or do not
// tell the number of shares.
std::optional<StudyShare> share_of_launcher(const std::function<std::string(const std::string&)>& variable);

// What cells cost, learned from a store (`atwood costs`): wall time of the steps of each ladder.
struct Costs {
  std::map<std::string, std::map<std::int64_t, double>> ladder_ns;  // ladder_name -> steps -> ns
  std::string hash;                                                 // of the file; empty: there is none
};
// Name of the ladder that a cell belongs to, the same in every store.
std::string ladder_name(const Cell& cell);
Costs read_costs(const std::string& path);  // InputError
std::string costs_to_json(const Costs& costs);
// The median wall times of these cells' runs and timed passes in a store. InputError where the store has none of them.
Costs learn_costs(const std::string& store_path, const std::vector<Cell>& cells);

// Expected cost of each cell [ns]: what was measured; else its steps times the cost of a step, of the finest measured
// rung of its ladder, else of the median ladder of the file, else 1 ns for each body and particle.
std::vector<double> expected_costs_ns(const std::vector<const Cell*>& cells, const Costs& costs);

struct Ladders {
  std::vector<std::vector<std::size_t>> cells;  // indices of cells, in the order of the study
  std::vector<double> cost_ns;
};
// The ladders of the cells that an engine can run, dearest first; equal costs in the order of their names.
Ladders ladders_by_cost(const std::vector<Cell>& cells, const Costs& costs);
// Shares 0 .. count - 1 of the ladders: dealt in snake order, 0 1 .. n-1 n-1 .. 1 0 0 1 ...
std::vector<int> deal(std::size_t ladders, int count);
// Consecutive ladders of about the same cost together, at most `most` chunks; the dearest are chunks of their own.
std::vector<std::vector<std::size_t>> chunks(const Ladders& ladders, std::size_t most);

// Hash of what is run: the cells in their order. Processes of one sharded run agree on it.
std::string plan_hash(const std::vector<Cell>& cells);

}  // namespace atwood
