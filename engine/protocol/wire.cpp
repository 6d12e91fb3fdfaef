#include "protocol/wire.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "protocol/joint_lines.hpp"
#include "protocol/json_lines.hpp"

namespace atwood::wire {
namespace {

// ---- numbers ----------------------------------------------------------------------------------------------------
template <class Values> void append_all(std::string& line, const Values& values) {
  for (const Wide value : values) {
    append(line, value);
    line += ',';
  }
}

// ---- samples ------------------------------------------------------------------------------------------------------
// Written as text, not as a tree of nlohmann-json: a line is cut at a length, which a tree shows only once it is
// written. (A sample of 1000 bodies through a tree takes 1.1 times as long.)
// [px,py,pz,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz],
void append_body(std::string& line, const BodySample& body) {
  line += '[';
  append_all(line, body.p_m);
  append_all(line, body.q_wxyz);
  append_all(line, body.v_m_per_s);
  append_all(line, body.w_rad_per_s);
  line.back() = ']';
  line += ',';
}

// [a,b,x,y,z,nx,ny,nz,gap_m,force_n_N,force_t_N(3)],
void append_contact(std::string& line, const ContactSample& contact) {
  line += '[' + std::to_string(contact.body_a) + ',' + std::to_string(contact.body_b) + ',';
  append_all(line, contact.x_m);
  append_all(line, contact.normal);
  append_all(line, std::array{contact.gap_m, contact.force_n_N});
  append_all(line, contact.force_t_N);
  line.back() = ']';
  line += ',';
}

// [px,py,pz,vx,vy,vz,density,pressure,temperature],
void append_particle(std::string& line, const ParticleSample& particle) {
  line += '[';
  append_all(line, particle.p_m);
  append_all(line, particle.v_m_per_s);
  append_all(line, std::array{particle.density_kg_per_m3, particle.pressure_Pa, particle.temperature_K});
  line.back() = ']';
  line += ',';
}

// The end of an array of elements that each end in a comma.
void close_array(std::string& line) {
  if (line.back() == ',') line.back() = ']';
  else line += ']';
}

// ---- events -------------------------------------------------------------------------------------------------------
void append_event(std::string& line, const Event& event) {
  const auto field = [&](const char* key, Wide value) {
    line += ",\"" + std::string(key) + "\":";
    append(line, value);
  };
  const auto vector = [&](const char* key, const std::array<Wide, 3>& value) {
    line += ",\"" + std::string(key) + "\":[";
    append_all(line, value);
    line.back() = ']';
  };
  line += "{\"kind\":\"" + to_string(event.kind) + "\"";
  field("t_s", event.t_s);
  line += ",\"body_a\":" + std::to_string(event.body_a) + ",\"body_b\":" + std::to_string(event.body_b);
  vector("x_m", event.x_m);
  vector("normal", event.normal);
  field("impulse_n_N_s", event.impulse_n_N_s);
  field("impulse_t_N_s", event.impulse_t_N_s);
  field("vn_before_m_per_s", event.vn_before_m_per_s);
  field("vn_after_m_per_s", event.vn_after_m_per_s);
}

void append_events(std::string& line, const std::vector<Event>& events, const std::vector<double>& bar_s = {}) {
  if (events.empty()) return;
  line += ",\"events\":[";
  for (std::size_t i = 0; i < events.size(); ++i) {
    append_event(line, events[i]);
    if (i < bar_s.size()) {
      line += ",\"bar_s\":";
      append(line, bar_s[i]);
    }
    line += "},";
  }
  line.back() = ']';
}

// ---- contacts -----------------------------------------------------------------------------------------------------
std::uint64_t seed_of(const Json& json) {
  if (json.is_number_unsigned()) return json.get<std::uint64_t>();
  return static_cast<std::uint64_t>(integer(json, "seed"));
}

void read_contacts_request(const Json& json, const std::string& kind, Request& request) {
  const Json& swept = need(json, "swept");
  if (!swept.is_boolean()) throw Garbage("\"swept\" must be true or false");
  request.contacts.swept = swept.get<bool>();
  request.test = text_or(json, "test", "");
  if (kind == "contacts") {
    request.kind = Request::Kind::contacts;
    if (request.contacts.swept) request.contacts.t_end_s = narrow_number(need(json, "t_end_s"));
    if (request.contacts.swept && !(request.contacts.t_end_s > 0)) throw Garbage("\"t_end_s\" must be positive");
    request.json = need(json, "scene").dump();
    return;
  }
  request.kind = Request::Kind::sweep;
  request.pair = text(need(json, "pair"), "pair");
  request.seed = seed_of(need(json, "seed"));
  request.from = integer(need(json, "from"), "from");
  request.count = integer(need(json, "count"), "count");
  if (request.from < 0 || request.count < 0) throw Garbage("\"from\" and \"count\" must not be negative");
}

// ---- outcomes -----------------------------------------------------------------------------------------------------
Json outcome_json(const Outcome& outcome) {
  Json done{{"status", to_string(outcome.status)},
            {"reason", outcome.reason},
            {"steps_taken", outcome.steps_taken},
            {"rate_evaluations", outcome.rate_evaluations}};
  if (!outcome.busy_ns.empty()) done["busy_ns"] = outcome.busy_ns;
  if (outcome.call_ns > 0) done["call_ns"] = outcome.call_ns;
  for (const auto& [solver, tally] : outcome.solvers)
    done["solvers"][solver] = {{"converged", tally.converged},
                               {"stagnated", tally.stagnated},
                               {"capped", tally.capped},
                               {"iterations_max", tally.iterations_max},
                               {"residual_max", json_number(tally.residual_max)}};
  return done;
}

std::string head(std::int64_t cell) { return "{\"cell\":" + std::to_string(cell); }

}  // namespace

// ---- requests -----------------------------------------------------------------------------------------------------
namespace {

std::string contacts_request(const Request& request) {
  const bool sweep = request.kind == Request::Kind::sweep;
  Json json{{"request", sweep ? "contacts-sweep" : "contacts"}, {"cell", request.cell}};
  if (!request.test.empty()) json["test"] = request.test;
  json["swept"] = request.contacts.swept;
  if (!sweep) {
    json["t_end_s"] = request.contacts.t_end_s;
    return with_document(json, "scene", request.json);
  }
  json["pair"] = request.pair;
  json["seed"] = request.seed;
  json["from"] = request.from;
  json["count"] = request.count;
  return dump(json);
}

std::string truth_request(const Request& request) {
  Json json{{"request", "truth"}, {"cell", request.cell}, {"samples", request.plan.samples}};
  if (!request.response.empty()) json["response"] = request.response;
  return with_document(json, "scenario", request.json);
}

std::string run_request(const Request& request) {
  const char* pass = request.repeats > 0 ? "timing" : request.profile ? "profile" : "accuracy";
  Json json{{"request", "run"},
            {"cell", request.cell},
            {"method", request.method},
            {"pass", pass},
            {"t_end_s", request.plan.t_end_s},
            {"steps", request.plan.steps},
            {"samples", request.plan.samples},
            {"repeats", request.repeats}};
  if (!request.plan.frame_ends_s.empty()) json["frame_ends_s"] = request.plan.frame_ends_s;
  return with_document(json, "scene", request.json);
}

}  // namespace

std::string to_line(const Request& request) {
  switch (request.kind) {
    case Request::Kind::hello: return dump({{"protocol", kProtocol}, {"request", "hello"}});
    case Request::Kind::truth: return truth_request(request);
    case Request::Kind::contacts:
    case Request::Kind::sweep: return contacts_request(request);
    default: return run_request(request);
  }
}

void read_frames(const Json& json, Plan& plan) {
  for (const Json& each : array(json, "frame_ends_s")) plan.frame_ends_s.push_back(narrow_number(each));
  const std::vector<double>& ends = plan.frame_ends_s;
  bool grows = !ends.empty() && ends.front() > 0 && ends.back() == plan.t_end_s;
  for (std::size_t i = 1; i < ends.size(); ++i) grows = grows && ends[i] > ends[i - 1];
  if (!grows) throw Garbage("\"frame_ends_s\" must grow from above 0 to t_end_s");
  if (plan.steps % static_cast<std::int64_t>(ends.size()) != 0)
    throw Garbage("\"steps\" must be a multiple of the frames");
}

Request read_request(std::string_view line, std::int64_t& cell) {
  const Json json = parse(line);
  Request request;
  if (json.contains("cell")) request.cell = cell = integer(json["cell"], "cell");
  const std::string kind = text(need(json, "request"), "request");
  if (kind == "hello") {
    if (json.contains("protocol")) check_protocol(json["protocol"], "this worker");
    return request;
  }
  need(json, "cell");
  if (kind == "contacts" || kind == "contacts-sweep") {
    read_contacts_request(json, kind, request);
    return request;
  }
  if (kind == "fluid-field") {
    request.kind = Request::Kind::field;
    request.json = line;
    return request;
  }
  request.plan.samples = integer(need(json, "samples"), "samples");
  if (request.plan.samples <= 0) throw Garbage("\"samples\" must be positive");
  if (kind == "truth") {
    request.kind = Request::Kind::truth;
    request.json = need(json, "scenario").dump();
    request.response = text_or(json, "response", "");
    return request;
  }
  if (kind != "run")
    throw Garbage("unknown request `" + cut(kind) +
                  "`; expected hello, run, truth, fluid-field, contacts or contacts-sweep");
  request.kind = Request::Kind::run;
  request.method = text(need(json, "method"), "method");
  request.plan.t_end_s = narrow_number(need(json, "t_end_s"));
  request.plan.steps = integer(need(json, "steps"), "steps");
  if (!(request.plan.t_end_s > 0) || !std::isfinite(request.plan.t_end_s))
    throw Garbage("\"t_end_s\" must be positive");
  if (request.plan.steps <= 0) throw Garbage("\"steps\" must be positive");
  if (request.plan.steps % request.plan.samples != 0) throw Garbage("\"samples\" must divide \"steps\"");
  if (json.contains("frame_ends_s")) read_frames(json["frame_ends_s"], request.plan);
  const std::string pass = text_or(json, "pass", "accuracy");
  if (pass != "accuracy" && pass != "timing" && pass != "profile") {
    throw Garbage("unknown pass `" + cut(pass) + "`; expected accuracy, timing or profile");
  }
  request.profile = pass == "profile";
  if (pass == "timing") {
    const std::int64_t repeats = json.contains("repeats") ? integer(json["repeats"], "repeats") : 1;
    if (repeats < 1 || repeats > 1000000) throw Garbage("\"repeats\" must be positive");
    request.repeats = static_cast<int>(repeats);
  }
  request.json = need(json, "scene").dump();
  return request;
}

// ---- answers ------------------------------------------------------------------------------------------------------
namespace {

// "particles":[...], with "particle_bars", from `particle` on: at least one, until the line has `longest` bytes.
void append_particles(std::string& line, const SampleView& sample, const SampleView* bar, std::size_t& particle,
                      std::size_t longest) {
  std::string bars;
  line += ",\"particles\":[";
  do {
    append_particle(line, sample.particles[particle]);
    if (bar) append_particle(bars, checked(bar->particles, particle));
    ++particle;
  } while (particle < sample.particles.size() && line.size() + bars.size() < longest);
  close_array(line);
  if (!bar) return;
  line += ",\"particle_bars\":[" + bars;
  close_array(line);
}

}  // namespace

void sample_lines(std::int64_t cell, const SampleView& sample, const SampleView* bar, const std::vector<Event>& events,
                  const Put& put, std::size_t longest, const std::vector<Joint>* joints) {
  bool joints_sent = false;
  std::size_t body = 0, particle = 0, contact = 0;
  for (bool more = true; more;) {
    std::string line = head(cell) + ",\"t_s\":", bars;
    append(line, sample.t_s);
    if (body > 0) line += ",\"from\":" + std::to_string(body);
    if (particle > 0) line += ",\"from_particle\":" + std::to_string(particle);
    const std::size_t first_body = body;
    line += ",\"bodies\":[";
    for (; body < sample.bodies.size() && line.size() + bars.size() < longest; ++body) {
      append_body(line, sample.bodies[body]);
      if (bar) append_body(bars, checked(bar->bodies, body));
    }
    close_array(line);
    if (bar) {
      line += ",\"bars\":[" + bars;
      close_array(line);
    }
    if (body == sample.bodies.size() && !joints_sent) {
      append_joints(line, sample, bar, joints);
      joints_sent = true;
    }
    bool progress = body > first_body;
    if (body == sample.bodies.size() && particle < sample.particles.size() && (line.size() < longest || !progress)) {
      append_particles(line, sample, bar, particle, longest);
      progress = true;
    }
    const bool contacts_begin =
        body == sample.bodies.size() && particle == sample.particles.size() && contact < sample.contacts.size();
    if (contacts_begin && (line.size() < longest || !progress)) {
      line += ",\"contacts\":[";
      do append_contact(line, sample.contacts[contact++]);
      while (contact < sample.contacts.size() && line.size() < longest);
      close_array(line);
    }
    more = body < sample.bodies.size() || particle < sample.particles.size() || contact < sample.contacts.size();
    if (more) line += ",\"more\":true";
    else append_events(line, events);
    put(line + "}");
  }
}

namespace {

std::string one_line(std::int64_t cell, const SampleView& sample, const SampleView* bar,
                     const std::vector<Event>& events) {
  std::string only;
  sample_lines(
      cell, sample, bar, events, [&](const std::string& line) { only = line; }, std::string::npos);
  return only;
}

}  // namespace

std::string sample_line(std::int64_t cell, const SampleView& sample, const std::vector<Event>& events) {
  return one_line(cell, sample, nullptr, events);
}

std::string truth_line(std::int64_t cell, const SampleView& value, const SampleView& bar) {
  return one_line(cell, value, &bar, {});
}

void event_lines(std::int64_t cell, std::vector<Event>& events, std::vector<double>* bar_s, const Put& put,
                 std::size_t most) {
  std::size_t sent = 0;
  while (events.size() - sent > most) {
    const auto part = [&](const auto& values) {
      const auto begin = values.begin() + static_cast<std::ptrdiff_t>(std::min(sent, values.size()));
      const auto end = values.begin() + static_cast<std::ptrdiff_t>(std::min(sent + most, values.size()));
      return std::vector(begin, end);
    };
    std::string line = head(cell);
    append_events(line, part(events), bar_s ? part(*bar_s) : std::vector<double>{});
    put(line + ",\"more\":true}");
    sent += most;
  }
  events.erase(events.begin(), events.begin() + static_cast<std::ptrdiff_t>(sent));
  if (bar_s) bar_s->erase(bar_s->begin(), bar_s->begin() + static_cast<std::ptrdiff_t>(std::min(sent, bar_s->size())));
}

std::string done_line(std::int64_t cell, const Outcome& outcome, const std::vector<Event>& events,
                      const Profile& profile) {
  Json done = outcome_json(outcome);
  if (!profile.step_ns.empty()) done["step_ns"] = profile.step_ns;
  if (!profile.phase_ns.empty()) done["phase_ns"] = profile.phase_ns;
  std::string line = head(cell) + ",\"done\":" + dump(done);
  append_events(line, events);
  return line + "}";
}

std::string truth_done_line(std::int64_t cell, const Truth& truth) {
  Json done = outcome_json(truth.outcome);
  done["source"] = truth.source;
  done["condition"] = json_number(truth.condition);
  done["note"] = truth.note;
  std::string line = head(cell) + ",\"done\":" + dump(done);
  append_events(line, truth.events, truth.event_bar_s);
  return line + "}";
}

std::string contacts_line(std::int64_t cell, const ContactAnswer& answer, bool swept) {
  std::string line = head(cell) + (swept ? ",\"touches\":[" : ",\"contacts\":[");
  const auto row = [&](int a, int b, const auto&... values) {
    line += "[" + std::to_string(a) + "," + std::to_string(b) + ",";
    (append_all(line, values), ...);
    line.back() = ']';
    line += ',';
  };
  using One = std::array<Wide, 1>;
  if (swept)
    for (const FoundTouch& t : answer.touches) row(t.body_a, t.body_b, One{t.toi_s}, t.x_m, t.normal);
  else
    for (const FoundContact& c : answer.contacts) row(c.body_a, c.body_b, c.x_m, c.normal, One{c.depth_m});
  if (line.back() == ',') line.pop_back();
  return line + "]}";
}

std::string poses_line(std::int64_t cell, const std::vector<PoseAnswer>& poses) {
  std::string line = head(cell) + ",\"poses\":[";
  for (const PoseAnswer& pose : poses) {
    line += pose.hit ? "[1," : "[0,";
    append_all(line, std::array{pose.gap_m, pose.toi_s});
    append_all(line, pose.normal);
    append_all(line, pose.x_m);
    line += std::to_string(pose.points) + ",";
    append_all(line, std::array{pose.bar, pose.margin_m});
    line.back() = ']';
    line += ',';
  }
  if (line.back() == ',') line.pop_back();
  return line + "]}";
}

std::string error_line(std::int64_t cell, const std::string& what) {
  const Json done{{"status", "crashed"}, {"reason", "bad request: " + what}};
  return head(cell) + ",\"error\":" + dump(Json(what)) + ",\"done\":" + dump(done) + "}";
}

}  // namespace atwood::wire
