#include "protocol/wire.hpp"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

namespace atwood::wire {
namespace {

using Json = nlohmann::ordered_json;

// ---- numbers ----------------------------------------------------------------------------------------------------
void append(std::string& line, Wide value) {
  const double narrow = static_cast<double>(value);
  if (static_cast<Wide>(narrow) == value && std::isfinite(narrow)) {
    line += format_double(narrow);
    return;
  }
  const long double longer = static_cast<long double>(value);
  line += '"';
  line += format_number(value, static_cast<Wide>(longer) == value ? 21 : 36);
  line += '"';
}

template <class Values>
void append_all(std::string& line, const Values& values) {
  for (const Wide value : values) {
    append(line, value);
    line += ',';
  }
}

Wide number(const Json& json) {
  if (json.is_number()) return json.get<double>();
  if (!json.is_string()) throw Garbage("a number or its text was expected, found " + std::string(json.type_name()));
  try {
    return parse_wide(json.get_ref<const std::string&>());
  } catch (const std::invalid_argument& error) {
    throw Garbage(error.what());
  }
}

double narrow_number(const Json& json) { return static_cast<double>(number(json)); }

Json json_number(double value) { return std::isfinite(value) ? Json(value) : Json(format_double(value)); }

// ---- reading without surprises ------------------------------------------------------------------------------------
Json parse(std::string_view line) {
  Json json = Json::parse(line, nullptr, false);
  if (json.is_discarded() || !json.is_object()) {
    throw Garbage("not a JSON object: " + std::string(line.substr(0, 120)) + (line.size() > 120 ? "..." : ""));
  }
  return json;
}

const Json& need(const Json& json, const char* key) {
  const auto found = json.find(key);
  if (found == json.end()) throw Garbage("no \"" + std::string(key) + "\" in " + json.dump().substr(0, 120));
  return *found;
}

// Integers also come as 10.0 from languages that know one kind of number.
std::int64_t integer(const Json& json, const char* what) {
  if (json.is_number_integer()) return json.get<std::int64_t>();
  if (json.is_number() && std::floor(json.get<double>()) == json.get<double>() &&
      std::fabs(json.get<double>()) < 9e15) {
    return static_cast<std::int64_t>(json.get<double>());
  }
  throw Garbage("\"" + std::string(what) + "\" is not an integer: " + json.dump().substr(0, 60));
}

std::string text(const Json& json, const char* what) {
  if (!json.is_string()) throw Garbage("\"" + std::string(what) + "\" is not a string: " + json.dump().substr(0, 60));
  return json.get<std::string>();
}

std::string text_or(const Json& json, const char* key, const std::string& otherwise) {
  return json.contains(key) ? text(json[key], key) : otherwise;
}

const Json& array(const Json& json, const char* what, std::size_t size = 0) {
  if (!json.is_array() || (size > 0 && json.size() != size)) {
    throw Garbage("\"" + std::string(what) + "\" is not an array" + (size > 0 ? " of " + std::to_string(size) : "") +
                  ": " + json.dump().substr(0, 60));
  }
  return json;
}

// nlohmann throws on text that is not UTF-8; replace such bytes instead.
std::string dump(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

// ---- samples ------------------------------------------------------------------------------------------------------
// [[px,py,pz,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz],...]
void append_bodies(std::string& line, const Sample& sample) {
  line += '[';
  for (const BodySample& body : sample.bodies) {
    line += '[';
    append_all(line, body.p_m);
    append_all(line, body.q_wxyz);
    append_all(line, body.v_m_per_s);
    append_all(line, body.w_rad_per_s);
    line.back() = ']';
    line += ',';
  }
  if (line.back() == ',') line.pop_back();
  line += ']';
}

std::vector<BodySample> read_bodies(const Json& json) {
  std::vector<BodySample> bodies;
  bodies.reserve(array(json, "bodies").size());
  for (const Json& values : json) {
    array(values, "body", 13);
    BodySample& body = bodies.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) {
      body.p_m[i] = number(values[i]);
      body.v_m_per_s[i] = number(values[7 + i]);
      body.w_rad_per_s[i] = number(values[10 + i]);
    }
    for (std::size_t i = 0; i < 4; ++i) body.q_wxyz[i] = number(values[3 + i]);
  }
  return bodies;
}

// [[a,b,x,y,z,nx,ny,nz,gap_m,force_n_N,force_t_N(3)],...], where there are any
void append_contacts(std::string& line, const Sample& sample) {
  if (sample.contacts.empty()) return;
  line += ",\"contacts\":[";
  for (const ContactSample& contact : sample.contacts) {
    line += '[' + std::to_string(contact.body_a) + ',' + std::to_string(contact.body_b) + ',';
    append_all(line, contact.x_m);
    append_all(line, contact.normal);
    append_all(line, std::array{contact.gap_m, contact.force_n_N});
    append_all(line, contact.force_t_N);
    line.back() = ']';
    line += ',';
  }
  line.back() = ']';
}

std::vector<ContactSample> read_contacts(const Json& json) {
  std::vector<ContactSample> contacts;
  for (const Json& values : array(json, "contacts")) {
    array(values, "contact", 13);
    ContactSample& contact = contacts.emplace_back();
    contact.body_a = static_cast<int>(integer(values[0], "body_a"));
    contact.body_b = static_cast<int>(integer(values[1], "body_b"));
    for (std::size_t i = 0; i < 3; ++i) {
      contact.x_m[i] = narrow_number(values[2 + i]);
      contact.normal[i] = narrow_number(values[5 + i]);
      contact.force_t_N[i] = narrow_number(values[10 + i]);
    }
    contact.gap_m = narrow_number(values[8]);
    contact.force_n_N = narrow_number(values[9]);
  }
  return contacts;
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

void read_events(const Json& json, Answer& answer) {
  if (!json.contains("events")) return;
  for (const Json& each : array(json["events"], "events")) {
    if (!each.is_object()) throw Garbage("an event is not an object: " + each.dump().substr(0, 60));
    Event event;
    event.t_s = number(need(each, "t_s"));
    try {
      event.kind = event_kind_from_string(text_or(each, "kind", "impact"));
    } catch (const std::invalid_argument& error) {
      throw Garbage(error.what());
    }
    event.body_a = static_cast<int>(integer(need(each, "body_a"), "body_a"));
    event.body_b = static_cast<int>(integer(need(each, "body_b"), "body_b"));
    for (std::size_t i = 0; i < 3; ++i) {
      if (each.contains("x_m")) event.x_m[i] = number(array(each["x_m"], "x_m", 3)[i]);
      if (each.contains("normal")) event.normal[i] = number(array(each["normal"], "normal", 3)[i]);
    }
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
}

// ---- contacts -----------------------------------------------------------------------------------------------------
std::array<Wide, 3> read_three(const Json& values, std::size_t at) {
  return {number(values[at]), number(values[at + 1]), number(values[at + 2])};
}

void read_found(const Json& json, Answer& answer) {
  const auto body = [](const Json& value) { return static_cast<int>(integer(value, "body")); };
  if (json.contains("contacts")) {
    for (const Json& v : array(json["contacts"], "contacts")) {
      array(v, "contact", 9);
      answer.contacts.push_back({body(v[0]), body(v[1]), read_three(v, 2), read_three(v, 5), number(v[8])});
    }
  }
  if (json.contains("touches")) {
    for (const Json& v : array(json["touches"], "touches")) {
      array(v, "touch", 9);
      answer.touches.push_back({body(v[0]), body(v[1]), number(v[2]), read_three(v, 3), read_three(v, 6)});
    }
  }
  if (!json.contains("poses")) return;
  for (const Json& v : array(json["poses"], "poses")) {
    array(v, "pose", 12);
    PoseAnswer& pose = answer.poses.emplace_back();
    pose.hit = integer(v[0], "hit") != 0;
    pose.gap_m = narrow_number(v[1]);
    pose.toi_s = narrow_number(v[2]);
    for (std::size_t i = 0; i < 3; ++i) pose.normal[i] = narrow_number(v[3 + i]), pose.x_m[i] = narrow_number(v[6 + i]);
    pose.points = static_cast<int>(integer(v[9], "points"));
    pose.bar = narrow_number(v[10]);
    pose.margin_m = narrow_number(v[11]);
  }
}

std::string contacts_request(const Request& request) {
  std::string line = ",\"cell\":" + std::to_string(request.cell);
  if (!request.test.empty()) line += ",\"test\":" + dump(Json(request.test));
  line += std::string(",\"swept\":") + (request.contacts.swept ? "true" : "false");
  if (request.kind == Request::Kind::contacts) {
    return R"({"request":"contacts")" + line + ",\"t_end_s\":" + format_double(request.contacts.t_end_s) +
           ",\"scene\":" + request.json + "}";
  }
  return R"({"request":"contacts-sweep")" + line + ",\"pair\":" + dump(Json(request.pair)) +
         ",\"seed\":" + std::to_string(request.seed) + ",\"from\":" + std::to_string(request.from) +
         ",\"count\":" + std::to_string(request.count) + "}";
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
  request.seed = static_cast<std::uint64_t>(integer(need(json, "seed"), "seed"));
  request.from = integer(need(json, "from"), "from");
  request.count = integer(need(json, "count"), "count");
  if (request.from < 0 || request.count < 0) throw Garbage("\"from\" and \"count\" must not be negative");
}

// ---- settings, outcomes -------------------------------------------------------------------------------------------
Json to_json(const Settings& settings) {
  Json json = Json::object();
  for (const auto& [key, value] : settings) {
    std::visit([&, &name = key](const auto& v) { json[name] = v; }, value);
  }
  return json;
}

Settings read_settings(const Json& json) {
  if (!json.is_object()) throw Garbage("\"settings\" is not an object");
  Settings settings;
  for (const auto& [key, value] : json.items()) {
    if (value.is_boolean()) settings[key] = value.get<bool>();
    else if (value.is_number_integer()) settings[key] = value.get<std::int64_t>();
    else if (value.is_number()) settings[key] = value.get<double>();
    else settings[key] = value.is_string() ? value.get<std::string>() : value.dump();
  }
  return settings;
}

Json outcome_json(const Outcome& outcome) {
  Json done{{"status", to_string(outcome.status)},
            {"reason", outcome.reason},
            {"steps_taken", outcome.steps_taken},
            {"rate_evaluations", outcome.rate_evaluations}};
  if (!outcome.busy_ns.empty()) done["busy_ns"] = outcome.busy_ns;
  return done;
}

Outcome read_outcome(const Json& done) {
  if (!done.is_object()) throw Garbage("\"done\" is not an object");
  Outcome outcome;
  try {
    outcome.status = status_from_string(text(need(done, "status"), "status"));
  } catch (const std::invalid_argument& error) {
    throw Garbage(error.what());
  }
  outcome.reason = text_or(done, "reason", "");
  if (done.contains("steps_taken")) outcome.steps_taken = integer(done["steps_taken"], "steps_taken");
  if (done.contains("rate_evaluations")) {
    outcome.rate_evaluations = integer(done["rate_evaluations"], "rate_evaluations");
  }
  if (done.contains("busy_ns")) {
    for (const Json& each : array(done["busy_ns"], "busy_ns")) outcome.busy_ns.push_back(integer(each, "busy_ns"));
  }
  return outcome;
}

Profile read_profile(const Json& done) {
  Profile profile;
  if (done.contains("step_ns")) {
    for (const Json& each : array(done["step_ns"], "step_ns")) profile.step_ns.push_back(integer(each, "step_ns"));
  }
  if (!done.contains("phase_ns")) return profile;
  if (!done["phase_ns"].is_object()) throw Garbage("\"phase_ns\" is not an object");
  for (const auto& [phase, ns] : done["phase_ns"].items()) profile.phase_ns[phase] = integer(ns, "phase_ns");
  return profile;
}

std::string head(std::int64_t cell) { return "{\"cell\":" + std::to_string(cell); }

}  // namespace

// ---- requests -----------------------------------------------------------------------------------------------------
std::string to_line(const Request& request) {
  if (request.kind == Request::Kind::hello) return R"({"protocol":1,"request":"hello"})";
  if (request.kind == Request::Kind::truth) {
    return R"({"request":"truth","cell":)" + std::to_string(request.cell) +
           ",\"samples\":" + std::to_string(request.plan.samples) + ",\"scenario\":" + request.json + "}";
  }
  if (request.kind == Request::Kind::contacts || request.kind == Request::Kind::sweep) return contacts_request(request);
  const bool timing = request.repeats > 0;
  std::string line = R"({"request":"run","cell":)" + std::to_string(request.cell);
  const char* pass = timing ? "timing" : request.profile ? "profile" : "accuracy";
  line += ",\"method\":" + dump(Json(request.method)) + ",\"pass\":\"" + pass + "\"";
  line += ",\"t_end_s\":" + format_double(request.plan.t_end_s) + ",\"steps\":" + std::to_string(request.plan.steps);
  line += ",\"samples\":" + std::to_string(request.plan.samples) + ",\"repeats\":" + std::to_string(request.repeats);
  if (!request.plan.frame_ends_s.empty()) line += ",\"frame_ends_s\":" + dump(Json(request.plan.frame_ends_s));
  return line + ",\"scene\":" + request.json + "}";
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
    const std::int64_t protocol = json.contains("protocol") ? integer(json["protocol"], "protocol") : kProtocol;
    if (protocol != kProtocol)
      throw Garbage("protocol " + std::to_string(protocol) + "; this worker speaks protocol 1");
    return request;
  }
  need(json, "cell");
  if (kind == "contacts" || kind == "contacts-sweep") {
    read_contacts_request(json, kind, request);
    return request;
  }
  request.plan.samples = integer(need(json, "samples"), "samples");
  if (request.plan.samples <= 0) throw Garbage("\"samples\" must be positive");
  if (kind == "truth") {
    request.kind = Request::Kind::truth;
    request.json = need(json, "scenario").dump();
    return request;
  }
  if (kind != "run")
    throw Garbage("unknown request `" + kind + "`; expected hello, run, truth, contacts or contacts-sweep");
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
    throw Garbage("unknown pass `" + pass + "`; expected accuracy, timing or profile");
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

// ---- hello --------------------------------------------------------------------------------------------------------
namespace {

Json describe(const std::vector<MethodInfo>& methods) {
  Json list = Json::array();
  for (const MethodInfo& method : methods) {
    Json claims = Json::object();
    for (const auto& [motion, order] : method.claimed_order) claims[motion] = json_number(order);
    list.push_back({{"id", method.id},
                    {"doc", method.doc},
                    {"settings", to_json(method.settings)},
                    {"source", method.source},
                    {"claims", claims},
                    {"adaptive", method.adaptive}});
  }
  return list;
}

std::vector<MethodInfo> read_methods(const Json& list, const char* what) {
  std::vector<MethodInfo> methods;
  for (const Json& each : array(list, what)) {
    if (!each.is_object()) throw Garbage("a method is not an object: " + each.dump().substr(0, 60));
    MethodInfo& method = methods.emplace_back();
    method.id = text(need(each, "id"), "id");
    method.doc = text_or(each, "doc", "");
    method.source = text_or(each, "source", "");
    if (each.contains("settings")) method.settings = read_settings(each["settings"]);
    if (each.contains("adaptive")) method.adaptive = each["adaptive"].is_boolean() && each["adaptive"].get<bool>();
    if (each.contains("claims") && each["claims"].is_object()) {
      for (const auto& [motion, order] : each["claims"].items()) method.claimed_order[motion] = narrow_number(order);
    }
  }
  return methods;
}

}  // namespace

std::string hello_line(const Engine& engine) {
  Json json{{"engine", engine.name}, {"version", engine.version}, {"scalar", engine.scalar}, {"frames", engine.frames}};
  json["methods"] = describe(engine.methods);
  if (!engine.responses.empty()) json["responses"] = describe(engine.responses);
  if (!engine.fingerprint.empty()) json["fingerprint"] = engine.fingerprint;
  if (!engine.files.empty()) json["files"] = engine.files;
  return dump(json);
}

Engine read_hello(std::string_view line) {
  const Json json = parse(line);
  Engine engine;
  engine.name = text(need(json, "engine"), "engine");
  engine.version = text_or(json, "version", "");
  engine.scalar = text_or(json, "scalar", "double");
  engine.frames = json.contains("frames") && json["frames"].is_boolean() && json["frames"].get<bool>();
  engine.methods = read_methods(need(json, "methods"), "methods");
  if (json.contains("responses")) engine.responses = read_methods(json["responses"], "responses");
  engine.fingerprint = text_or(json, "fingerprint", "");
  if (json.contains("files"))
    for (const Json& file : array(json["files"], "files")) engine.files.push_back(text(file, "files"));
  return engine;
}

// ---- answers ------------------------------------------------------------------------------------------------------
std::string sample_line(std::int64_t cell, const Sample& sample, const std::vector<Event>& events) {
  std::string line = head(cell) + ",\"t_s\":";
  append(line, sample.t_s);
  line += ",\"bodies\":";
  append_bodies(line, sample);
  append_contacts(line, sample);
  append_events(line, events);
  return line + "}";
}

std::string truth_line(std::int64_t cell, const Sample& value, const Sample& bar) {
  std::string line = head(cell) + ",\"t_s\":";
  append(line, value.t_s);
  line += ",\"bodies\":";
  append_bodies(line, value);
  line += ",\"bars\":";
  append_bodies(line, bar);
  return line + "}";
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
  if (swept) for (const FoundTouch& t : answer.touches) row(t.body_a, t.body_b, One{t.toi_s}, t.x_m, t.normal);
  else for (const FoundContact& c : answer.contacts) row(c.body_a, c.body_b, c.x_m, c.normal, One{c.depth_m});
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

Answer read_answer(std::string_view line) {
  const Json json = parse(line);
  Answer answer;
  answer.cell = integer(need(json, "cell"), "cell");
  read_events(json, answer);
  if (json.contains("done")) {
    const Json& done = json["done"];
    answer.done = true;
    answer.outcome = read_outcome(done);
    answer.profile = read_profile(done);
    answer.source = text_or(done, "source", "");
    answer.note = text_or(done, "note", "");
    if (done.contains("condition")) answer.condition = narrow_number(done["condition"]);
    return answer;
  }
  if (!json.contains("t_s") && (json.contains("contacts") || json.contains("touches") || json.contains("poses"))) {
    read_found(json, answer);
    return answer;
  }
  answer.sample.t_s = number(need(json, "t_s"));
  answer.sample.bodies = read_bodies(need(json, "bodies"));
  if (json.contains("contacts")) answer.sample.contacts = read_contacts(json["contacts"]);
  if (json.contains("bars")) {
    answer.has_bar = true;
    answer.bar.t_s = 0;
    answer.bar.bodies = read_bodies(json["bars"]);
    if (answer.bar.bodies.size() != answer.sample.bodies.size())
      throw Garbage("\"bars\" and \"bodies\" differ in size");
  }
  return answer;
}

}  // namespace atwood::wire
