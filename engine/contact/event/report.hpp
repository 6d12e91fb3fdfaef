// Observer and outcome of a run.
#pragma once

#include "protocol/method.hpp"
#include "protocol/sample.hpp"

namespace atwood::event {

struct Report {
  const Observer* observer = nullptr;  // of events; may be null
  Outcome outcome;                     // why the run ended, once a function has returned false
};

// Each ends the run and returns false: as unsupported or diverged at t_s, with what happened there; with the whole
// message.
bool refuse_at(Report& report, double t_s, const std::string& what);
bool diverged_at(Report& report, double t_s, const std::string& what);
bool refuse(Report& report, Status status, const std::string& reason);

}  // namespace atwood::event
