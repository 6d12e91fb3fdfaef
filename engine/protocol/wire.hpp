// The lines of the worker protocol as text, both sides of it. One JSON object a line, at most 64 MiB.
//
// Numbers that a double holds exactly are JSON numbers; others (wider, or not finite) are strings.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/method.hpp"
#include "protocol/pair_query.hpp"
#include "protocol/truth.hpp"

namespace atwood::wire {

inline constexpr int kProtocol = 1;
inline constexpr std::size_t kLongestLine = std::size_t{64} << 20;

// A line that does not follow the protocol; says what was found.
struct Garbage : std::runtime_error { using std::runtime_error::runtime_error; };

// ---- requests ---------------------------------------------------------------------------------------------------
struct Request {
  enum class Kind { hello, run, truth, contacts, sweep } kind = Kind::hello;
  std::int64_t cell = -1;
  std::string method;
  Plan plan;           // truth: samples alone
  int repeats = 0;     // 0: the accuracy pass, or the profile
  bool profile = false;
  std::string json;    // run, contacts: the scene; truth: the scenario
  ContactQuery contacts = {};   // contacts, sweep
  std::string test = {};        // contacts, sweep: one beside the engine's own; empty: its own
  std::string pair = {};        // sweep: poses from..from + count of this pair (scene/pair_sweep.hpp)
  std::uint64_t seed = 0;
  std::int64_t from = 0, count = 0;
};
std::string to_line(const Request& request);
// Throws Garbage; `cell` is set as soon as it is known, so that the answer can name it.
Request read_request(std::string_view line, std::int64_t& cell);

// ---- answers ----------------------------------------------------------------------------------------------------
std::string hello_line(const Engine& engine);
Engine read_hello(std::string_view line);  // throws Garbage; `run` stays empty

std::string sample_line(std::int64_t cell, const Sample& sample, const std::vector<Event>& events);
std::string truth_line(std::int64_t cell, const Sample& value, const Sample& bar);
// Events that no sample follows come with it; of a profile pass, the time of every step and of each phase:
// "step_ns":[...], "phase_ns":{"broad":...}.
std::string done_line(std::int64_t cell, const Outcome& outcome, const std::vector<Event>& events,
                      const Profile& profile = {});
std::string truth_done_line(std::int64_t cell, const Truth& truth);
// {"cell":7,"contacts":[[a,b,x,y,z,nx,ny,nz,depth],...]}, or "touches":[[a,b,toi,x,y,z,nx,ny,nz],...]
std::string contacts_line(std::int64_t cell, const ContactAnswer& answer, bool swept);
// {"cell":7,"poses":[[hit,gap,toi,nx,ny,nz,x,y,z,points,bar,margin],...]}
std::string poses_line(std::int64_t cell, const std::vector<PoseAnswer>& poses);
// The answer to a request that cannot be read.
std::string error_line(std::int64_t cell, const std::string& what);

// One line of an answer: a sample (with its bar when it is a truth's), or the end.
struct Answer {
  std::int64_t cell = -1;
  bool done = false;
  Sample sample, bar;
  bool has_bar = false;
  std::vector<Event> events;
  std::vector<double> event_bar_s;
  Outcome outcome;
  Profile profile;
  std::string source, note;   // of a truth
  double condition = 0;
  std::vector<FoundContact> contacts;
  std::vector<FoundTouch> touches;
  std::vector<PoseAnswer> poses;
};
Answer read_answer(std::string_view line);  // throws Garbage

}  // namespace atwood::wire
