// bench.json: figures, goals and tables, as `atwood bench` keeps them and every report shows them.
#pragma once

#include <string>
#include <vector>

#include "benchmarks/figures.hpp"
#include "validation/row.hpp"

namespace atwood {

std::string read_bench_text(const std::string& path);  // of a bench.json; empty: there is none
std::vector<BenchFigure> read_bench(const std::string& path);
std::vector<GoalResult> read_goal_results(const std::string& path);
std::vector<BenchTable> read_bench_tables(const std::string& path);

// Tables as a program prints them and as bench.json holds them: {"tables": [...]}.
std::vector<BenchTable> bench_tables_from(const std::string& text);
std::string bench_tables_json(const std::vector<BenchTable>& tables);

// Null: what the file has stays.
void keep_bench(const std::string& path, const Provenance& provenance, const std::vector<BenchFigure>* figures,
                const std::vector<GoalResult>* goals);
// In place of that id's last one.
void keep_bench_table(const std::string& path, const Provenance& provenance, const BenchTable& table);

}  // namespace atwood
