// The worker side of the line protocol: JSON requests on standard input, JSON lines on standard output.
#pragma once

#include "protocol/fluid_field.hpp"
#include "protocol/method.hpp"
#include "protocol/pair_query.hpp"
#include "protocol/truth.hpp"

namespace atwood {

// Answers requests until standard input closes; returns the process's exit code. Output of the engine
// on standard output does not reach the protocol: the descriptor is duplicated first, then stdout refers to stderr.
//
// Besides hello and run: {"request":"contacts","cell":7,"swept":false,"scene":{...}} (swept: with "t_end_s"), answered
// by Engine::contacts, and
// {"request":"contacts-sweep","cell":7,"swept":false,"pair":"box-box","seed":42,"from":0,"count":1000}, whose poses
// (scene/pair_sweep.hpp) the worker generates. Both may have a "test" of `queries`.
int serve(const Engine& engine, const PairQueries& queries = {});
// The same for the truth: {"request":"truth","cell":7,"samples":64,"scenario":{...}} answers samples with "bars"; with
// "response":"sph{...}" the particles' own equations are solved. Questions for a field: protocol/fluid_field.hpp.
using ContactsOf = std::function<ContactAnswer(const Scene&, const ContactQuery&)>;
int serve_truth(TruthSolver solve, const std::string& version, const ContactsOf& contacts = {},
                const PairQueries& queries = {}, const FluidFieldSolver& field = {});

}  // namespace atwood
