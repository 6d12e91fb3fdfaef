// [[joint]] and [[rope]]: which joint places which body, and the start of what they tie together.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "scene/driven_closings.hpp"
#include "scene/joint_keys.hpp"
#include "scene/loop_projection.hpp"
#include "scene/mechanism.hpp"
#include "scene/union_find.hpp"

namespace atwood {
namespace {

constexpr std::size_t kMaxJoints = 20'000;  // one line of a sample holds them all
constexpr double kClosed = 1e-9;            // of the mechanism's size, and rad: a larger gap is not a loop
constexpr double kClosingAngle = 1e-6;      // rad: further apart are the angle of a closing joint and its bodies
constexpr double kUnmoved = 1e-14;          // a change of the start below it is the rounding of its doubles
constexpr double kOutside = 1e-12;          // past a limit: round-off

// What is read of [[joint]] and [[rope]], with where it stands.
struct Mechanisms {
  std::vector<const Value*> joints, ropes;
};

std::string title(const char* kind, const std::string& name) { return std::string("[[") + kind + "]] `" + name + "`"; }

const Body& body_of(const Reading& r, int index) { return r.scene->bodies[static_cast<std::size_t>(index)]; }

SourceLocation location_of(const Value& table, const char* key) {
  const Value* found = table.find(key);
  return found ? found->location : table.location;
}

template <class T>
void require_new_name(Reading& r, const Value& table, const std::vector<T>& earlier, const std::string& name) {
  for (const T& each : earlier)
    if (each.name == name)
      fail(r, location_of(table, "name"), "found the name `" + name + "` a second time; expected each name once");
}

// ---- reading ------------------------------------------------------------------------------------------------------
std::string name_or_number(const Value& table, const char* kind, std::size_t number) {
  const Value* name = table.find("name");
  return name && name->text() ? *name->text() : std::string(kind) + "." + std::to_string(number);
}

Joint read_joint(Reading& r, const Value& table, const Value*& hold) {
  JointDraft joint;
  joint.name = name_or_number(table, "joint", r.scene->joints.size());
  r.where = title("joint", joint.name);
  read_table(r, table, joint_keys(), {}, joint);
  finish_joint(r, table, joint);
  if (!r.joints.emplace(joint.name, static_cast<int>(r.scene->joints.size())).second)
    fail(r, location_of(table, "name"), "found the name `" + joint.name + "` a second time; expected each name once");
  if (r.scene->joints.size() >= kMaxJoints)
    fail(r, table.location, "found more than " + std::to_string(kMaxJoints) + " joints; expected fewer");
  hold = joint.hold_names;
  return joint;
}

// Names of joints, each once.
void read_hold(Reading& r, const Value& v, Joint& joint) {
  r.where = title("joint", joint.name), r.key = "hold";
  const auto* items = v.list();
  if (!items) fail_value(r, v, "a list of names of joints");
  std::vector<bool> held(r.scene->joints.size());
  for (const Value& item : *items) {
    const auto found = item.text() ? r.joints.find(*item.text()) : r.joints.end();
    if (found == r.joints.end()) {
      std::vector<std::string> names;
      for (const Joint& each : r.scene->joints)
        if (!each.closes_loop) names.push_back(each.name);
      fail_value(
          r, item,
          "the name of a joint (" + listed(names) + ")" + (item.text() ? did_you_mean(*item.text(), names) : ""));
    }
    if (r.scene->joints[static_cast<std::size_t>(found->second)].closes_loop)
      fail_value(r, item, "a joint that places a body: one that closes a loop has no coordinate of its own");
    if (held[static_cast<std::size_t>(found->second)]) fail_value(r, item, "each joint once");
    held[static_cast<std::size_t>(found->second)] = true;
    joint.hold.push_back(found->second);
  }
  r.key.clear();
}

void read_mechanisms(Reading& r, const FileDraft& draft, Mechanisms& mechanisms) {
  std::vector<const Value*> holds;
  each_table(r, draft.joint, "[[joint]]", [&](const Value& table) {
    const Value* hold = nullptr;
    r.scene->joints.push_back(read_joint(r, table, hold));
    mechanisms.joints.push_back(&table);
    holds.push_back(hold);
  });
  for (std::size_t j = 0; j < holds.size(); ++j)
    if (holds[j]) read_hold(r, *holds[j], r.scene->joints[j]);
  require_few(r, draft.rope, "[[rope]]", kMaxTables);
  each_table(r, draft.rope, "[[rope]]", [&](const Value& table) {
    Rope rope;
    rope.name = name_or_number(table, "rope", r.scene->ropes.size());
    r.where = title("rope", rope.name);
    read_table(r, table, rope_keys(), {}, rope);
    require_new_name(r, table, r.scene->ropes, rope.name);
    r.scene->ropes.push_back(std::move(rope));
    mechanisms.ropes.push_back(&table);
  });
}

// ---- topology -------------------------------------------------------------------------------------------------------
[[noreturn]] void fail_at(Reading& r, const Mechanisms& mechanisms, const MechanismError& error) {
  const auto j = static_cast<std::size_t>(error.joint);
  const auto i = static_cast<std::size_t>(std::max(error.rope, 0));
  const SourceLocation at = error.joint >= 0 ? location_of(*mechanisms.joints[j], "bodies")
                            : !mechanisms.ropes.empty()
                                ? location_of(*mechanisms.ropes[i], error.rope >= 0 ? "over_m" : "bodies")
                                : SourceLocation{};
  fail(r, at, error.what());
}

// A placed body has no position of its own. Tables of bodies by their names.
void check_placed_bodies(Reading& r, const FileDraft& draft, const std::vector<int>& placing) {
  each_table(r, draft.body, "[[body]]", [&](const Value& table) {
    const Value* name = table.find("name");
    if (!name || !name->text()) return;
    const auto found = r.bodies.find(*name->text());
    if (found == r.bodies.end()) return;
    const int joint = placing[static_cast<std::size_t>(found->second)];
    if (joint < 0) return;
    for (const char* key : {"position_m", "orientation_wxyz", "axis_angle_deg", "euler_xyz_deg", "velocity_m_per_s",
                            "angular_velocity_body_rad_per_s"})
      if (const Value* given = table.find(key))
        fail(r, given->location,
             std::string("`") + key + "` in [[body]] `" + *name->text() + "` is given beside the joint `" +
                 r.scene->joints[static_cast<std::size_t>(joint)].name +
                 "`, which places it; expected only the joint's coordinates and rates");
  });
  for (const auto& [name, copies] : r.grids)
    for (int body = copies.first; body < copies.first + copies.count; ++body)
      if (placing[static_cast<std::size_t>(body)] >= 0)
        fail(r, draft.joint->location,
             "the joint `" + r.scene->joints[static_cast<std::size_t>(placing[static_cast<std::size_t>(body)])].name +
                 "` places the body `" + body_of(r, body).name +
                 "`, which a grid places; expected a body that no grid copies");
}

// A point mass has no orientation of its own that a joint could turn or hold.
void check_inertia(Reading& r, const Mechanisms& mechanisms, const std::vector<int>& placing) {
  for (std::size_t j = 0; j < mechanisms.joints.size(); ++j) {
    const Joint& joint = r.scene->joints[j];
    const bool slides = joint.kind == JointKind::slider || joint.kind == JointKind::fixed;
    for (const int b : {joint.child, joint.parent}) {
      if (b < 0 || body_of(r, b).fixed || rotates(body_of(r, b))) continue;
      const int own = placing[static_cast<std::size_t>(b)];
      const Joint* holder = own < 0 ? nullptr : &r.scene->joints[static_cast<std::size_t>(own)];
      const bool held =
          holder && holder->kind == JointKind::slider && (holder->parent < 0 || body_of(r, holder->parent).fixed);
      if (held && (b == joint.parent || slides)) continue;
      const Value& bodies = *mechanisms.joints[j]->find("bodies");
      fail(
          r, (*bodies.list())[b == joint.child ? 1 : 0].location,
          "the body `" + body_of(r, b).name + "` of " + title("joint", joint.name) +
              " is a point mass, whose inertia is 0, and turns; expected a shape or `inertia_kg_m2` (a small one, if it "
              "is to act as a point), or a slider from the world");
    }
  }
}

// Bodies that ropes alone tie in a ring keep all their distances: their tensions have no solution, or many.
void check_rope_cycles(Reading& r, const Mechanisms& mechanisms) {
  std::vector<int> parent(r.scene->bodies.size());
  std::iota(parent.begin(), parent.end(), 0);
  for (std::size_t i = 0; i < r.scene->ropes.size(); ++i) {
    const auto [a, b] = r.scene->ropes[i].bodies;
    if (body_of(r, a).fixed || body_of(r, b).fixed) continue;
    if (find_root(parent, a) == find_root(parent, b))
      fail(r, mechanisms.ropes[i]->find("bodies")->location,
           title("rope", r.scene->ropes[i].name) + " closes a cycle of ropes between `" + body_of(r, a).name +
               "` and `" + body_of(r, b).name + "`; expected ropes that make no cycle");
    unite(parent, a, b);
  }
}

// A joint that closes no loop, because no other joint holds its bodies together, is said to.
void check_holds(Reading& r, const Mechanisms& mechanisms, const std::vector<int>& placing) {
  for (std::size_t j = 0; j < mechanisms.joints.size(); ++j) {
    const Joint& joint = r.scene->joints[j];
    if (joint.hold.empty()) continue;
    // The joints from both ends up to the root.
    std::vector<int> chain;
    bool floats = false;
    for (int body : {joint.parent, joint.child}) {
      while (body >= 0 && placing[static_cast<std::size_t>(body)] >= 0) {
        chain.push_back(placing[static_cast<std::size_t>(body)]);
        body = r.scene->joints[static_cast<std::size_t>(chain.back())].parent;
      }
      floats = floats || (body >= 0 && !body_of(r, body).fixed);
    }
    std::vector<bool> named(r.scene->joints.size());
    for (const int at : joint.hold) named[static_cast<std::size_t>(at)] = true;
    const auto held = [&](int at) {
      const Joint& each = r.scene->joints[static_cast<std::size_t>(at)];
      return each.driven_rate || rate_count(each.kind) == 0 || named[static_cast<std::size_t>(at)];
    };
    if (!floats && std::all_of(chain.begin(), chain.end(), held))
      fail(r, location_of(*mechanisms.joints[j], "hold"),
           "`hold` in " + title("joint", joint.name) +
               " keeps every joint of the loop, so that nothing can close it; expected fewer joints");
  }
}

// ---- the start ---------------------------------------------------------------------------------------------------
// Poses and velocities of bodies that joints place or that the projection moved, in doubles; others keep their bits.
void write_bodies(Scene& scene, const MechanismStart& start) {
  const std::vector<int> placing = placing_joints(scene);
  const std::vector<BodyMotion> given = given_motions(scene);
  const auto same = [](const BodyMotion& a, const BodyMotion& b) {
    return a.p_m == b.p_m && a.q_wxyz == b.q_wxyz && a.v_m_per_s == b.v_m_per_s && a.w_rad_per_s == b.w_rad_per_s;
  };
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    Body& body = scene.bodies[b];
    const BodyMotion& m = start.bodies[b];
    if (body.fixed || (placing[b] < 0 && same(m, given[b]))) continue;
    body.position_m = quad::rounded(m.p_m);
    body.orientation_wxyz = quad::rounded(m.q_wxyz);
    body.velocity_m_per_s = quad::rounded(m.v_m_per_s);
    body.angular_velocity_body_rad_per_s = rotates(body) ? quad::rounded(m.w_rad_per_s) : Real3{};
  }
}

void write_joints(Scene& scene, const MechanismStart& start, bool closing_alone) {
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    Joint& joint = scene.joints[j];
    if ((closing_alone && !joint.closes_loop) || (closing_alone && joint.driven_rate)) continue;
    for (int i = 0; i < coordinate_count(joint.kind); ++i)
      joint.coordinates[static_cast<std::size_t>(i)] =
          static_cast<double>(start.joints[j].q[static_cast<std::size_t>(i)]);
    for (int i = 0; i < rate_count(joint.kind); ++i)
      joint.rates[static_cast<std::size_t>(i)] = static_cast<double>(start.joints[j].u[static_cast<std::size_t>(i)]);
    if (joint.driven_rate) joint.rates[0] = *joint.driven_rate;
  }
}

// The angles of a joint that closes a loop follow from the bodies; given ones say how many turns they count.
void check_closing_angles(Reading& r, const Value& table, const Joint& joint, const JointMotion& placed) {
  const Value* given = table.find("angle_rad");
  if (!given || joint.driven_rate) return;
  const int angles = joint.kind == JointKind::universal ? 2 : 1;
  for (int k = 0; k < angles; ++k) {
    const auto at = static_cast<std::size_t>(k);
    const auto follows = static_cast<double>(placed.q[at]);
    if (std::abs(joint.coordinates[at] - follows) > kClosingAngle)
      fail(r, given->location,
           "`angle_rad` of " + title("joint", joint.name) + " is " + describe(Value(joint.coordinates[at])) +
               ", and its bodies stand at " + describe(Value(follows)) +
               "; expected their angle, up to whole turns (within 1e-6)");
  }
}

void check_gaps(Reading& r, const Mechanisms& mechanisms, const MechanismStart& placed) {
  for (std::size_t j = 0; j < mechanisms.joints.size(); ++j) {
    const Joint& joint = r.scene->joints[j];
    if (!joint.closes_loop || joint.assemble) continue;
    check_closing_angles(r, *mechanisms.joints[j], joint, placed.joints[j]);
    const LoopGap gap = joint_gap(*r.scene, placed, static_cast<int>(j));
    const char* expected = "; expected at most 1e-9, or assemble = true, which moves the start onto the loop";
    if (!(gap.gap <= kClosed))
      fail(r, location_of(*mechanisms.joints[j], "bodies"),
           "the loop of " + title("joint", joint.name) + " does not close: it is open by " + describe(Value(gap.gap)) +
               " of the mechanism's size, or rad" + expected);
    if (!(gap.rate <= kClosed))
      fail(r, location_of(*mechanisms.joints[j], "bodies"),
           "the loop of " + title("joint", joint.name) + " does not stay closed: it opens at a rate of " +
               describe(Value(gap.rate)) + " of the mechanism's speed" + expected);
  }
  for (std::size_t i = 0; i < mechanisms.ropes.size(); ++i) {
    const LoopGap gap = rope_gap(*r.scene, placed, static_cast<int>(i));
    if (!(gap.rate <= kClosed))
      fail(r, location_of(*mechanisms.ropes[i], "bodies"),
           title("rope", r.scene->ropes[i].name) + " changes its length at a rate of " + describe(Value(gap.rate)) +
               " of the mechanism's speed; expected velocities that keep it (within 1e-9)");
  }
}

// Says how far the projection moved the start, where that is more than the rounding of doubles.
void note_changes(Reading& r, const Mechanisms& mechanisms, const Scene& before, const Scene& after) {
  double most = 0, most_rate = 0;
  std::string where = "none", where_rate = "none";
  const auto take = [](double a, double b, const std::string& name, double& largest_change, std::string& at) {
    const double change = std::abs(a - b) / std::max(1.0, std::abs(a));
    if (change > largest_change) largest_change = change, at = name;
  };
  for (std::size_t j = 0; j < before.joints.size(); ++j) {
    if (before.joints[j].closes_loop) continue;
    const std::string name = "joint `" + before.joints[j].name + "`";
    for (std::size_t i = 0; i < 4; ++i)
      take(before.joints[j].coordinates[i], after.joints[j].coordinates[i], name, most, where);
    for (std::size_t i = 0; i < 3; ++i)
      take(before.joints[j].rates[i], after.joints[j].rates[i], name, most_rate, where_rate);
  }
  const std::vector<int> placing = placing_joints(before);
  for (std::size_t b = 0; b < before.bodies.size(); ++b) {
    if (placing[b] >= 0 || before.bodies[b].fixed) continue;
    const Body &x = before.bodies[b], &y = after.bodies[b];
    const std::string name = "body `" + x.name + "`";
    for (std::size_t i = 0; i < 3; ++i) {
      take(x.position_m[i], y.position_m[i], name, most, where);
      take(x.velocity_m_per_s[i], y.velocity_m_per_s[i], name, most_rate, where_rate);
      take(x.angular_velocity_body_rad_per_s[i], y.angular_velocity_body_rad_per_s[i], name, most_rate, where_rate);
    }
    for (std::size_t i = 0; i < 4; ++i) take(x.orientation_wxyz[i], y.orientation_wxyz[i], name, most, where);
  }
  if (most <= kUnmoved && most_rate <= kUnmoved) return;
  std::string names;
  const Value* first = nullptr;
  const auto add = [&](const std::string& name, const Value& where_named) {
    names += (names.empty() ? "`" : ", `") + name + "`";
    if (first == nullptr) first = &where_named;
  };
  for (std::size_t j = 0; j < before.joints.size(); ++j)
    if (before.joints[j].closes_loop) add(before.joints[j].name, *mechanisms.joints[j]);
  for (std::size_t i = 0; i < before.ropes.size(); ++i) add(before.ropes[i].name, *mechanisms.ropes[i]);
  r.notes.push_back(location_text(r, first->location) + "the start was moved onto the constraints of " + names +
                    " by the least change in the mass metric: coordinates by at most " + describe(Value(most)) + " (" +
                    where + "), rates by at most " + describe(Value(most_rate)) + " (" + where_rate + ")");
}

void check_limits(Reading& r, const Mechanisms& mechanisms) {
  for (std::size_t j = 0; j < mechanisms.joints.size(); ++j) {
    const Joint& joint = r.scene->joints[j];
    if (!joint.limits) continue;
    const double at = joint.coordinates[0], slack = kOutside * std::max(1.0, std::abs(at));
    if (at < joint.limits->lower - slack || at > joint.limits->upper + slack)
      fail(r, location_of(*mechanisms.joints[j], joint.kind == JointKind::hinge ? "limits_rad" : "limits_m"),
           title("joint", joint.name) + " starts at " + describe(Value(at)) + ", outside its limits of " +
               describe(Value(joint.limits->lower)) + " to " + describe(Value(joint.limits->upper)) +
               "; expected a start between them");
  }
}

MechanismStart placed_start(const Scene& scene) {
  MechanismStart start{given_motions(scene), given_joint_motions(scene)};
  const BodyMotion world = world_motion();
  for (const int j : joints_from_root(scene)) {
    const auto at = static_cast<std::size_t>(j);
    const Joint& joint = scene.joints[at];
    start.bodies[static_cast<std::size_t>(joint.child)] =
        placed_child(joint, start.joints[at], motion_of(start.bodies, joint.parent, world));
  }
  for (std::size_t j = 0; j < scene.joints.size(); ++j)
    if (const Joint& joint = scene.joints[j]; joint.closes_loop)
      start.joints[j] = joint_motion(joint, motion_of(start.bodies, joint.parent, world),
                                     motion_of(start.bodies, joint.child, world), start.joints[j]);
  return start;
}

// A driven joint that closes a loop starts where the bodies put it, unless its angle or offset is given.
void start_driven_closings(Scene& scene, const Mechanisms& mechanisms, const MechanismStart& placed) {
  for (std::size_t j = 0; j < mechanisms.joints.size(); ++j) {
    Joint& joint = scene.joints[j];
    const bool given = mechanisms.joints[j]->find("angle_rad") || mechanisms.joints[j]->find("offset_m");
    if (joint.closes_loop && joint.driven_rate && !given)
      joint.coordinates[0] = static_cast<double>(placed.joints[j].q[0]);
  }
}

// Driven joints that close loops change places with joints of the tree; a note names both.
void exchange_driven_closings(Reading& r, const Mechanisms& mechanisms, MechanismStart& placed) {
  Scene& scene = *r.scene;
  const std::vector<ExchangedJoints> exchanged = let_driven_joints_place(scene);
  if (exchanged.empty()) return;
  for (const auto& [driven, closing] : exchanged) {
    const Joint& joint = scene.joints[static_cast<std::size_t>(driven)];
    r.notes.push_back(
        location_text(r, location_of(*mechanisms.joints[static_cast<std::size_t>(driven)], "closes_loop")) +
        "the joint `" + joint.name + "` is driven: it places `" + body_of(r, joint.child).name +
        "` in the tree of the joints" +
        (closing < 0 ? "" : ", and `" + scene.joints[static_cast<std::size_t>(closing)].name + "` closes the loop"));
  }
  placed = placed_start(scene);
}

void check_finite(Reading& r, const Mechanisms& mechanisms) {
  for (const Body& body : r.scene->bodies)
    for (const double x : {body.position_m[0], body.position_m[1], body.position_m[2], body.velocity_m_per_s[0],
                           body.velocity_m_per_s[1], body.velocity_m_per_s[2]})
      if (!std::isfinite(x))
        fail(r, (mechanisms.joints.empty() ? mechanisms.ropes : mechanisms.joints).front()->location,
             "the joints place the body `" + body.name + "` where numbers end; expected ordinary lengths and rates");
}

}  // namespace

void resolve_mechanisms(Reading& r, const FileDraft& draft) {
  if (!draft.joint && !draft.rope) return;
  if (draft.fluid)
    fail(r, (draft.joint ? draft.joint : draft.rope)->location,
         "found joints or ropes beside a fluid; expected one of the two: mechanisms in fluids are not simulated");
  Mechanisms mechanisms;
  read_mechanisms(r, draft, mechanisms);
  Scene& scene = *r.scene;
  try {
    const std::vector<int> placing = placing_joints(scene);
    joints_from_root(scene);
    check_placed_bodies(r, draft, placing);
    check_inertia(r, mechanisms, placing);
    check_holds(r, mechanisms, placing);
    MechanismStart placed = placed_start(scene);
    write_bodies(scene, placed);
    for (std::size_t i = 0; i < mechanisms.ropes.size(); ++i) {
      r.where = title("rope", scene.ropes[i].name);
      finish_rope(r, *mechanisms.ropes[i], scene.ropes[i]);
    }
    check_finite(r, mechanisms);
    check_rope_cycles(r, mechanisms);
    start_driven_closings(scene, mechanisms, placed);
    check_gaps(r, mechanisms, placed);
    exchange_driven_closings(r, mechanisms, placed);
    const Scene before = scene;
    project_start(scene, placed);
    require_bends(scene, placed);
    write_joints(scene, placed, false);
    write_bodies(scene, placed);
    write_joints(scene, placed_start(scene), true);
    note_changes(r, mechanisms, before, scene);
  } catch (const MechanismError& error) {
    fail_at(r, mechanisms, error);
  }
  check_limits(r, mechanisms);
}

void read_resolved_joints(Reading& r, const Value& list) {
  const auto* items = list.list();
  if (!items) fail_value(r, list, "a list");
  const std::string outer = r.where;
  std::vector<const Value*> holds;
  for (const Value& item : *items) {
    const Value* hold = nullptr;
    r.scene->joints.push_back(read_joint(r, item, hold));
    holds.push_back(hold);
  }
  for (std::size_t j = 0; j < holds.size(); ++j)
    if (holds[j]) read_hold(r, *holds[j], r.scene->joints[j]);
  r.where = outer;
  try {
    joints_from_root(*r.scene);
  } catch (const MechanismError& error) {
    fail(r, list.location, error.what());
  }
}

void read_resolved_ropes(Reading& r, const Value& list) {
  const auto* items = list.list();
  if (!items) fail_value(r, list, "a list");
  const std::string outer = r.where;
  for (const Value& item : *items) {
    Rope rope;
    rope.name = name_or_number(item, "rope", r.scene->ropes.size());
    r.where = title("rope", rope.name), r.key.clear();
    read_table(r, item, rope_keys(), {}, rope);
    finish_rope(r, item, rope);
    require_new_name(r, item, r.scene->ropes, rope.name);
    r.scene->ropes.push_back(std::move(rope));
  }
  r.where = outer;
}

}  // namespace atwood
