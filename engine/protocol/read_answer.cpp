// A line of an answer, read element by element: what a line of many bodies, contacts or events costs is what they hold,
// and a line that holds more than was asked for ends where it does.
#include <array>
#include <cmath>

#include "protocol/joint_lines.hpp"
#include "protocol/json_lines.hpp"

namespace atwood::wire {
namespace {

constexpr std::size_t kMaxPhases = 64, kMaxSolvers = 64, kLongestSolver = 64;

std::array<Wide, 3> read_three(const Json& values, std::size_t at) {
  return {number(values[at]), number(values[at + 1]), number(values[at + 2])};
}

void refuse_beyond(std::size_t size, std::size_t most, const char* what) {
  if (size >= most) throw Garbage("more than " + std::to_string(most) + " " + what + " in a line");
}

// [px,py,pz,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz]
void read_body(const Json& values, std::vector<BodySample>& bodies) {
  array(values, "body", 13);
  BodySample& body = bodies.emplace_back();
  body.p_m = read_three(values, 0);
  for (std::size_t i = 0; i < 4; ++i) body.q_wxyz[i] = number(values[3 + i]);
  body.v_m_per_s = read_three(values, 7);
  body.w_rad_per_s = read_three(values, 10);
}

// [px,py,pz,vx,vy,vz,density,pressure,temperature]
void read_particle(const Json& values, std::vector<ParticleSample>& particles) {
  array(values, "particle", 9);
  ParticleSample& particle = particles.emplace_back();
  particle.p_m = read_three(values, 0);
  particle.v_m_per_s = read_three(values, 3);
  particle.density_kg_per_m3 = number(values[6]);
  particle.pressure_Pa = number(values[7]);
  particle.temperature_K = number(values[8]);
}

// [a,b,x,y,z,nx,ny,nz,gap_m,force_n_N,force_t_N(3)]
void read_contact(const Json& values, std::vector<ContactSample>& contacts) {
  array(values, "contact", 13);
  ContactSample& contact = contacts.emplace_back();
  contact.body_a = index(values[0], "body_a");
  contact.body_b = index(values[1], "body_b");
  for (std::size_t i = 0; i < 3; ++i) {
    contact.x_m[i] = narrow_number(values[2 + i]);
    contact.normal[i] = narrow_number(values[5 + i]);
    contact.force_t_N[i] = narrow_number(values[10 + i]);
  }
  contact.gap_m = narrow_number(values[8]);
  contact.force_n_N = narrow_number(values[9]);
}

void read_event(const Json& each, Answer& answer) {
  if (!each.is_object()) throw Garbage("an event is not an object: " + excerpt(each));
  Event event;
  event.t_s = number(need(each, "t_s"));
  const std::string kind = text_or(each, "kind", "impact");
  try {
    event.kind = event_kind_from_string(kind);
  } catch (const std::invalid_argument&) {
    throw Garbage("unknown kind of event `" + cut(kind) + "`");
  }
  event.body_a = index(need(each, "body_a"), "body_a");
  event.body_b = index(need(each, "body_b"), "body_b");
  if (each.contains("x_m")) event.x_m = read_three(array(each["x_m"], "x_m", 3), 0);
  if (each.contains("normal")) event.normal = read_three(array(each["normal"], "normal", 3), 0);
  const auto field = [&](const char* key, Wide& value) {
    if (each.contains(key)) value = number(each[key]);
  };
  field("impulse_n_N_s", event.impulse_n_N_s);
  field("impulse_t_N_s", event.impulse_t_N_s);
  field("vn_before_m_per_s", event.vn_before_m_per_s);
  field("vn_after_m_per_s", event.vn_after_m_per_s);
  answer.events.push_back(event);
  answer.event_bar_s.push_back(each.contains("bar_s") ? narrow_number(each["bar_s"]) : 0);
}

// ---- contacts of a scene, poses -----------------------------------------------------------------------------------
void read_found_contact(const Json& v, Answer& answer) {
  array(v, "contact", 9);
  answer.contacts.push_back(
      {index(v[0], "body"), index(v[1], "body"), read_three(v, 2), read_three(v, 5), number(v[8])});
}

void read_touch(const Json& v, Answer& answer) {
  array(v, "touch", 9);
  answer.touches.push_back(
      {index(v[0], "body"), index(v[1], "body"), number(v[2]), read_three(v, 3), read_three(v, 6)});
}

void read_pose(const Json& v, Answer& answer) {
  array(v, "pose", 12);
  PoseAnswer& pose = answer.poses.emplace_back();
  pose.hit = integer(v[0], "hit") != 0;
  pose.gap_m = narrow_number(v[1]);
  pose.toi_s = narrow_number(v[2]);
  for (std::size_t i = 0; i < 3; ++i) pose.normal[i] = narrow_number(v[3 + i]), pose.x_m[i] = narrow_number(v[6 + i]);
  pose.points = index(v[9], "points");
  pose.bar = narrow_number(v[10]);
  pose.margin_m = narrow_number(v[11]);
}

// ---- the end ------------------------------------------------------------------------------------------------------
std::int64_t nanoseconds(const Json& json, const char* what) {
  if (json.is_number_float() && json.get<double>() > 0 && json.get<double>() < 1e6 &&
      std::floor(json.get<double>()) != json.get<double>())
    throw Garbage("\"" + std::string(what) + "\" is not an integer: " + excerpt(json) +
                  "; whole nanoseconds were expected: is it in seconds or milliseconds?");
  return integer(json, what);
}

// {"NAME":{"converged":n,"stagnated":n,"capped":n,"iterations_max":n,"residual_max":x},...}; counts left out are 0.
void read_solvers(const Json& solvers, Outcome& outcome) {
  if (!solvers.is_object()) throw Garbage("\"solvers\" is not an object: " + excerpt(solvers));
  if (solvers.size() > kMaxSolvers)
    throw Garbage("more than " + std::to_string(kMaxSolvers) + " solvers in \"solvers\"");
  for (const auto& [name, json] : solvers.items()) {
    const bool known = name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-") == std::string::npos;
    if (name.empty() || name.size() > kLongestSolver || !known)
      throw Garbage("a solver is named `" + cut(name) + "`; expected 1 to " + std::to_string(kLongestSolver) +
                    " lower-case letters a to z, digits and `-`");
    if (!json.is_object()) throw Garbage("solver `" + name + "` is not an object: " + excerpt(json));
    SolveTally& tally = outcome.solvers[name];
    const auto number_of = [&, &each = json](const char* key, std::int64_t& value) {
      if (each.contains(key)) value = count(each[key], key);
    };
    number_of("converged", tally.converged);
    number_of("stagnated", tally.stagnated);
    number_of("capped", tally.capped);
    number_of("iterations_max", tally.iterations_max);
    if (json.contains("residual_max")) tally.residual_max = narrow_number(json["residual_max"]);
    if (tally.residual_max < 0)
      throw Garbage("\"residual_max\" of solver `" + name + "` is negative: " + excerpt(json["residual_max"]));
  }
}

// "call_ns" of an engine that runs as WebAssembly: a step of a world without bodies, which is the call into it and what
// the engine does in any step. Native engines have none.
std::int64_t read_call_time(const Json& done) {
  if (!done.contains("call_ns")) return 0;
  const std::int64_t call_ns = nanoseconds(done["call_ns"], "call_ns");
  if (call_ns <= 0) throw Garbage("\"call_ns\" is " + std::to_string(call_ns) + "; nanoseconds above 0 were expected");
  return call_ns;
}

Outcome read_outcome(const Json& done) {
  if (!done.is_object()) throw Garbage("\"done\" is not an object: " + excerpt(done));
  Outcome outcome;
  const std::string status = text(need(done, "status"), "status");
  try {
    outcome.status = status_from_string(status);
  } catch (const std::invalid_argument&) {
    throw Garbage("unknown status `" + cut(status) + "`");
  }
  outcome.reason = text_or(done, "reason", "");
  if (done.contains("steps_taken")) outcome.steps_taken = count(done["steps_taken"], "steps_taken");
  if (done.contains("rate_evaluations")) outcome.rate_evaluations = count(done["rate_evaluations"], "rate_evaluations");
  if (done.contains("busy_ns"))
    for (const Json& each : array(done["busy_ns"], "busy_ns")) outcome.busy_ns.push_back(nanoseconds(each, "busy_ns"));
  for (const std::int64_t each : outcome.busy_ns)
    if (each < 0) throw Garbage("busy_ns has " + std::to_string(each) + "; the nanoseconds of a run are positive");
  outcome.call_ns = read_call_time(done);
  if (done.contains("solvers")) read_solvers(done["solvers"], outcome);
  return outcome;
}

Profile read_profile(const Json& done) {
  Profile profile;
  if (done.contains("step_ns"))
    for (const Json& each : array(done["step_ns"], "step_ns")) profile.step_ns.push_back(count(each, "step_ns"));
  if (!done.contains("phase_ns")) return profile;
  const Json& phases = done["phase_ns"];
  if (!phases.is_object()) throw Garbage("\"phase_ns\" is not an object: " + excerpt(phases));
  if (phases.size() > kMaxPhases) throw Garbage("more than " + std::to_string(kMaxPhases) + " phases in \"phase_ns\"");
  for (const auto& [phase, ns] : phases.items()) profile.phase_ns[cut(phase)] = count(ns, "phase_ns");
  return profile;
}

void read_done(const Json& done, Answer& answer) {
  answer.done = true;
  answer.outcome = read_outcome(done);
  answer.profile = read_profile(done);
  answer.source = text_or(done, "source", "");
  answer.note = text_or(done, "note", "");
  if (done.contains("condition")) answer.condition = narrow_number(done["condition"]);
}

// ---- the line -----------------------------------------------------------------------------------------------------
// Which members have come: what a line is follows from them.
struct Seen {
  bool cell = false, t_s = false, bodies = false, events = false, found = false;
};

Reading how_to_read(const std::string& member, Seen& seen) {
  seen.cell = seen.cell || member == "cell";
  seen.t_s = seen.t_s || member == "t_s";
  seen.bodies = seen.bodies || member == "bodies";
  seen.events = seen.events || member == "events";
  seen.found = seen.found || member == "contacts" || member == "touches" || member == "poses";
  for (const char* name : {"bodies", "bars", "particles", "particle_bars", "contacts", "touches", "poses", "events"})
    if (member == name) return Reading::by_element;
  if (is_joint_member(member)) return Reading::by_element;
  for (const char* name : {"cell", "t_s", "done", "from", "from_particle", "more"})
    if (member == name) return Reading::whole;
  return Reading::ignored;
}

void take_element(const std::string& member, const Json& value, const Limits& most, Answer& answer) {
  if (member == "bodies") {
    refuse_beyond(answer.sample.bodies.size(), most.bodies, "bodies");
    read_body(value, answer.sample.bodies);
  } else if (member == "bars") {
    refuse_beyond(answer.bar.bodies.size(), most.bodies, "bars");
    answer.has_bar = true;
    read_body(value, answer.bar.bodies);
  } else if (member == "particles") {
    refuse_beyond(answer.sample.particles.size(), most.particles, "particles");
    read_particle(value, answer.sample.particles);
  } else if (member == "particle_bars") {
    refuse_beyond(answer.bar.particles.size(), most.particles, "particle_bars");
    read_particle(value, answer.bar.particles);
  } else if (member == "contacts") {  // of a sample, or of a question for them
    refuse_beyond(answer.sample.contacts.size() + answer.contacts.size(), most.contacts, "contacts");
    if (value.is_array() && value.size() == 9) read_found_contact(value, answer);
    else read_contact(value, answer.sample.contacts);
  } else if (member == "touches") {
    refuse_beyond(answer.touches.size(), most.contacts, "touches");
    read_touch(value, answer);
  } else if (member == "poses") {
    refuse_beyond(answer.poses.size(), most.poses, "poses");
    read_pose(value, answer);
  } else {
    refuse_beyond(answer.events.size(), most.events, "events");
    read_event(value, answer);
  }
}

bool is_true(const Json& json, const char* what) {
  if (!json.is_boolean()) throw Garbage("\"" + std::string(what) + "\" must be true or false, found " + excerpt(json));
  return json.get<bool>();
}

}  // namespace

Answer read_answer(std::string_view line, const Limits& most) {
  Answer answer;
  JointMembers joints;
  Seen seen;
  read_members(
      line,
      [&](const std::string& member) {
        if (member == "bars") answer.has_bar = true;
        return how_to_read(member, seen);
      },
      [&](const std::string& member, Json& value) {
        if (member == "cell") answer.cell = integer(value, "cell");
        else if (member == "t_s") answer.sample.t_s = number(value);
        else if (member == "done") read_done(value, answer);
        else if (member == "from") answer.from = static_cast<std::size_t>(count(value, "from"));
        else if (member == "from_particle")
          answer.from_particle = static_cast<std::size_t>(count(value, "from_particle"));
        else if (member == "more") answer.more = is_true(value, "more");
        else if (is_joint_member(member)) take_joint_element(member, value, most, answer, joints);
        else take_element(member, value, most, answer);
      });
  if (!seen.cell) throw Garbage("no \"cell\" in " + cut(line));
  if (answer.done) return answer;
  if (!seen.t_s && seen.found) {
    if (!answer.sample.contacts.empty()) throw Garbage("\"contact\" is not an array of 9: an array of 13");
    return answer;
  }
  answer.events_alone = !seen.t_s && !seen.bodies && seen.events && answer.more;
  if (answer.events_alone) return answer;
  if (!seen.t_s) throw Garbage("no \"t_s\" in " + cut(line));
  if (!seen.bodies) throw Garbage("no \"bodies\" in " + cut(line));
  if (!answer.contacts.empty()) throw Garbage("\"contact\" is not an array of 13: an array of 9");
  if (answer.has_bar && answer.bar.bodies.size() != answer.sample.bodies.size())
    throw Garbage("\"bars\" and \"bodies\" differ in size");
  if (answer.has_bar ? answer.bar.particles.size() != answer.sample.particles.size() : !answer.bar.particles.empty())
    throw Garbage("\"particle_bars\" and \"particles\" differ in size");
  join_joint_members(joints, answer);
  return answer;
}

}  // namespace atwood::wire
