#include "protocol/fluid_field.hpp"

#include <utility>

#include "protocol/json_lines.hpp"

namespace atwood::wire {
namespace {

constexpr std::array<const char*, 4> kQuantities{"velocity", "pressure", "density", "temperature"};

bool& flag(FieldKnown& known, std::size_t quantity) {
  switch (quantity) {
    case 0: return known.velocity;
    case 1: return known.pressure;
    case 2: return known.density;
    default: return known.temperature;
  }
}

void append_all(std::string& line, std::initializer_list<Wide> values) {
  line += '[';
  for (const Wide& value : values) {
    append(line, value);
    line += ',';
  }
  line.back() = ']';
  line += ',';
}

// [vx,vy,vz,density,pressure,temperature],
void append_row(std::string& line, const ParticleSample& row) {
  append_all(line, {row.v_m_per_s[0], row.v_m_per_s[1], row.v_m_per_s[2], row.density_kg_per_m3, row.pressure_Pa,
                    row.temperature_K});
}

void close_array(std::string& line) {
  if (line.back() == ',') line.back() = ']';
  else line += ']';
}

ParticleSample read_row(const Json& values) {
  array(values, "values", 6);
  ParticleSample row;
  for (std::size_t i = 0; i < 3; ++i) row.v_m_per_s[i] = number(values[i]);
  row.density_kg_per_m3 = number(values[3]);
  row.pressure_Pa = number(values[4]);
  row.temperature_K = number(values[5]);
  return row;
}

void read_done(const Json& done, FluidField& ended) {
  if (!done.is_object()) throw Garbage("\"done\" is not an object: " + excerpt(done));
  const std::string status = text(need(done, "status"), "status");
  try {
    ended.outcome.status = status_from_string(status);
  } catch (const std::invalid_argument&) {
    throw Garbage("unknown status `" + cut(status) + "`");
  }
  ended.outcome.reason = text_or(done, "reason", "");
  ended.source = text_or(done, "source", "");
  ended.note = text_or(done, "note", "");
  if (!done.contains("known")) return;
  for (const Json& each : array(done["known"], "known")) {
    const std::string name = text(each, "known");
    for (std::size_t k = 0; k < kQuantities.size(); ++k)
      if (name == kQuantities[k]) flag(ended.known, k) = true;
  }
}

}  // namespace

std::string to_line(const FieldRequest& request) {
  Json json{{"request", "fluid-field"}, {"cell", request.cell}};
  if (!request.response.empty()) json["response"] = request.response;
  json["t_s"] = Json::array();
  for (const Wide& t : request.t_s) json["t_s"].push_back(json_number(t));
  json["positions"] = Json::array();
  for (const auto& positions : request.positions) {
    Json list = Json::array();
    for (const FieldPosition& p : positions) list.push_back({json_number(p[0]), json_number(p[1]), json_number(p[2])});
    json["positions"].push_back(std::move(list));
  }
  return with_document(json, "scenario", request.scenario);
}

FieldRequest read_field_request(std::string_view line) {
  const Json json = parse(line);
  FieldRequest request;
  request.cell = integer(need(json, "cell"), "cell");
  request.response = text_or(json, "response", "");
  request.scenario = need(json, "scenario").dump();
  for (const Json& t : array(need(json, "t_s"), "t_s")) request.t_s.push_back(number(t));
  for (const Json& list : array(need(json, "positions"), "positions")) {
    auto& at = request.positions.emplace_back();
    for (const Json& each : array(list, "positions")) {
      array(each, "position", 3);
      at.push_back({number(each[0]), number(each[1]), number(each[2])});
    }
  }
  if (request.positions.size() != request.t_s.size())
    throw Garbage("expected one list of positions a time; found " + std::to_string(request.positions.size()) +
                  " lists and " + std::to_string(request.t_s.size()) + " times");
  return request;
}

// Written number by number like samples (wire.cpp): a line must end where it is long enough.
void field_lines(std::int64_t cell, const FieldSample& field, const Put& put, std::size_t longest) {
  std::size_t row = 0;
  for (bool more = true; more;) {
    std::string line = "{\"cell\":" + std::to_string(cell) + ",\"field_t_s\":", bars;
    append(line, field.t_s);
    if (row > 0) line += ",\"from\":" + std::to_string(row);
    line += ",\"values\":[";
    for (; row < field.values.size() && line.size() + bars.size() < longest; ++row) {
      append_row(line, field.values[row]);
      append_row(bars, field.bars.at(row));
    }
    close_array(line);
    line += ",\"bars\":[" + bars;
    close_array(line);
    more = row < field.values.size();
    if (more) line += ",\"more\":true";
    if (!more && !field.probes.empty()) {
      line += ",\"probes\":[";
      for (const auto& probe : field.probes) {
        if (probe) append_all(line, {probe->value, probe->bar});
        else line += "null,";
      }
      close_array(line);
    }
    put(line + "}");
  }
}

std::string field_done_line(std::int64_t cell, const FluidField& field) {
  Json done{{"status", to_string(field.outcome.status)},
            {"reason", field.outcome.reason},
            {"source", field.source},
            {"note", field.note}};
  done["known"] = Json::array();
  FieldKnown known = field.known;
  for (std::size_t k = 0; k < kQuantities.size(); ++k)
    if (flag(known, k)) done["known"].push_back(kQuantities[k]);
  return "{\"cell\":" + std::to_string(cell) + ",\"done\":" + dump(done) + "}";
}

FieldAnswer read_field_answer(std::string_view line, std::size_t most) {
  FieldAnswer answer;
  bool has_cell = false, has_time = false;
  read_members(
      line,
      [&](const std::string& member) {
        has_cell = has_cell || member == "cell";
        has_time = has_time || member == "field_t_s";
        if (member == "values" || member == "bars" || member == "probes") return Reading::by_element;
        for (const char* name : {"cell", "field_t_s", "from", "more", "done"})
          if (member == name) return Reading::whole;
        return Reading::ignored;
      },
      [&](const std::string& member, Json& value) {
        FieldSample& sample = answer.sample;
        if (member == "cell") answer.cell = integer(value, "cell");
        else if (member == "field_t_s") sample.t_s = number(value);
        else if (member == "from") answer.from = static_cast<std::size_t>(count(value, "from"));
        else if (member == "more") answer.more = value.is_boolean() && value.get<bool>();
        else if (member == "done") {
          answer.done = true;
          read_done(value, answer.ended);
        } else if (member == "probes") {
          if (sample.probes.size() >= most) throw Garbage("more than " + std::to_string(most) + " probes in a line");
          auto& probe = sample.probes.emplace_back();
          if (value.is_null()) return;
          array(value, "probe", 2);
          probe = ProbeValue{number(value[0]), number(value[1])};
        } else {
          auto& rows = member == "bars" ? sample.bars : sample.values;
          if (rows.size() >= most) throw Garbage("more than " + std::to_string(most) + " rows in a line");
          rows.push_back(read_row(value));
        }
      });
  if (!has_cell) throw Garbage("no \"cell\" in " + cut(line));
  if (answer.done) return answer;
  if (!has_time) throw Garbage("no \"field_t_s\" in " + cut(line));
  if (answer.sample.values.size() != answer.sample.bars.size()) throw Garbage("\"values\" and \"bars\" differ in size");
  return answer;
}

}  // namespace atwood::wire
