// Runs the benchmark programs: those of Google Benchmark, and the comparison of broad phases.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "benchmarks/calmest.hpp"
#include "benchmarks/figures.hpp"

namespace atwood {

// Paths of the executables atwood-bench-* in this folder, sorted.
std::vector<std::string> benchmark_programs(const std::string& bin_dir);

// Those of them that have a benchmark whose name the filter matches (a POSIX extended regular expression; empty: all).
// std::regex_error where it is none, std::runtime_error where a program fails.
std::vector<std::string> benchmark_programs(const std::string& bin_dir, const std::string& filter);

// Five repetitions of every benchmark of these programs whose name the filter matches, program after program; each must
// have one. `notice` is called with each program's name. std::runtime_error where one fails.
std::vector<BenchFigure> run_benchmarks(const std::vector<std::string>& programs, const std::string& filter,
                                        const std::function<void(const std::string&)>& notice);

// The same, and what else ran on the machine meanwhile, in timings of kTimingS of the benchmarks' processor time. Taken
// again while it was busy (calmest.hpp).
inline constexpr double kTimingS = 0.02;  // the least duration of a repetition
Measured<std::vector<BenchFigure>> calmest_benchmarks(const std::string& bin_dir, const std::string& filter);

// The tables that atwood-broad-phases prints. InputError where it is not built.
std::vector<BenchTable> measure_broad_phases(const std::string& bin_dir);

}  // namespace atwood
