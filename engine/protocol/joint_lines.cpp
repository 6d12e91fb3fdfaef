#include "protocol/joint_lines.hpp"

#include <cmath>
#include <limits>

namespace atwood::wire {
namespace {

constexpr std::size_t kMaxPulleys = 10000;

bool is_nan(Wide value) { return value != value; }

bool reports_reaction(const JointSample& joint) {
  for (std::size_t i = 0; i < 3; ++i)
    if (!is_nan(joint.force_N[i]) || !is_nan(joint.torque_N_m[i])) return true;
  return false;
}

// "name":[[...],[...]], from the elements that `element` appends, each ending in a comma.
template <class Element> void append_list(std::string& line, const char* name, std::size_t count, Element element) {
  line += ",\"" + std::string(name) + "\":[";
  for (std::size_t i = 0; i < count; ++i) element(i);
  if (line.back() == ',') line.pop_back();
  line += ']';
}

template <class Values> void append_some(std::string& line, const Values& values, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    append(line, values[i]);
    line += ',';
  }
}

void close_row(std::string& line) {
  if (line.back() == ',') line.pop_back();
  line += "],";
}

void append_joint(std::string& line, const JointSample& joint, const Joint* of, bool with_reaction) {
  line += '[';
  append_some(line, joint.q, of ? static_cast<std::size_t>(coordinate_count(of->kind)) : 4);
  append_some(line, joint.u, of ? static_cast<std::size_t>(rate_count(of->kind)) : 3);
  if (with_reaction) append_some(line, joint.force_N, 3), append_some(line, joint.torque_N_m, 3);
  close_row(line);
}

void append_ropes(std::string& line, const char* name, std::span<const RopeSample> ropes) {
  append_list(line, name, ropes.size(), [&](std::size_t i) {
    line += '[';
    append(line, ropes[i].tension_N);
    line += ',';
    append_some(line, ropes[i].pulley_angle_rad, ropes[i].pulley_angle_rad.size());
    close_row(line);
  });
}

// A row's coordinates and rates follow from its length.
struct Layout {
  std::size_t coordinates, rates;
  bool reaction;
};
Layout layout_of(const Json& row) {
  if (row.is_array()) switch (row.size()) {
      case 0: return {0, 0, false};
      case 2: return {1, 1, false};
      case 4: return {2, 2, false};
      case 7: return {4, 3, false};
      case 6: return {0, 0, true};
      case 8: return {1, 1, true};
      case 10: return {2, 2, true};
      case 13: return {4, 3, true};
      default: break;
    }
  throw Garbage("\"joint\" is not an array of 6, 8, 10 or 13 (or without its reaction of 0, 2, 4 or 7): " +
                excerpt(row));
}

int read_joint(const Json& row, JointSample& joint) {
  const Layout layout = layout_of(row);
  std::size_t at = 0;
  for (std::size_t i = 0; i < layout.coordinates; ++i) joint.q[i] = number(row[at++]);
  for (std::size_t i = 0; i < layout.rates; ++i) joint.u[i] = number(row[at++]);
  const Wide none = std::numeric_limits<double>::quiet_NaN();
  for (Wide& x : joint.force_N) x = layout.reaction ? number(row[at++]) : none;
  for (Wide& x : joint.torque_N_m) x = layout.reaction ? number(row[at++]) : none;
  return static_cast<int>(layout.coordinates);
}

RopeSample read_rope(const Json& row) {
  if (!row.is_array() || row.empty() || row.size() > 1 + kMaxPulleys)
    throw Garbage("\"rope\" is not an array of a tension and the angles of pulleys: " + excerpt(row));
  RopeSample rope;
  rope.tension_N = number(row[0]);
  for (std::size_t i = 1; i < row.size(); ++i) rope.pulley_angle_rad.push_back(number(row[i]));
  return rope;
}

void refuse_more(std::size_t size, std::size_t most, const std::string& what) {
  if (size >= most) throw Garbage("more than " + std::to_string(most) + " " + what + " in a line");
}

}  // namespace

void append_joints(std::string& line, const SampleView& sample, const SampleView* bar,
                   const std::vector<Joint>* joints) {
  const std::size_t n = sample.joints.size();
  const auto of = [&](std::size_t i) { return joints && i < joints->size() ? &(*joints)[i] : nullptr; };
  if (n > 0) {
    bool applied = false, stops = false, open = false;
    append_list(line, "joints", n, [&](std::size_t i) {
      const JointSample& joint = sample.joints[i];
      append_joint(line, joint, of(i), reports_reaction(joint));
      for (const Wide x : joint.applied) applied = applied || x != 0;
      const Joint* limited = of(i);
      if (limited == nullptr || limited->limits) stops = stops || !is_nan(joint.stop[0]);
      open = open || joint.not_unique != 0;
    });
    const auto append_along = [&](const char* name, std::array<Wide, 3> JointSample::*along) {
      append_list(line, name, n, [&](std::size_t i) {
        line += '[';
        append_some(line, sample.joints[i].*along, of(i) ? static_cast<std::size_t>(rate_count(of(i)->kind)) : 3);
        close_row(line);
      });
    };
    if (applied) append_along("joint_applied", &JointSample::applied);
    if (stops) append_along("joint_stops", &JointSample::stop);
    if (open)
      append_list(line, "not_unique", n,
                  [&](std::size_t i) { line += std::to_string(sample.joints[i].not_unique) + ','; });
    if (bar)
      append_list(line, "joint_bars", n, [&](std::size_t i) {
        append_joint(line, checked(bar->joints, i), of(i), reports_reaction(bar->joints[i]));
      });
  }
  if (!sample.ropes.empty()) append_ropes(line, "ropes", sample.ropes);
  if (!sample.ropes.empty() && bar) append_ropes(line, "rope_bars", bar->ropes);
}

bool is_joint_member(const std::string& member) {
  for (const char* name : {"joints", "joint_bars", "joint_applied", "joint_stops", "not_unique", "ropes", "rope_bars"})
    if (member == name) return true;
  return false;
}

void take_joint_element(const std::string& member, const Json& value, const Limits& most, Answer& answer,
                        JointMembers& members) {
  if (member == "joints") {
    refuse_more(answer.sample.joints.size(), most.joints, member);
    members.coordinates.push_back(read_joint(value, answer.sample.joints.emplace_back()));
  } else if (member == "joint_bars") {
    refuse_more(answer.bar.joints.size(), most.joints, member);
    read_joint(value, answer.bar.joints.emplace_back());
  } else if (member == "joint_applied" || member == "joint_stops") {
    auto& all = member == "joint_applied" ? members.applied : members.stops;
    refuse_more(all.size(), most.joints, member);
    if (!value.is_array() || value.size() > 3)
      throw Garbage("\"" + member + "\" is not an array of at most 3 for each joint: " + excerpt(value));
    std::array<Wide, 3>& along = all.emplace_back();
    for (std::size_t i = 0; i < value.size(); ++i) along[i] = number(value[i]);
  } else if (member == "not_unique") {
    refuse_more(members.not_unique.size(), most.joints, member);
    const std::int64_t bits = count(value, "not_unique");
    if (bits > 63) throw Garbage("\"not_unique\" is " + std::to_string(bits) + "; expected six bits, 0 to 63");
    members.not_unique.push_back(static_cast<unsigned>(bits));
  } else {
    auto& ropes = member == "ropes" ? answer.sample.ropes : answer.bar.ropes;
    refuse_more(ropes.size(), most.joints, member);
    ropes.push_back(read_rope(value));
  }
}

void join_joint_members(const JointMembers& members, Answer& answer) {
  std::vector<JointSample>& joints = answer.sample.joints;
  answer.joint_coordinates = members.coordinates;
  const auto require = [&](std::size_t size, const char* what) {
    if (size != 0 && size != joints.size())
      throw Garbage("\"" + std::string(what) + "\" and \"joints\" differ in size");
  };
  require(members.applied.size(), "joint_applied");
  require(members.stops.size(), "joint_stops");
  require(members.not_unique.size(), "not_unique");
  for (std::size_t i = 0; i < members.applied.size(); ++i) joints[i].applied = members.applied[i];
  for (std::size_t i = 0; i < members.stops.size(); ++i) joints[i].stop = members.stops[i];
  for (std::size_t i = 0; i < members.not_unique.size(); ++i) joints[i].not_unique = members.not_unique[i];
  const std::size_t joint_bars = answer.has_bar ? joints.size() : 0;
  const std::size_t rope_bars = answer.has_bar ? answer.sample.ropes.size() : 0;
  if (answer.bar.joints.size() != joint_bars) throw Garbage("\"joint_bars\" and \"joints\" differ in size");
  if (answer.bar.ropes.size() != rope_bars) throw Garbage("\"rope_bars\" and \"ropes\" differ in size");
}

}  // namespace atwood::wire
