// The worker side of the line protocol: JSON requests on standard input, JSON lines on standard output.
#pragma once

#include "protocol/method.hpp"
#include "protocol/truth.hpp"

namespace atwood {

// Answers requests until standard input closes; returns the process's exit code. The engine's own chatter on standard
// output is kept off the protocol's pipe (the real one is duplicated first, then stdout points to stderr).
int serve(const Engine& engine);
// The same for the truth: {"request":"truth","cell":7,"samples":64,"scenario":{...}} answers samples with "bars".
int serve_truth(TruthSolver solve, const std::string& version);

}  // namespace atwood
