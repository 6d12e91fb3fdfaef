// The outcome of a run that is refused before its first step.
#pragma once

#include <string>

#include "protocol/fault.hpp"
#include "protocol/sample.hpp"

namespace atwood {

inline Outcome refused(const std::string& reason) {
  Outcome outcome;
  outcome.status = Status::unsupported;
  outcome.reason = reason;
  return outcome;
}
inline Outcome refused(const Fault& fault) { return refused(fault.reason); }

// The same of an answer that holds an outcome: a truth, a field, contacts.
template <class Answer> Answer refused(const std::string& reason) {
  Answer answer;
  answer.outcome = refused(reason);
  return answer;
}

}  // namespace atwood
