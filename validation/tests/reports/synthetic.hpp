// Reports without physics: curves with known orders, floors and growth, and failures of every kind, so that documents
// can be tested without a run.
#pragma once

#include "reports/report.hpp"

namespace atwood {

struct SyntheticSize {
  int scenarios = 40, methods = 20, rungs = 10, samples = 128;
};

ReportData synthetic_report(const SyntheticSize& size);

// A verdict of a gate `within` [low, high] on a value with a bar of 0.02.
Verdict verdict(const std::string& scenario, const std::string& method, const std::string& metric, Judgement judgement,
                double value, double low, double high);

// Five rows, five verdicts, one of everything else, for the golden files. It contains every character that a format
// must quote.
ReportData small_report();

}  // namespace atwood
