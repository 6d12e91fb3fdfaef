// A report that no physics made: curves with known orders, floors and growth, and every kind of trouble, so that
// documents can be tested and looked at before, and apart from, any run.
#pragma once

#include "reports/report.hpp"

namespace atwood {

struct SyntheticSize {
  int scenarios = 40, methods = 20, rungs = 10, samples = 128;
};

ReportData synthetic_report(const SyntheticSize& size);

// Five rows, five verdicts, one of everything: for the golden files. Holds every character that a format must quote.
ReportData small_report();

}  // namespace atwood
