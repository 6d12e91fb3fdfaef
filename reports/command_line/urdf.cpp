#include "reports/command_line/urdf.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <pugixml.hpp>

#include "protocol/sample.hpp"
#include "scene/files.hpp"
#include "scene/input_file.hpp"
#include "scene/printable.hpp"

namespace atwood {
namespace {

constexpr std::size_t kLongestName = 128;

using Matrix = std::array<Real3, 3>;  // rows

Real3 times(const Matrix& m, const Real3& v) {
  Real3 out{};
  for (std::size_t i = 0; i < 3; ++i) out[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
  return out;
}
Matrix times(const Matrix& a, const Matrix& b) {
  Matrix out{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t k = 0; k < 3; ++k) out[i][j] += a[i][k] * b[k][j];
  return out;
}
Matrix transposed(const Matrix& m) {
  Matrix out{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) out[i][j] = m[j][i];
  return out;
}
Real3 plus(const Real3& a, const Real3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Real3 minus(const Real3& a, const Real3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

Real4 quaternion_product(const Real4& a, const Real4& b) {
  return {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
          a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
}
// Roll, pitch and yaw about the fixed axes x, y, z: R = Rz(yaw) Ry(pitch) Rx(roll).
Real4 from_rpy(const Real3& rpy) {
  const auto half = [&](std::size_t i) { return std::pair(std::cos(rpy[i] / 2), std::sin(rpy[i] / 2)); };
  const auto [cr, sr] = half(0);
  const auto [cp, sp] = half(1);
  const auto [cy, sy] = half(2);
  return quaternion_product({cy, 0, 0, sy}, quaternion_product({cp, 0, sp, 0}, {cr, sr, 0, 0}));
}
Matrix matrix_of(const Real4& q) {
  const auto& [w, x, y, z] = q;
  return {{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
           {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
           {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}}};
}

// A frame in another one: x -> p + R(q) x.
struct Frame {
  Real3 p{};
  Real4 q{1, 0, 0, 0};
};
Frame compose(const Frame& a, const Frame& b) {
  return {plus(a.p, times(matrix_of(a.q), b.p)), quaternion_product(a.q, b.q)};
}

struct Link {
  pugi::xml_node node;
  bool has_mass = false;
  double mass_kg = 0;
  Real3 center{};    // of mass, in the link's frame
  Matrix inertia{};  // about it, in the link's axes
  int joint = -1;    // that holds it; -1: the root
  // The scene body that it belongs to (an index of a link; -1: the world), and its frame in that link's frame.
  int owner = -1;
  Frame in_owner;
};
struct UrdfJoint {
  pugi::xml_node node;
  std::string name, type;
  int parent = -1, child = -1;
  Frame origin;
};

std::string numbers_text(const double* values, std::size_t count) {
  std::string list;
  for (std::size_t i = 0; i < count; ++i)
    list += (i == 0 ? "" : ", ") + format_double(values[i] == 0 ? 0.0 : values[i]);
  return "[" + list + "]";
}
template <std::size_t n> std::string text_of(const std::array<double, n>& v) { return numbers_text(v.data(), n); }

std::string in_quotes(const std::string& name) {
  std::string out = "\"";
  for (const char c : name) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

class Importer {
 public:
  Importer(std::string_view text, std::string file) : text_(text), file_(std::move(file)) {}

  ImportedScene run() {
    require_small_xml(text_, file_);
    const pugi::xml_parse_result parsed = document_.load_buffer(text_.data(), text_.size());
    if (!parsed) fail_at(parsed.offset, fmt::format("found no XML: {}; expected a URDF file", parsed.description()));
    robot_ = document_.child("robot");
    if (!robot_) fail_at(0, "found no <robot>; expected a URDF file");
    read_links();
    read_joints();
    order_tree();
    write();
    ImportedScene scene{header() + out_, notes_};
    check(scene);
    return scene;
  }

 private:
  [[noreturn]] void fail_at(std::ptrdiff_t offset, const std::string& what) const {
    const auto end = std::min(static_cast<std::size_t>(std::max<std::ptrdiff_t>(offset, 0)), text_.size());
    const auto line = 1 + std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(end), '\n');
    throw InputError(fmt::format("{}:{}: {}", file_, line, printable(what)));
  }
  [[noreturn]] void fail(pugi::xml_node node, const std::string& what) const { fail_at(node.offset_debug(), what); }
  template <class... Args> void note(fmt::format_string<Args...> format, Args&&... args) {
    notes_.push_back(printable(fmt::format(format, std::forward<Args>(args)...)));
  }
  template <class... Args> void out(fmt::format_string<Args...> format, Args&&... args) {
    out_ += fmt::format(format, std::forward<Args>(args)...);
  }

  // ---- values -----------------------------------------------------------------------------------------------------
  std::vector<double> numbers(pugi::xml_node node, const char* key, const std::string& value, std::size_t count) const {
    std::vector<double> found;
    const char* at = value.data();
    const char* end = at + value.size();
    while (at < end) {
      if (std::isspace(static_cast<unsigned char>(*at)) || *at == '+') {
        ++at;
        continue;
      }
      double x = 0;
      const auto [next, error] = std::from_chars(at, end, x);
      if (error != std::errc() || !std::isfinite(x)) break;
      found.push_back(x), at = next;
    }
    if (at < end || found.size() != count)
      fail(node, fmt::format("`{}` of <{}> is \"{}\"; expected {} number{}", key, node.name(), value, count,
                             count > 1 ? "s" : ""));
    return found;
  }
  double number(pugi::xml_node node, const char* key, std::optional<double> otherwise = std::nullopt) const {
    const pugi::xml_attribute attribute = node.attribute(key);
    if (!attribute && otherwise) return *otherwise;
    if (!attribute) fail(node, fmt::format("<{}> has no `{}`; expected a number", node.name(), key));
    return numbers(node, key, attribute.value(), 1)[0];
  }
  Real3 vector(pugi::xml_node node, const char* key, const Real3& otherwise) const {
    const pugi::xml_attribute attribute = node.attribute(key);
    if (!attribute) return otherwise;
    const auto v = numbers(node, key, attribute.value(), 3);
    return {v[0], v[1], v[2]};
  }
  Frame origin_of(pugi::xml_node node) const {
    const pugi::xml_node origin = node.child("origin");
    return {vector(origin, "xyz", {}), from_rpy(vector(origin, "rpy", {}))};
  }
  std::string name_of_node(pugi::xml_node node) const {
    const std::string name = node.attribute("name").value();
    if (name.empty()) fail(node, fmt::format("<{}> has no name", node.name()));
    if (name.size() > kLongestName)  // notes repeat it
      fail(node,
           fmt::format("<{}> has a name of {} bytes; expected at most {}", node.name(), name.size(), kLongestName));
    return name;
  }

  // ---- reading ------------------------------------------------------------------------------------------------------
  void name_others(pugi::xml_node node, const std::string& what, const std::set<std::string>& known) {
    std::map<std::string, int> others;
    for (const pugi::xml_node child : node.children())
      if (child.type() == pugi::node_element && !known.contains(child.name())) ++others[child.name()];
    for (const auto& [tag, count] : others)
      note("{}: <{}> is not taken{}", what, tag, count > 1 ? fmt::format(" ({} of them)", count) : "");
  }

  void read_links() {
    for (const pugi::xml_node node : robot_.children("link")) {
      const std::string name = name_of_node(node);
      if (!link_index_.emplace(name, static_cast<int>(links_.size())).second)
        fail(node, fmt::format("found the link `{}` a second time; expected each name once", name));
      Link link;
      link.node = node;
      name_others(node, fmt::format("link `{}`", name), {"inertial", "visual", "collision"});
      for (const char* kind : {"visual", "collision"})
        for (const pugi::xml_node shape : node.children(kind)) {
          const pugi::xml_node geometry = shape.child("geometry").first_child();
          const std::string mesh = geometry.attribute("filename").value();
          note("link `{}`: its {} shape ({}{}) is not taken", name, kind, geometry.name(),
               mesh.empty() ? "" : " " + mesh);
        }
      if (const pugi::xml_node inertial = node.child("inertial")) read_inertial(inertial, link);
      links_.push_back(link);
    }
    if (links_.empty()) fail(robot_, "found no <link>; expected at least two");
    name_others(robot_, "the robot", {"link", "joint"});
  }

  void read_inertial(pugi::xml_node node, Link& link) {
    const Frame origin = origin_of(node);
    link.mass_kg = number(node.child("mass"), "value", node.child("mass") ? std::nullopt : std::optional(0.0));
    if (link.mass_kg < 0) fail(node, "the mass of a link is negative");
    link.has_mass = link.mass_kg > 0;
    link.center = origin.p;
    const pugi::xml_node tensor = node.child("inertia");
    const auto entry = [&](const char* key) { return number(tensor, key, 0.0); };
    const Matrix own{{{entry("ixx"), entry("ixy"), entry("ixz")},
                      {entry("ixy"), entry("iyy"), entry("iyz")},
                      {entry("ixz"), entry("iyz"), entry("izz")}}};
    // Without a turn the file's own digits stay.
    const Matrix turn = matrix_of(origin.q);
    link.inertia = origin.q == Real4{1, 0, 0, 0} ? own : times(times(turn, own), transposed(turn));
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < i; ++j) link.inertia[i][j] = link.inertia[j][i];
  }

  int link_of(pugi::xml_node joint, const char* end) const {
    const std::string name = joint.child(end).attribute("link").value();
    const auto found = link_index_.find(name);
    if (found == link_index_.end())
      fail(joint, fmt::format("joint `{}` names the {} link `{}`, which is not there", joint.attribute("name").value(),
                              end, name));
    return found->second;
  }

  void read_joints() {
    static const std::set<std::string> types = {"revolute", "continuous", "prismatic", "fixed", "floating"};
    std::set<std::string> names;
    for (const pugi::xml_node node : robot_.children("joint")) {
      UrdfJoint joint;
      joint.node = node, joint.name = name_of_node(node), joint.type = node.attribute("type").value();
      if (!names.insert(joint.name).second) fail(node, fmt::format("found the joint `{}` a second time", joint.name));
      if (!types.contains(joint.type))
        fail(node,
             fmt::format("joint `{}` is of the type `{}`; expected revolute, continuous, prismatic, fixed or floating",
                         joint.name, joint.type));
      if (node.child("mimic"))
        fail(
            node,
            fmt::format(
                "joint `{}` mimics another joint, which no joint of a scene does; expected joints that move by themselves",
                joint.name));
      name_others(node, fmt::format("joint `{}`", joint.name),
                  {"parent", "child", "origin", "axis", "limit", "dynamics"});
      joint.parent = link_of(node, "parent"), joint.child = link_of(node, "child"), joint.origin = origin_of(node);
      int& holder = links_[static_cast<std::size_t>(joint.child)].joint;
      if (holder >= 0)
        fail(node, fmt::format("joint `{}` holds the link `{}`, which the joint `{}` holds already; expected a tree",
                               joint.name, node.child("child").attribute("link").value(),
                               joints_[static_cast<std::size_t>(holder)].name));
      holder = static_cast<int>(joints_.size());
      joints_.push_back(joint);
    }
  }

  // Links from the root on, with the body that each belongs to.
  void order_tree() {
    std::vector<int> roots;
    for (std::size_t i = 0; i < links_.size(); ++i)
      if (links_[i].joint < 0) roots.push_back(static_cast<int>(i));
    if (roots.size() != 1)
      fail(robot_, roots.empty() ? "the links make a cycle; expected a tree"
                                 : fmt::format("found {} links that no joint holds; expected one root", roots.size()));
    std::vector<std::vector<int>> children(links_.size());
    for (const UrdfJoint& joint : joints_) children[static_cast<std::size_t>(joint.parent)].push_back(joint.child);
    order_ = roots;
    for (std::size_t next = 0; next < order_.size(); ++next)
      for (const int child : children[static_cast<std::size_t>(order_[next])]) order_.push_back(child);
    if (order_.size() != links_.size()) fail(robot_, "some links make a cycle; expected a tree");
    const Link& root = links_[static_cast<std::size_t>(roots[0])];
    if (root.has_mass)
      note("the root link `{}` is held in the world; its mass is not taken", root.node.attribute("name").value());
    for (const int at : order_) place(at);
  }

  void place(int at) {
    Link& link = links_[static_cast<std::size_t>(at)];
    if (link.joint < 0) return;
    const UrdfJoint& joint = joints_[static_cast<std::size_t>(link.joint)];
    const Link& parent = links_[static_cast<std::size_t>(joint.parent)];
    const std::string name = link.node.attribute("name").value();
    const bool holds = joint.type == "fixed";
    if (holds && (parent.owner < 0 || !link.has_mass)) {
      link.owner = parent.owner;
      link.in_owner = compose(parent.in_owner, joint.origin);
      if (link.has_mass) note("link `{}` is fixed to the world; its mass is not taken", name);
      else note("link `{}` has no mass and is fixed to its parent; it becomes no body", name);
      return;
    }
    if (!link.has_mass)
      fail(link.node,
           fmt::format(
               "link `{}` moves by the joint `{}` and has no mass; expected an <inertial> with a mass and an inertia",
               name, joint.name));
    link.owner = at;
  }

  // ---- writing ------------------------------------------------------------------------------------------------------
  std::string link_name(int link) const {
    return link < 0 ? "world" : links_[static_cast<std::size_t>(link)].node.attribute("name").value();
  }

  std::string header() const {
    std::string lines = fmt::format("# Imported from {} (URDF).\n", printable(file_));
    if (!notes_.empty()) lines += "# Not taken, or changed:\n";
    for (const std::string& line : notes_) lines += "#   " + line + "\n";
    return lines;
  }

  void write() {
    std::string id;
    for (const char c : std::filesystem::path(file_).stem().string())
      if (std::isalnum(static_cast<unsigned char>(c)))
        id += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      else if (!id.empty() && id.back() != '-') id += '-';
    while (!id.empty() && id.back() == '-') id.pop_back();
    const std::string robot = printable(robot_.attribute("name").value());
    out("id = {}\ntitle = {}\nclaim = \"An imported mechanism.\"\nsource = {}\ntags = [\"mechanism\"]\n\n",
        in_quotes(id.empty() ? "imported" : id), in_quotes(robot.empty() ? "Imported" : robot),
        in_quotes(printable(file_)));
    out("[run]\nt_end_s = 1.0\nsteps = [250, 500, 1000, 2000, 4000]\nsamples = 50\n\n");
    out("[world]\ngravity_m_per_s2 = [0, 0, -9.81]\n\n");
    for (const int at : order_)
      if (links_[static_cast<std::size_t>(at)].owner == at) write_body(at);
    for (const int at : order_)
      if (links_[static_cast<std::size_t>(at)].owner == at)
        write_joint(joints_[static_cast<std::size_t>(links_[static_cast<std::size_t>(at)].joint)]);
    out("[truth]\nkind = \"extended\"\n");
  }

  // Where a body's joint holds it, in the frame of the parent's scene body.
  Frame frame_in_parent(const UrdfJoint& joint) const {
    return compose(links_[static_cast<std::size_t>(joint.parent)].in_owner, joint.origin);
  }

  void write_body(int at) {
    const Link& link = links_[static_cast<std::size_t>(at)];
    const UrdfJoint& joint = joints_[static_cast<std::size_t>(link.joint)];
    out("[[body]]\nname = {}\nmass_kg = {}\ninertia_kg_m2 = [{}, {}, {}]\n", in_quotes(link_name(at)),
        format_double(link.mass_kg), text_of(link.inertia[0]), text_of(link.inertia[1]), text_of(link.inertia[2]));
    if (joint.type == "floating") {
      if (links_[static_cast<std::size_t>(joint.parent)].owner >= 0)
        fail(joint.node, fmt::format("the floating joint `{}` has a moving parent; expected the root", joint.name));
      const Frame frame = frame_in_parent(joint);
      out("position_m = {}\norientation_wxyz = {}\n", text_of(plus(frame.p, times(matrix_of(frame.q), link.center))),
          text_of(frame.q));
    }
    out("\n");
  }

  void write_joint(const UrdfJoint& joint) {
    if (joint.type == "floating") return;
    const int parent = links_[static_cast<std::size_t>(joint.parent)].owner;
    const Link& child = links_[static_cast<std::size_t>(joint.child)];
    const Frame frame = frame_in_parent(joint);
    const Real3 parent_center = parent < 0 ? Real3{} : links_[static_cast<std::size_t>(parent)].center;
    const bool slides = joint.type == "prismatic", turns = joint.type == "revolute" || joint.type == "continuous";
    out("[[joint]]\nname = {}\nkind = \"{}\"\nbodies = [{}, {}]\n", in_quotes(joint.name),
        slides  ? "slider"
        : turns ? "hinge"
                : "fixed",
        in_quotes(link_name(parent)), in_quotes(link_name(joint.child)));
    out("anchors_body_m = [{}, {}]\nframe_wxyz = {}\n", text_of(minus(frame.p, parent_center)),
        text_of(minus(Real3{}, child.center)), text_of(frame.q));
    if (slides || turns) write_motion(joint, slides);
    out("\n");
    if (slides || turns) write_damping(joint, slides);
  }

  void write_motion(const UrdfJoint& joint, bool slides) {
    Real3 axis = vector(joint.node.child("axis"), "xyz", {1, 0, 0});
    const double length = std::hypot(axis[0], axis[1], axis[2]);
    if (!(length > 0)) fail(joint.node, fmt::format("the axis of joint `{}` is 0; expected a direction", joint.name));
    if (length != 1)
      for (double& x : axis) x /= length;
    out("axis_body = {}\n", text_of(axis));
    const pugi::xml_node limit = joint.node.child("limit");
    for (const char* key : {"effort", "velocity"})
      if (limit.attribute(key)) note("joint `{}`: the limit of its {} is not taken", joint.name, key);
    if (joint.type == "continuous") return;
    if (!limit)
      fail(joint.node, fmt::format("joint `{}` has no <limit>, which the type {} needs", joint.name, joint.type));
    const double lower = number(limit, "lower", 0.0), upper = number(limit, "upper", 0.0);
    if (!(lower < upper))
      fail(limit, fmt::format("joint `{}` has the limits {} and {}; expected the smaller one first", joint.name, lower,
                              upper));
    out("{} = [{}, {}]\n", slides ? "limits_m" : "limits_rad", format_double(lower), format_double(upper));
    if (lower <= 0 && 0 <= upper) return;
    const double start = lower > 0 ? lower : upper;
    out("{} = {}\n", slides ? "offset_m" : "angle_rad", format_double(start));
    note("joint `{}` starts at its limit {}: 0 is outside", joint.name, format_double(start));
  }

  void write_damping(const UrdfJoint& joint, bool slides) {
    const pugi::xml_node dynamics = joint.node.child("dynamics");
    if (number(dynamics, "friction", 0.0) != 0) note("joint `{}`: its friction is not taken", joint.name);
    const double damping = number(dynamics, "damping", 0.0);
    if (damping < 0) fail(dynamics, fmt::format("the damping of joint `{}` is negative", joint.name));
    if (damping > 0)
      out("[[force]]\nkind = \"joint-spring\"\njoint = {}\n{} = {}\n\n", in_quotes(joint.name),
          slides ? "damping_N_s_per_m" : "damping_N_m_s_per_rad", format_double(damping));
  }

  // What is written reads back as a scene.
  void check(const ImportedScene& scene) const {
    try {
      read_scenario_text(scene.toml, "the imported scene", ".");
    } catch (const InputError& error) {
      throw InputError(fmt::format("{}: no scene can be made of it: {}", file_, error.what()));
    }
  }

  std::string_view text_;
  std::string file_, out_;
  pugi::xml_document document_;
  pugi::xml_node robot_;
  std::vector<Link> links_;
  std::vector<UrdfJoint> joints_;
  std::map<std::string, int> link_index_;
  std::vector<int> order_;
  std::vector<std::string> notes_;
};

}  // namespace

ImportedScene import_urdf(std::string_view text, const std::string& name) { return Importer(text, name).run(); }

}  // namespace atwood
