// The exact field of a fluid at positions that are asked for, and the lines that ask and answer.
//
// A particle method has its own positions, so a truth of a field is a function of time and place, not a list of
// samples:
//
//   -> {"request":"fluid-field","cell":7,"response":"sph{viscosity=morris}","scenario":{...},
//       "t_s":[0,0.5],"positions":[[[x,y,z],...],[[x,y,z],...]]}
//   <- {"cell":7,"field_t_s":0,"values":[[vx,vy,vz,density,pressure,temperature],...],"bars":[[...],...],
//       "probes":[null,[value,bar],...]}
//   <- {"cell":7,"field_t_s":0.5,"from":0,"values":[...],"bars":[...],"more":true}
//   <- {"cell":7,"field_t_s":0.5,"from":50000,"values":[...],"bars":[...],"probes":[...]}
//   <- {"cell":7,"done":{"status":"ok","reason":"","source":"...","note":"...","known":["velocity","pressure"]}}
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/sample.hpp"
#include "protocol/wire.hpp"
#include "scene/scene.hpp"

namespace atwood {

using FieldPosition = std::array<Wide, 3>;  // [m], wrapped or unwrapped in periodic directions; z = 0 in two dimensions

// Which quantities a field has. The values of the others are 0 with the bar 0 and mean nothing.
struct FieldKnown {
  bool velocity = false, pressure = false, density = false, temperature = false;
};

// A probe's exact value where the field's own formulas give one (the front of a dam break, the height of a column).
struct ProbeValue {
  Wide value = 0, bar = 0;
};

// The field at one time. `values` and `bars` have one entry a position, in their order; p_m is the position asked for,
// with the bar 0. A bar is the half-width of each component: round-off, remainders of series and, where a formula
// neglects something (a finite amplitude), an estimate of it. A bar that is infinite: a comparison without a bound.
struct FieldSample {
  Wide t_s = 0;
  std::vector<ParticleSample> values, bars;
  std::vector<std::optional<ProbeValue>> probes;  // one a probe of the scene
};

// A field as a function. `outcome` not ok: the scenario's truth has no field, and why; `at` is then empty.
struct FluidField {
  Outcome outcome;
  std::string source;  // the citation
  std::string note;    // what the bars do not bound, or under which condition they hold; may be empty
  FieldKnown known;
  // Throws std::invalid_argument with the time and the reason where there is no field at t_s.
  std::function<FieldSample(Wide t_s, const std::vector<FieldPosition>& positions)> at;
};

// `response`: the particles' equations as in a method id, with their settings and without the plus sign
// ("sph{viscosity=morris}"): it decides the viscous term of a compressible field. Empty: nu lap u.
using FluidFieldSolver = std::function<FluidField(const Scenario&, const std::string& response)>;

namespace wire {

struct FieldRequest {
  std::int64_t cell = -1;
  std::string response;
  std::string scenario;  // JSON
  std::vector<Wide> t_s;
  std::vector<std::vector<FieldPosition>> positions;  // one list a time
};
std::string to_line(const FieldRequest& request);
FieldRequest read_field_request(std::string_view line);  // throws Garbage

// One time's field in as many lines as keep each near `longest` bytes.
void field_lines(std::int64_t cell, const FieldSample& field, const Put& put, std::size_t longest = kLongestPart);
std::string field_done_line(std::int64_t cell, const FluidField& field);

// One line of an answer. `sample` has the rows from `from` on; their positions are the asker's, and p_m is 0.
struct FieldAnswer {
  std::int64_t cell = -1;
  bool done = false, more = false;
  std::size_t from = 0;
  FieldSample sample;
  FluidField ended;  // done: outcome, source, note, known
};
FieldAnswer read_field_answer(std::string_view line, std::size_t most = std::size_t{1} << 24);  // throws Garbage

}  // namespace wire
}  // namespace atwood
