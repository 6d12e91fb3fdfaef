// Observer and outcome of a run.
#pragma once

#include "protocol/method.hpp"
#include "protocol/sample.hpp"

namespace atwood::event {

struct Report {
  const Observer* observer = nullptr;  // of events; may be null
  Outcome outcome;                     // why the run ended, once a function has returned false
};

// All three return false.
// Ends the run as unsupported: "at t = ... s WHAT".
bool refuse_at(Report& report, double t_s, const std::string& what);
// The same as diverged.
bool diverged_at(Report& report, double t_s, const std::string& what);
// Ends the run with any status and the whole message.
bool end_run(Report& report, Status status, const std::string& reason);

}  // namespace atwood::event
