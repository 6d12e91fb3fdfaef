#include "mujoco/import.hpp"

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <stdexcept>

#include "mujoco/import_notes.hpp"
#include "mujoco/model.hpp"
#include "protocol/sample.hpp"
#include "rivals/vector.hpp"

namespace atwood::mujoco {
namespace {

using rivals::operator+;
using rivals::operator-;
using rivals::operator*;

// A frame in another one: x -> p + q x.
struct Frame {
  Real3 p{};
  Real4 q{1, 0, 0, 0};
};
Frame operator*(const Frame& a, const Frame& b) {
  return {a.p + rivals::to_world(a.q, b.p), rivals::product(a.q, b.q)};
}
Real3 point_in(const Frame& frame, const Real3& x) { return frame.p + rivals::to_world(frame.q, x); }

Real3 real3(const mjtNum* v) { return {v[0], v[1], v[2]}; }
Real4 real4(const mjtNum* q) { return {q[0], q[1], q[2], q[3]}; }

// Shortest digits that give the double back; -0 as 0.
std::string text(double x) { return format_double(x == 0 ? 0.0 : x); }
template <std::size_t n> std::string text(const std::array<double, n>& v) {
  std::string list;
  for (const double x : v) list += (list.empty() ? "" : ", ") + text(x);
  return "[" + list + "]";
}
std::string in_quotes(const std::string& name) {
  std::string escaped;
  for (const char c : name) {
    if (c == '"' || c == '\\') escaped += '\\';
    escaped += static_cast<unsigned char>(c) < 32 ? ' ' : c;
  }
  return "\"" + escaped + "\"";
}

std::string one_line(std::string message) {
  std::replace_if(
      message.begin(), message.end(), [](char c) { return static_cast<unsigned char>(c) < 32; }, ' ');
  return message;
}

// The first warning of a load: MuJoCo's handlers take no argument of the caller's.
std::string warning;
void hear(const char* text) {
  if (warning.empty()) warning = one_line(text);
}

[[noreturn]] void refuse(const std::string& reason) { throw std::invalid_argument(reason); }

class Importer {
 public:
  Importer(const mjModel& model, std::string file) : m_(model), file_(std::move(file)) {}

  ImportedScene run() {
    place_bodies();
    if (std::all_of(owner_.begin(), owner_.end(), [](int owner) { return owner == 0; }))
      refuse("found no body that moves; expected a <body> with a mass and a joint");
    world();
    for (int b = 1; b < m_.nbody; ++b) body(b);
    for (int b = 1; b < m_.nbody; ++b) joints(b);
    closings();
    remaining();
    return {header() + out_, notes_};
  }

 private:
  template <class... Args> void out(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(out_), format, std::forward<Args>(args)...);
  }
  template <class... Args> void note(fmt::format_string<Args...> format, Args&&... args) {
    notes_.push_back(one_line(fmt::format(format, std::forward<Args>(args)...)));
  }
  void note_all(const std::vector<std::string>& notes) {
    for (const std::string& each : notes) note("{}", each);
  }
  std::string name_of(int type, int id, const char* kind) const { return mujoco::name_of(m_, type, id, kind); }
  std::string body_word(int b) const {
    return owner_[static_cast<std::size_t>(b)] == 0 ? "world" : body_name(owner_[static_cast<std::size_t>(b)]);
  }
  std::string body_name(int b) const {
    const std::string name = name_of(mjOBJ_BODY, b, "body");
    return name == "world" ? "world-body" : name;
  }

  // owner_[b]: MuJoCo's body whose scene body b belongs to, 0: the world. frame_[b]: b's frame in the scene body's,
  // whose origin is the centre of mass and whose axes are those of MuJoCo's body.
  void place_bodies() {
    owner_.assign(static_cast<std::size_t>(m_.nbody), 0);
    frame_.assign(static_cast<std::size_t>(m_.nbody), {});
    for (int b = 1; b < m_.nbody; ++b) {
      const auto i = static_cast<std::size_t>(b), parent = static_cast<std::size_t>(m_.body_parentid[b]);
      const bool jointless = m_.body_jntnum[b] == 0;
      if (jointless && (owner_[parent] == 0 || m_.body_mass[b] == 0)) {
        owner_[i] = owner_[parent];
        frame_[i] = frame_[parent] * Frame{real3(m_.body_pos + 3 * b), real4(m_.body_quat + 4 * b)};
        if (owner_[parent] == 0 && m_.body_mass[b] > 0)
          note("body {} is fixed to the world and a part of it", body_name(b));
      } else {
        owner_[i] = b;
        frame_[i] = {-1.0 * real3(m_.body_ipos + 3 * b), {1, 0, 0, 0}};
      }
    }
  }

  std::string header() const {
    std::string lines = fmt::format("# Imported from {} through MuJoCo {}.\n", one_line(file_), mj_versionString());
    if (!notes_.empty()) lines += "# Not taken, or changed:\n";
    for (const std::string& line : notes_) lines += "#   " + line + "\n";
    return lines;
  }

  void world() {
    std::string id;
    for (const char c : std::filesystem::path(file_).stem().string())
      id += std::isalnum(static_cast<unsigned char>(c)) ? static_cast<char>(std::tolower(static_cast<unsigned char>(c)))
                                                        : '-';
    out("id = {}\ntitle = {}\nclaim = \"An imported mechanism.\"\nsource = {}\n\n",
        in_quotes(id.empty() ? "imported" : id), in_quotes("Imported from " + file_), in_quotes(file_));
    out("[run]\nt_end_s = 1.0\nsteps = [250, 500, 1000, 2000, 4000]\nsamples = 50\n\n[truth]\nkind = \"extended\"\n\n");
    const bool weightless = disabled(m_, mjDSBL_GRAVITY);
    out("[world]\ngravity_m_per_s2 = {}\n\n", text(weightless ? Real3{} : real3(m_.opt.gravity)));
  }

  void body(int b) {
    if (owner_[static_cast<std::size_t>(b)] != b) return;
    out("[[body]]\nname = {}\nmass_kg = {}\n", in_quotes(body_name(b)), text(m_.body_mass[b]));
    const Real3 moments = real3(m_.body_inertia + 3 * b);
    const Real4 principal = real4(m_.body_iquat + 4 * b);
    if (principal == Real4{1, 0, 0, 0}) {
      out("inertia_kg_m2 = {}\n", text(moments));
    } else {
      ++turned_inertias_;
      const Real33 r = rivals::matrix_of(principal);
      Real33 inertia{};
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          for (int k = 0; k < 3; ++k)
            inertia[3 * std::min(i, j) + std::max(i, j)] += i <= j ? r[3 * i + k] * moments[k] * r[3 * j + k] : 0;
      const auto at = [&](int i, int j) { return inertia[3 * std::min(i, j) + std::max(i, j)]; };
      out("inertia_kg_m2 = [{}, {}, {}]\n", text(Real3{at(0, 0), at(0, 1), at(0, 2)}),
          text(Real3{at(1, 0), at(1, 1), at(1, 2)}), text(Real3{at(2, 0), at(2, 1), at(2, 2)}));
    }
    const int first = m_.body_jntadr[b];
    if (m_.body_jntnum[b] == 1 && m_.jnt_type[first] == mjJNT_FREE) {
      const mjtNum* q = m_.qpos0 + m_.jnt_qposadr[first];
      const Frame pose{real3(q), real4(q + 3)};
      out("position_m = {}\norientation_wxyz = {}\n", text(point_in(pose, real3(m_.body_ipos + 3 * b))), text(pose.q));
    }
    out("\n");
  }

  // The kind of the joints of one body, and MuJoCo's joint of each coordinate.
  struct Found {
    std::string kind;
    std::vector<int> joints;
  };
  Found kind_of(int b) const {
    const int first = m_.body_jntadr[b], count = m_.body_jntnum[b];
    const auto type = [&](int j) { return m_.jnt_type[j]; };
    if (count == 0) return {"fixed", {}};
    if (count == 1) {
      const char* kinds[] = {"free", "ball", "slider", "hinge"};  // mjJNT_FREE, BALL, SLIDE, HINGE
      return {kinds[type(first)], {first}};
    }
    const int second = first + 1;
    if (count == 2) {
      const Real3 a = real3(m_.jnt_axis + 3 * first), c = real3(m_.jnt_axis + 3 * second);
      const Real3 apart = real3(m_.jnt_pos + 3 * second) - real3(m_.jnt_pos + 3 * first);
      const bool hinges = type(first) == mjJNT_HINGE && type(second) == mjJNT_HINGE;
      if (hinges && rivals::length(apart) < 1e-12 && std::abs(rivals::dot(a, c)) < 1e-12)
        return {"universal", {first, second}};
      const bool mixed = type(first) + type(second) == mjJNT_HINGE + mjJNT_SLIDE && type(first) != type(second);
      if (mixed && rivals::length(rivals::cross(a, c)) < 1e-12) {
        const bool hinge_first = type(first) == mjJNT_HINGE;
        return {"cylindrical", {hinge_first ? first : second, hinge_first ? second : first}};
      }
    }
    std::string list;
    for (int j = first; j < first + count; ++j) list += (list.empty() ? "" : ", ") + name_of(mjOBJ_JOINT, j, "joint");
    refuse(
        fmt::format("the body {} has {} joints ({}); expected one, or two that are a universal or a cylindrical joint: "
                    "a scene's body has one joint, and bodies between several would have no mass",
                    body_name(b), count, list));
  }

  void joints(int b) {
    if (owner_[static_cast<std::size_t>(b)] != b) return;
    const Found found = kind_of(b);
    for (const int j : found.joints) note_all(joint_notes(m_, j, found.joints.size() == 1));
    if (found.kind == "free") return;
    const std::string joint =
        found.joints.empty() ? "fixed-" + body_name(b) : name_of(mjOBJ_JOINT, found.joints[0], "joint");
    const auto parent = static_cast<std::size_t>(m_.body_parentid[b]);
    // MuJoCo's body b at qpos0 in its parent's frame, then in the scene body's.
    Frame at = frame_[parent] * Frame{real3(m_.body_pos + 3 * b), real4(m_.body_quat + 4 * b)};
    const Real3 in_body = found.joints.empty() ? real3(m_.body_ipos + 3 * b) : real3(m_.jnt_pos + 3 * found.joints[0]);
    Real3 anchor = point_in(at, in_body);
    out("[[joint]]\nname = {}\nkind = \"{}\"\nbodies = [{}, {}]\n", in_quotes(joint), found.kind,
        in_quotes(body_word(m_.body_parentid[b])), in_quotes(body_name(b)));
    std::vector<double> start;
    for (const int j : found.joints) start.push_back(m_.qpos0[m_.jnt_qposadr[j]]);
    const Real3 axis = found.joints.empty() ? Real3{} : real3(m_.jnt_axis + 3 * found.joints[0]);
    if (found.kind == "hinge") {
      at.q = rivals::product(at.q, {std::cos(start[0] / 2), -std::sin(start[0] / 2) * axis[0],
                                    -std::sin(start[0] / 2) * axis[1], -std::sin(start[0] / 2) * axis[2]});
      out("axis_body = {}\nangle_rad = {}\n", text(axis), text(start[0]));
    } else if (found.kind == "slider") {
      anchor = anchor - start[0] * rivals::to_world(at.q, axis);
      out("axis_body = {}\noffset_m = {}\n", text(axis), text(start[0]));
    } else if (found.kind == "universal" || found.kind == "cylindrical") {
      if (start[0] != 0 || start[1] != 0)
        refuse("the body " + body_name(b) + " has two joints and a ref; expected ref = 0 for both");
      if (found.kind == "universal")
        out("axes_body = [{}, {}]\n", text(rivals::to_world(at.q, axis)),
            text(real3(m_.jnt_axis + 3 * found.joints[1])));
      else two_axes(found, axis);
    }
    out("anchors_body_m = [{}, {}]\n", text(anchor), text(in_body - real3(m_.body_ipos + 3 * b)));
    if (at.q != Real4{1, 0, 0, 0}) out("frame_wxyz = {}\n", text(at.q));
    ranges(found);
    out("\n");
    for (std::size_t k = 0; k < found.joints.size(); ++k) passive(found, joint, k);
  }

  // The slide's axis may point against the hinge's: then its offset has the other sign, which is not taken.
  void two_axes(const Found& found, const Real3& axis) {
    if (rivals::dot(axis, real3(m_.jnt_axis + 3 * found.joints[1])) < 0)
      refuse("the slide " + name_of(mjOBJ_JOINT, found.joints[1], "joint") +
             " points against the hinge of its body; expected the same axis");
    out("axis_body = {}\n", text(axis));
  }

  void ranges(const Found& found) {
    if (found.kind != "hinge" && found.kind != "slider") return;
    const int j = found.joints[0];
    if (!m_.jnt_limited[j] || disabled(m_, mjDSBL_LIMIT)) return;
    ++stops_;
    out("limits_{} = {}\n", found.kind == "hinge" ? "rad" : "m",
        text(Real2{m_.jnt_range[2 * j], m_.jnt_range[2 * j + 1]}));
  }

  void passive(const Found& found, const std::string& joint, std::size_t k) {
    const int j = found.joints[k], type = m_.jnt_type[j];
    const double stiffness = m_.jnt_stiffness[j], damping = m_.dof_damping[m_.jnt_dofadr[j]];
    if (disabled(m_, mjDSBL_PASSIVE)) return;
    if (damping == 0 && (stiffness == 0 || type == mjJNT_BALL)) return;
    const bool slide = type == mjJNT_SLIDE;
    out("[[force]]\nkind = \"joint-spring\"\njoint = {}\n", in_quotes(joint));
    if (found.joints.size() == 2) out("coordinate = {}\n", k);
    if (type != mjJNT_BALL) {
      out("{} = {}\n", slide ? "stiffness_N_per_m" : "stiffness_N_m_per_rad", text(stiffness));
      if (stiffness != 0) out("{} = {}\n", slide ? "rest_m" : "rest_rad", text(m_.qpos_spring[m_.jnt_qposadr[j]]));
    }
    if (damping != 0) out("{} = {}\n", slide ? "damping_N_s_per_m" : "damping_N_m_s_per_rad", text(damping));
    out("\n");
  }

  void closings() {
    if (disabled(m_, mjDSBL_EQUALITY)) return;
    for (int e = 0; e < m_.neq; ++e) {
      const std::string name = name_of(mjOBJ_EQUALITY, e, "equality");
      const int type = m_.eq_type[e];
      if (!m_.eq_active[e]) {
        note("the equality constraint {}, which is not active", name);
        continue;
      }
      if (type != mjEQ_CONNECT && type != mjEQ_WELD)
        refuse("the equality constraint " + name + " couples joints or tendons; expected connect or weld");
      const mjtNum* data = m_.eq_data + mjNEQDATA * e;
      const bool weld = type == mjEQ_WELD;
      int bodies[2] = {m_.eq_obj1id[e], m_.eq_obj2id[e]};
      Real3 points[2] = {real3(data + (weld ? 3 : 0)), real3(data + (weld ? 0 : 3))};
      Real4 turn = weld ? real4(data + 6) : Real4{1, 0, 0, 0};  // of the second body in the first
      if (owner_[static_cast<std::size_t>(bodies[1])] == 0) {   // the child is the one that moves
        std::swap(bodies[0], bodies[1]);
        std::swap(points[0], points[1]);
        turn = rivals::conjugate(turn);
      }
      if (owner_[static_cast<std::size_t>(bodies[0])] == owner_[static_cast<std::size_t>(bodies[1])])
        refuse("the equality constraint " + name + " ties a body to itself");
      const Frame &first = frame_[static_cast<std::size_t>(bodies[0])],
                  &second = frame_[static_cast<std::size_t>(bodies[1])];
      out("[[joint]]\nname = {}\nkind = \"{}\"\ncloses_loop = true\nbodies = [{}, {}]\nanchors_body_m = [{}, {}]\n",
          in_quotes(name), weld ? "fixed" : "ball", in_quotes(body_word(bodies[0])), in_quotes(body_word(bodies[1])),
          text(point_in(first, points[0])), text(point_in(second, points[1])));
      const Real4 frame = rivals::product(first.q, rivals::product(turn, rivals::conjugate(second.q)));
      if (weld && frame != Real4{1, 0, 0, 0}) out("frame_wxyz = {}\n", text(frame));
      out("\n");
      ++closings_;
    }
  }

  void remaining() {
    if (turned_inertias_ > 0)
      note(
          "{} inertias about turned axes: MuJoCo finds the principal axes of a `fullinertia`, or of geoms, to "
          "some 1e-8 of the largest moment",
          turned_inertias_);
    note_all(remaining_notes(m_));
    note_all(flag_notes(m_));
    if (!warning.empty()) note("MuJoCo's parser warns: {}", warning);
    if (stops_ > 0) note("MuJoCo's soft limits became stops without restitution");
    if (closings_ > 0) note("MuJoCo's soft equality constraints became joints that close loops exactly");
  }

  const mjModel& m_;
  std::string file_, out_;
  std::vector<std::string> notes_;
  std::vector<int> owner_;
  std::vector<Frame> frame_;
  int turned_inertias_ = 0, stops_ = 0, closings_ = 0;
};

// An attribute that is NaN counts for MuJoCo as one that is not given, so that the model need not show it.
void require_finite(const mjModel& model) {
  if (const std::string bad = not_finite(model); !bad.empty()) refuse(bad + "; expected a finite number");
  if (warning.find("NaN") != std::string::npos) refuse("MuJoCo's parser warns: " + warning);
}

}  // namespace

Result<ImportedScene> import_model(const std::string& path) {
  if (!std::filesystem::is_regular_file(path)) return Fault{path + ": no such file"};
  warning.clear();
  mju_user_warning = hear;  // MuJoCo's own handlers write a file, and end the process
  mju_user_error = [](const char* message) { refuse(std::string("MuJoCo gave up: ") + message); };
  char error[1000] = "";
  try {
    const Model model(mj_loadXML(path.c_str(), nullptr, error, sizeof error));
    if (!model) return Fault{path + ": MuJoCo's compiler says: " + one_line(error)};
    require_finite(*model);
    return Importer(*model, std::filesystem::path(path).filename().string()).run();
  } catch (const std::invalid_argument& refused) {
    return Fault{path + ": " + refused.what()};
  }
}

}  // namespace atwood::mujoco
