#include "reports/command_line/mechanism_summary.hpp"

#include <fmt/format.h>

#include "protocol/sample.hpp"

namespace atwood {
namespace {

constexpr std::size_t kShown = 12;
constexpr const char* kJointWords[] = {"fixed", "hinge", "slider", "cylindrical", "universal", "ball"};

std::string tied_name(const Scene& scene, int body) {
  return body < 0 ? "the world" : "`" + scene.bodies[static_cast<std::size_t>(body)].name + "`";
}

bool is_offset(const Joint& joint, std::size_t i) {
  return joint.kind == JointKind::slider || (joint.kind == JointKind::cylindrical && i == 1);
}

std::string start_words(const Joint& joint) {
  if (joint.kind == JointKind::fixed) return "";
  if (joint.kind == JointKind::ball) {
    const auto& [w, x, y, z] = joint.coordinates;
    const auto& [u0, u1, u2] = joint.rates;
    return fmt::format("; starts at ({:.4g}, {:.4g}, {:.4g}, {:.4g}), ({:.4g}, {:.4g}, {:.4g}) rad/s", w, x, y, z, u0,
                       u1, u2);
  }
  std::string text = "; starts at ";
  for (std::size_t i = 0; i < static_cast<std::size_t>(rate_count(joint.kind)); ++i) {
    const char* unit = is_offset(joint, i) ? "m" : "rad";
    text += fmt::format("{}{:.6g} {}, {:.6g} {}/s", i == 0 ? "" : " and ", joint.coordinates[i], unit, joint.rates[i],
                        unit);
  }
  return text;
}

std::string force_words(const Scene& scene, std::size_t j) {
  int springs = 0, torques = 0;
  for (const JointForce& force : scene.joint_forces) {
    if (const auto* spring = std::get_if<JointSpring>(&force)) springs += spring->joint == static_cast<int>(j) ? 1 : 0;
    if (const auto* torque = std::get_if<JointTorque>(&force)) torques += torque->joint == static_cast<int>(j) ? 1 : 0;
  }
  std::string text;
  if (springs > 0)
    text += fmt::format("; {} spring{} or damper{}", springs, springs > 1 ? "s" : "", springs > 1 ? "s" : "");
  if (torques > 0) text += fmt::format("; {} torque{} along it", torques, torques > 1 ? "s" : "");
  return text;
}

std::string joint_words(const Scene& scene, std::size_t j) {
  const Joint& joint = scene.joints[j];
  std::string text = fmt::format("`{}`: {}, {} to {}", joint.name, kJointWords[static_cast<std::size_t>(joint.kind)],
                                 tied_name(scene, joint.parent), tied_name(scene, joint.child));
  text += joint.closes_loop ? "; closes a loop" : start_words(joint);
  const char* unit = joint.kind == JointKind::slider ? "m" : "rad";
  if (joint.driven_rate) text += fmt::format("; prescribed: {} {}/s", format_double(*joint.driven_rate), unit);
  if (joint.limits)
    text += fmt::format("; stops at {} and {} {}, restitution {}", format_double(joint.limits->lower),
                        format_double(joint.limits->upper), unit, format_double(joint.limits->restitution));
  return text + force_words(scene, j);
}

}  // namespace

std::vector<std::string> joints_words(const Scene& scene) {
  std::vector<std::string> words;
  for (std::size_t j = 0; j < scene.joints.size() && j < kShown; ++j) words.push_back(joint_words(scene, j));
  if (scene.joints.size() > kShown) words.push_back(fmt::format("and {} joints more", scene.joints.size() - kShown));
  return words;
}

std::vector<std::string> ropes_words(const Scene& scene) {
  std::vector<std::string> words;
  for (const Rope& rope : scene.ropes) {
    if (words.size() == kShown) {
      words.push_back(fmt::format("and {} ropes more", scene.ropes.size() - kShown));
      break;
    }
    std::size_t pulleys = 0;
    for (const Pulley& pulley : rope.over) pulleys += pulley.radius_m > 0 ? 1 : 0;
    const std::size_t points = rope.over.size() - pulleys;
    std::string text =
        fmt::format("`{}`: {} to {}", rope.name, tied_name(scene, rope.bodies[0]), tied_name(scene, rope.bodies[1]));
    if (points > 0) text += fmt::format(", over {} fixed point{}", points, points > 1 ? "s" : "");
    if (pulleys > 0) text += fmt::format(", over {} pulley{}", pulleys, pulleys > 1 ? "s" : "");
    words.push_back(text);
  }
  return words;
}

}  // namespace atwood
