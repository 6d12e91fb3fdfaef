#include "reports/command_line/trace_joints.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "reports/command_line/table.hpp"
#include "scene/files.hpp"

namespace atwood {
namespace {

constexpr double kSquare = 1e-12;  // cosine of two axes at a right angle: round-off of attitudes
constexpr const char* kJointColumns =
    "t_s,joint,q0,q1,q2,q3,u0,u1,u2,fx_N,fy_N,fz_N,tx_N_m,ty_N_m,tz_N_m,applied0,applied1,applied2,stop0,stop1,stop2";
constexpr const char* kChildAxesColumns = ",fx_child_N,fy_child_N,fz_child_N,tx_child_N_m,ty_child_N_m,tz_child_N_m";
constexpr const char* kJointBarColumns =
    ",q0_bar,q1_bar,q2_bar,q3_bar,u0_bar,u1_bar,u2_bar,fx_N_bar,fy_N_bar,fz_N_bar,tx_N_m_bar,ty_N_m_bar,tz_N_m_bar,source";

// A value that is not reported is an empty field.
void append_reported(std::string& line, Wide value, int digits) {
  line += ",";
  if (value == value) line += format_number(value, digits);
}

void append_state(std::string& line, const JointSample& sample, const Joint& joint, int digits) {
  for (int i = 0; i < 4; ++i)
    line += i < coordinate_count(joint.kind) ? "," + format_number(sample.q[static_cast<std::size_t>(i)], digits) : ",";
  for (int i = 0; i < 3; ++i)
    line += i < rate_count(joint.kind) ? "," + format_number(sample.u[static_cast<std::size_t>(i)], digits) : ",";
}

void append_along(std::string& line, const std::array<Wide, 3>& values, int count, int digits) {
  for (int i = 0; i < 3; ++i)
    if (i < count) append_reported(line, values[static_cast<std::size_t>(i)], digits);
    else line += ",";
}

bool is_open(const JointSample& sample, std::size_t component) { return (sample.not_unique >> component & 1u) != 0; }

Wide reaction(const JointSample& sample, std::size_t component) {
  return component < 3 ? sample.force_N[component] : sample.torque_N_m[component - 3];
}

void append_reaction(std::string& line, const JointSample& value, const JointSample& sample, int digits) {
  for (std::size_t i = 0; i < 6; ++i)
    if (is_open(sample, i)) line += ",not unique";
    else append_reported(line, reaction(value, i), digits);
}

// The reaction in the axes of the child. A component there is open where its axis is not square to all world axes whose
// components are open.
void append_in_child_axes(std::string& line, const JointSample& sample, const BodySample& child, int digits) {
  const auto& [w, x, y, z] = child.q_wxyz;
  const Wide rows[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
                           {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
                           {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}};
  for (const std::size_t first : {std::size_t{0}, std::size_t{3}}) {
    for (const auto& row : rows) {
      Wide sum = 0;
      bool open = false;
      for (std::size_t k = 0; k < 3; ++k) {
        if (!is_open(sample, first + k)) sum += row[k] * reaction(sample, first + k);
        else open = open || std::fabs(static_cast<double>(row[k])) > kSquare;
      }
      if (open) line += ",not unique";
      else append_reported(line, sum, digits);
    }
  }
}

}  // namespace

void require_mechanism(const Scene& scene, const std::string& id, bool joints, bool ropes) {
  if (joints && scene.joints.empty())
    throw InputError(
        fmt::format("--joints: `{}` has no joint; expected a scene with joints, as double-pendulum-regular", id));
  if (ropes && scene.ropes.empty())
    throw InputError(fmt::format("--ropes: `{}` has no rope; expected a scene with ropes, as atwood-machine", id));
}

void print_joints(const Scene& scene, const SampleSeries& values, const Truth* truth, int digits, bool json) {
  Table table(fmt::format("{}{}{}", kJointColumns, json ? kChildAxesColumns : "", truth ? kJointBarColumns : ""), json);
  for (std::size_t k = 0; k < values.size(); ++k)
    for (std::size_t j = 0; j < values[k].joints.size() && j < scene.joints.size(); ++j) {
      const Joint& joint = scene.joints[j];
      const JointSample& sample = values[k].joints[j];
      std::string line = format_number(values[k].t_s, digits) + "," + quoted(joint.name);
      append_state(line, sample, joint, digits);
      append_reaction(line, sample, sample, digits);
      append_along(line, sample.applied, rate_count(joint.kind), digits);
      append_along(line, sample.stop, joint.limits ? rate_count(joint.kind) : 0, digits);
      if (json)
        append_in_child_axes(line, sample, checked(values[k].bodies, static_cast<std::size_t>(joint.child)), digits);
      if (truth) {
        const JointSample& bar = checked(truth->bars[k].joints, j);
        append_state(line, bar, joint, 17);
        append_reaction(line, bar, sample, 17);
        line += "," + quoted(truth->source);
      }
      table.row(line);
    }
}

void print_ropes(const Scene& scene, const SampleSeries& values, const Truth* truth, int digits, bool json) {
  std::size_t pulleys = 0;
  for (const Rope& rope : scene.ropes) pulleys = std::max(pulleys, rope.over.size());
  std::string columns = "t_s,rope,tension_N", bar_columns = ",tension_N_bar";
  for (std::size_t i = 0; i < pulleys; ++i) {
    columns += fmt::format(",pulley{}_rad", i);
    bar_columns += fmt::format(",pulley{}_rad_bar", i);
  }
  Table table(truth ? columns + bar_columns + ",source" : columns, json);
  const auto append_rope = [&](std::string& line, const RopeSample& rope, int with_digits) {
    append_reported(line, rope.tension_N, with_digits);
    for (std::size_t i = 0; i < pulleys; ++i)
      if (i < rope.pulley_angle_rad.size()) append_reported(line, rope.pulley_angle_rad[i], with_digits);
      else line += ",";
  };
  for (std::size_t k = 0; k < values.size(); ++k)
    for (std::size_t i = 0; i < values[k].ropes.size() && i < scene.ropes.size(); ++i) {
      std::string line = format_number(values[k].t_s, digits) + "," + quoted(scene.ropes[i].name);
      append_rope(line, values[k].ropes[i], digits);
      if (truth) {
        append_rope(line, checked(truth->bars[k].ropes, i), 17);
        line += "," + quoted(truth->source);
      }
      table.row(line);
    }
}

}  // namespace atwood
