// Types shared by all folders: the plan of a run and its samples. Compute narrow, record wide: samples widen
// without loss from float up to quad, so nothing downstream is a template over the scalar.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "protocol/solver_report.hpp"

namespace atwood {

using Wide = __float128;  // arithmetic works natively; functions come from <quadmath.h> inside .cpp files

// h is derived: t_end_s / steps. Sample k is taken at t = t_end_s k / samples, k = 0..samples.
//
// With recorded frames the steps are as long as the frames were: frame k ends at frame_ends_s[k], the last one at
// t_end_s, and is taken in steps / frames equal parts. Samples are then the start and the end alone.
struct Plan {
  double t_end_s = 0;
  std::int64_t steps = 0;
  std::int64_t samples = 0;               // divides steps
  std::vector<double> frame_ends_s = {};  // empty: equal steps
};

// Where step n of the plan begins and step n - 1 ends, n = 0..steps, in the arithmetic of T. Never an accumulated sum.
template <class T> T step_begin_s(const Plan& plan, std::int64_t n) {
  if (plan.frame_ends_s.empty()) return T(plan.t_end_s) * T(n) / T(plan.steps);
  const auto frames = static_cast<std::int64_t>(plan.frame_ends_s.size());
  const std::int64_t parts = plan.steps / frames, frame = n / parts, part = n % parts;
  const T begin = frame == 0 ? T(0) : T(plan.frame_ends_s[static_cast<std::size_t>(frame - 1)]);
  if (part == 0) return begin;
  return begin + (T(plan.frame_ends_s[static_cast<std::size_t>(frame)]) - begin) * T(part) / T(parts);
}

struct BodySample {
  std::array<Wide, 3> p_m{};               // world
  std::array<Wide, 4> q_wxyz{1, 0, 0, 0};  // body to world
  std::array<Wide, 3> v_m_per_s{};         // world
  std::array<Wide, 3> w_rad_per_s{};       // body axes
};

// A contact that carries force at a sample's instant: the mean over the step that ends there, or the force itself where
// the method provides it.
struct ContactSample {
  int body_a = 0, body_b = 0;             // a < b
  std::array<double, 3> x_m{}, normal{};  // unit, from a to b
  double gap_m = 0;                       // negative: overlap
  double force_n_N = 0;                   // on b along the normal, >= 0
  std::array<double, 3> force_t_N{};      // friction on b, world axes
};
inline bool operator==(const ContactSample& a, const ContactSample& b) {  // not defaulted: Boost's odeint needs C++17
  return a.body_a == b.body_a && a.body_b == b.body_b && a.x_m == b.x_m && a.normal == b.normal && a.gap_m == b.gap_m &&
         a.force_n_N == b.force_n_N && a.force_t_N == b.force_t_N;
}

// A particle of a fluid. Positions are unwrapped in periodic directions.
struct ParticleSample {
  std::array<Wide, 3> p_m{}, v_m_per_s{};
  Wide density_kg_per_m3 = 0, pressure_Pa = 0, temperature_K = 0;
};

// A joint's coordinates (unwrapped; a quaternion with a continuous sign), rates and reaction: the force of the
// constraints alone on the child at its anchor and their torque about it, world axes. NaN: not reported.
struct JointSample {
  std::array<Wide, 4> q{};
  std::array<Wide, 3> u{};
  std::array<Wide, 3> force_N{}, torque_N_m{};
  // Bits 0 to 2: the components of force_N that the constraints leave open (over-constrained mechanisms); 3 to 5: of
  // torque_N_m.
  unsigned not_unique = 0;
  std::array<Wide, 3> applied{};  // along each rate: springs, dampers and motors [N m or N]
  // Along each rate: what the joint's stop exerts [N m or N], 0 away from it. NaN: not reported.
  std::array<Wide, 3> stop{Wide(__builtin_nan("")), Wide(__builtin_nan("")), Wide(__builtin_nan(""))};
};

struct RopeSample {
  Wide tension_N = 0;  // of the segment at the first body
  std::vector<Wide> pulley_angle_rad;
};

struct Sample {
  Wide t_s = 0;
  std::vector<BodySample> bodies;              // in the order of Scene::bodies, fixed ones included
  std::vector<ContactSample> contacts = {};    // of methods and engines that report contacts; one entry a contact point
  std::vector<ParticleSample> particles = {};  // of all fluids of the scene, in their order
  std::vector<JointSample> joints = {};        // in the order of Scene::joints; empty: not reported
  std::vector<RopeSample> ropes = {};          // in the order of Scene::ropes; empty: not reported
};

enum class EventKind { impact, rest, slip, stick, roll, separate };

struct Event {
  Wide t_s = 0;
  EventKind kind = EventKind::impact;
  int body_a = 0, body_b = 0;           // at the stop of a joint: its parent (-1: the world) and its child
  std::array<Wide, 3> x_m{}, normal{};  // contact point; unit normal from a to b
  Wide impulse_n_N_s = 0, impulse_t_N_s = 0, vn_before_m_per_s = 0, vn_after_m_per_s = 0;
};

enum class Status { ok, unsupported, diverged, not_finite, timeout, crashed, not_built };

struct Outcome {
  Status status = Status::ok;
  std::string reason;  // empty when ok
  std::int64_t steps_taken = 0;
  std::int64_t rate_evaluations = 0;
  std::vector<std::int64_t> busy_ns;  // timing pass: one per repeat, the stepping alone (no start-up, no sampling)
  std::map<std::string, SolveTally> solvers = {};  // by name: how their solves ended; empty: none, or not reported
  // Timing pass of an engine under WebAssembly: a step of a world without bodies; 0: the engine is native.
  std::int64_t call_ns = 0;
};

// A pass of its own, apart from accuracy and timing: one clock reading a step, and one a phase where the engine has
// phases.
struct Profile {
  std::vector<std::int64_t> step_ns;             // one a step of the plan
  std::map<std::string, std::int64_t> phase_ns;  // "broad", "narrow", "solve", "integrate"; empty: not reported
};

// Where samples and events go. Both empty in the timed pass.
struct Observer {
  std::function<void(const Sample&)> sample;
  std::function<void(const Event&)> event;
  Profile* profile = nullptr;  // not null: the profile pass; nothing else is observed, repeats are 0
};

std::string to_string(
    Status status);  // "ok", "unsupported", "diverged", "not finite", "timeout", "crashed", "not built"
Status status_from_string(const std::string& text);  // throws std::invalid_argument
std::string to_string(EventKind kind);
EventKind event_kind_from_string(const std::string& text);

// Text of numbers, exact both ways. digits 17: shortest round-trip double; 21: long double; 36: quad.
std::string format_number(Wide value, int digits);
std::string format_double(double value);   // shortest round-trip; "nan", "inf", "-inf"
Wide parse_wide(const std::string& text);  // throws std::invalid_argument

}  // namespace atwood
