// The lines of the worker protocol as text, both sides of it. One JSON object a line, at most 64 MiB (hello: 4 MiB),
// nested at most 64 levels deep. A sample that would make a long line is sent in parts.
//
// Numbers that a double holds exactly are JSON numbers; others (wider, or not finite) are strings.
#pragma once

#include <cstdint>
#include <functional>
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
inline constexpr std::size_t kLongestHello = std::size_t{4} << 20;
inline constexpr std::size_t kLongestPart = std::size_t{16} << 20;  // from here on a sample continues on another line

// A line that does not follow the protocol; says what was found.
struct Garbage : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// ---- requests ---------------------------------------------------------------------------------------------------
// A question for a field (protocol/fluid_field.hpp) is read in two steps: `kind` here, the rest from the line.
struct Request {
  enum class Kind { hello, run, truth, contacts, sweep, field } kind = Kind::hello;
  std::int64_t cell = -1;
  std::string method;
  Plan plan;        // truth: samples alone
  int repeats = 0;  // 0: the accuracy pass, or the profile
  bool profile = false;
  // truth: the particles' equations, as in a method id without the plus sign ("sph{...}"); empty: none
  std::string response = {};
  std::string json;            // run, contacts: the scene; truth: the scenario; field: the line itself
  ContactQuery contacts = {};  // contacts, sweep
  std::string test = {};       // contacts, sweep: one beside the engine's own; empty: its own
  std::string pair = {};       // sweep: poses from..from + count of this pair (scene/pair_sweep.hpp)
  std::uint64_t seed = 0;
  std::int64_t from = 0, count = 0;
};
// The line that a worker reads.
std::string to_line(const Request& request);
// Throws Garbage; `cell` is set as soon as it is known, so that the answer can name it.
Request read_request(std::string_view line, std::int64_t& cell);

// ---- answers ----------------------------------------------------------------------------------------------------
// The answer to hello: what the engine is, its methods and their settings.
std::string hello_line(const Engine& engine);
// Throws Garbage, also where the engine has no usable name, speaks another protocol, or lists a method that does not
// begin with its name and a slash. `run` stays empty.
Engine read_hello(std::string_view line);

std::string sample_line(std::int64_t cell, const SampleView& sample, const std::vector<Event>& events);
std::string truth_line(std::int64_t cell, const SampleView& value, const SampleView& bar);
// A sample (with its bar where that is not null) in as many lines as it takes to keep each near `longest` bytes. All
// but the last say "more":true, all but the first say with "from" which body their first row is of, and with
// "from_particle" which particle; rows of bodies come before particles, these before contacts, and events with the last
// line. Joints and ropes (protocol/joint_lines.hpp) stand on the line of the last body, all of them. Each line goes to
// `put`. `joints` are the scene's, for the number of their coordinates; null: all are padded.
using Put = std::function<void(const std::string& line)>;
void sample_lines(std::int64_t cell, const SampleView& sample, const SampleView* bar, const std::vector<Event>& events,
                  const Put& put, std::size_t longest = kLongestPart, const std::vector<Joint>* joints = nullptr);
// Lines of events alone, {"cell":7,"events":[...],"more":true}, until at most `most` are left; those stay in `events`
// (and `bar_s`, where that is not null) for the line that comes next.
void event_lines(std::int64_t cell, std::vector<Event>& events, std::vector<double>* bar_s, const Put& put,
                 std::size_t most = 20000);
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

// One line of an answer: a sample or a part of one (with its bar when it is a truth's), events alone, or the end.
struct Answer {
  std::int64_t cell = -1;
  bool done = false;
  bool more = false;          // the sample goes on in the next line
  bool events_alone = false;  // neither a sample nor the end
  std::size_t from = 0;       // the body that the first row is of
  std::size_t from_particle = 0;
  Sample sample, bar;
  bool has_bar = false;
  std::vector<Event> events;
  std::vector<double> event_bar_s;
  Outcome outcome;
  Profile profile;
  std::string source, note;  // of a truth
  double condition = 0;
  std::vector<FoundContact> contacts;
  std::vector<FoundTouch> touches;
  std::vector<PoseAnswer> poses;
  std::vector<int> joint_coordinates;  // how many coordinates each row of "joints" had
};
// What one line may hold at most; reading ends at the first row beyond it.
struct Limits {
  std::size_t bodies = std::size_t{1} << 24, contacts = std::size_t{1} << 22, poses = std::size_t{1} << 22;
  std::size_t events = 1000000, particles = std::size_t{1} << 24, joints = std::size_t{1} << 20;
};
Answer read_answer(std::string_view line, const Limits& most = {});  // throws Garbage

}  // namespace atwood::wire
