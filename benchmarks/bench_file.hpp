// bench.json: the figures, goals and tables of `atwood bench`, which reports show.
#pragma once

#include <string>
#include <vector>

#include "benchmarks/figures.hpp"
#include "validation/row.hpp"

namespace atwood {

std::string read_bench_text(const std::string& path);  // the text of a bench.json; empty where the file does not exist
std::vector<BenchFigure> read_bench(const std::string& path);
std::vector<GoalResult> read_goal_results(const std::string& path);
std::vector<BenchTable> read_bench_tables(const std::string& path);

// Tables in the JSON form of programs and of bench.json: {"tables": [...]}.
std::vector<BenchTable> bench_tables_from(const std::string& text);
std::string bench_tables_json(const std::vector<BenchTable>& tables);

// Writes figures and goals to the file. Null: the file's present ones are kept.
void keep_bench(const std::string& path, const Provenance& provenance, const std::vector<BenchFigure>* figures,
                const std::vector<GoalResult>* goals);
// Replaces the table with the same id.
void keep_bench_table(const std::string& path, const Provenance& provenance, const BenchTable& table);

}  // namespace atwood
