#include "mujoco/model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <iterator>
#include <stdexcept>

#include "mujoco/mechanism.hpp"
#include "mujoco/pair_laws.hpp"
#include "rivals/vector.hpp"
#include "rivals/world.hpp"

namespace atwood::mujoco {
namespace {

using rivals::operator*;

std::string text(const Real3& v) { return fmt::format("{} {} {}", v[0], v[1], v[2]); }
std::string text(const Real4& q) { return fmt::format("{} {} {} {}", q[0], q[1], q[2], q[3]); }

// The shortest rotation of z to a unit vector; for -z half a turn about x.
Real4 from_z_to(const Real3& n) {
  if (n[2] < -1 + 1e-12) return {0, 1, 0, 0};
  Real4 q{1 + n[2], -n[1], n[0], 0};
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2]);
  for (double& x : q) x /= norm;
  return q;
}

int dimension(double friction, double rolling_friction_m) { return rolling_friction_m > 0 ? 6 : friction > 0 ? 3 : 1; }

// Coefficients of sliding, spinning and rolling friction. The scene's law has no spinning friction; MuJoCo's smallest
// coefficient is 1e-5.
std::string coefficients(double friction, double rolling_friction_m) {
  return fmt::format("{} 0 {}", friction, rolling_friction_m);
}

class Writer {
 public:
  Writer(const Scene& scene, const Settings& settings, const std::vector<bool>& held)
      : scene_(scene), settings_(settings), held_(held), order_(precedences(scene)),
        placing_(rivals::placing_joints(scene)), collide_(rivals::shapes_matter(scene)) {
    children_.resize(scene.bodies.size());
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      const int parent = parent_of(i);
      if (parent >= 0) children_[static_cast<std::size_t>(parent)].push_back(i);
    }
  }

  ModelFiles write() {
    out("<mujoco>\n<compiler angle=\"radian\" inertiafromgeom=\"false\"/>\n");
    sizes();
    options();
    defaults();
    assets();
    out("<worldbody>\n");
    xml_ += rope_sites(scene_, -1);
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      if (collide_ && of_world(i)) geoms(i);
      if (parent_of(i) < 0) body(i);
    }
    out("</worldbody>\n");
    contact_pairs();
    xml_ += constraint_elements(scene_, settings_);
    out("</mujoco>\n");
    return {std::move(xml_), std::move(included_)};
  }

 private:
  template <class... Args> void out(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(xml_), format, std::forward<Args>(args)...);
  }
  double number(const char* name) const { return rivals::number(settings_, name); }
  std::string word(const char* name) const { return std::get<std::string>(settings_.at(name)); }

  // The body of whose element this body's is a part; -1: the world's.
  int parent_of(std::size_t i) const {
    if (placing_[i] < 0) return -1;
    const int parent = scene_.joints[static_cast<std::size_t>(placing_[i])].parent;
    return parent < 0 || scene_.bodies[static_cast<std::size_t>(parent)].fixed ? -1 : parent;
  }

  // A fixed plane's geom is the world's: MuJoCo 2.2 finds each contact twice with a plane of any other body.
  bool of_world(std::size_t i) const {
    return scene_.bodies[i].fixed && std::holds_alternative<Plane>(scene_.bodies[i].shape);
  }

  // MuJoCo's default size of the stack is 5 (rows + velocities)^2 numbers, which overflows an int beyond 20 000. Its
  // solvers were observed to use 3 velocities^2 numbers and a few rows.
  void sizes() {
    if (!collide_) return;
    const bool elliptic = word("cone") == "elliptic";
    int rows = 1;
    for (const auto& law : rivals::laws_in_play(scene_)) rows = std::max(rows, rows_of(law, elliptic));
    const std::int64_t contacts = room_for_contacts(scene_, settings_), n = contacts * rows + constraint_rows(scene_);
    const auto nv = 6 * static_cast<std::int64_t>(scene_.bodies.size());
    const std::int64_t guess = 5 * (n + nv) * (n + nv), seen = 5 * nv * nv + 200 * (n + nv) + 1000000;
    out("<size nconmax=\"{}\" njmax=\"{}\" nstack=\"{}\"/>\n", contacts, n, std::min(guess, seen));
  }

  void options() {
    out("<option gravity=\"{}\" integrator=\"{}\" cone=\"{}\" solver=\"{}\" jacobian=\"{}\" collision=\"{}\" "
        "iterations=\"{}\" tolerance=\"{}\" noslip_iterations=\"{}\" noslip_tolerance=\"{}\" impratio=\"{}\" "
        "mpr_iterations=\"{}\" mpr_tolerance=\"{}\">\n",
        text(scene_.gravity_m_per_s2), word("integrator"), word("cone"), word("solver"), word("jacobian"),
        order_ ? "all" : "predefined", rivals::count(settings_, "iterations"), number("tolerance"),
        rivals::count(settings_, "noslip_iterations"), number("noslip_tolerance"), number("impratio"),
        rivals::count(settings_, "mpr_iterations"), number("mpr_tolerance"));
    out("<flag warmstart=\"{}\" refsafe=\"{}\" multiccd=\"{}\" filterparent=\"disable\"/>\n</option>\n",
        on("warm_start"), on("refsafe"), on("multiccd"));
  }
  const char* on(const char* name) const { return rivals::flag(settings_, name) ? "enable" : "disable"; }

  std::string solver_words() const {
    return fmt::format("solref=\"{} {}\" solimp=\"{} {} {} {} {}\" margin=\"{}\" gap=\"{}\"",
                       number("solref_time_constant_s"), number("solref_damping_ratio"), number("solimp_least"),
                       number("solimp_most"), number("solimp_width_m"), number("solimp_midpoint"),
                       number("solimp_power"), number("margin_m"), number("gap_m"));
  }
  void defaults() {
    const std::string words = solver_words();
    out("<default><geom {}/><pair {}/></default>\n", words, words);
  }

  void assets() {
    if (!collide_) return;
    out("<asset>\n");
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      const auto* convex = std::get_if<Convex>(&scene_.bodies[i].shape);
      if (!convex) continue;
      out("<mesh name=\"m{}\" vertex=\"", i);
      for (const auto& point : convex->points_m) out("{} ", text(point));
      out("\"/>\n");
    }
    out("</asset>\n");
  }

  void body(std::size_t i) {
    const Body& b = scene_.bodies[i];
    Real3 position = b.position_m;
    Real4 attitude = b.orientation_wxyz;
    if (placing_[i] >= 0) {
      const Placement at = placement_at_zero(scene_, scene_.joints[static_cast<std::size_t>(placing_[i])]);
      position = at.p;
      attitude = at.q;
    }
    out("<body name=\"b{}\" pos=\"{}\" quat=\"{}\">", i, text(position), text(attitude));
    if (!b.fixed && !held_[i]) joints_and_inertia(i);
    if (collide_ && !of_world(i)) geoms(i);
    xml_ += rope_sites(scene_, static_cast<int>(i));
    for (const std::size_t child : children_[i]) child_of_body(child);
    out("</body>\n");
  }

  void child_of_body(std::size_t child) {
    constexpr int max_levels = 60;
    if (++level_ % max_levels != 0) {
      body(child);
    } else {
      const std::string name = fmt::format("below{}.xml", child);
      out("<include file=\"{}\"/>\n", name);
      std::string above = std::move(xml_);
      xml_ = "<mujocoinclude>\n";
      body(child);
      included_.emplace_back(name, xml_ + "</mujocoinclude>\n");
      xml_ = std::move(above);
    }
    --level_;
  }

  // A point mass that translates has slide joints along the world's axes, and any inertia. Below a turning body its own
  // is zero, which MuJoCo admits for bodies without joints.
  void joints_and_inertia(std::size_t i) {
    const Body& b = scene_.bodies[i];
    const bool placed = placing_[i] >= 0;
    if (placed) xml_ += joint_elements(scene_, settings_, placing_[i]);
    if (rotates(b)) {
      const auto axes = rivals::principal_axes(b.inertia_kg_m2);
      out("{}<inertial pos=\"0 0 0\" mass=\"{}\" quat=\"{}\" diaginertia=\"{}\"/>", placed ? "" : "<freejoint/>",
          b.mass_kg, text(axes.q_BP), text(axes.moments_kg_m2));
      return;
    }
    for (const Real3& axis : {Real3{1, 0, 0}, Real3{0, 1, 0}, Real3{0, 0, 1}}) {
      if (!placed) out("<joint type=\"slide\" axis=\"{}\"/>", text(rivals::to_body(b.orientation_wxyz, axis)));
    }
    const bool welded = placed && scene_.joints[static_cast<std::size_t>(placing_[i])].kind == JointKind::fixed;
    out("<inertial pos=\"0 0 0\" mass=\"{}\" diaginertia=\"{}\"/>", b.mass_kg, welded ? "0 0 0" : "1 1 1");
  }

  void geoms(std::size_t i) {
    const Body& b = scene_.bodies[i];
    std::string law = fmt::format("name=\"g{}\"", i);
    if (order_) {
      const Precedence& m = (*order_)[static_cast<std::size_t>(b.material)];
      law += fmt::format(" priority=\"{}\" condim=\"{}\" friction=\"{}\"", m.priority,
                         dimension(m.friction, m.rolling_friction_m), coefficients(m.friction, m.rolling_friction_m));
    }
    if (const auto* sphere = std::get_if<Sphere>(&b.shape)) {
      out("<geom type=\"sphere\" size=\"{}\" {}/>", sphere->radius_m, law);
    } else if (const auto* plane = std::get_if<Plane>(&b.shape)) {  // in world axes, for every pose of its body
      const double norm = rivals::length(plane->normal);
      const Real3 n = (1 / norm) * plane->normal;
      out("<geom type=\"plane\" size=\"0 0 1\" pos=\"{}\" quat=\"{}\" {}/>", text((plane->offset_m / norm) * n),
          text(from_z_to(n)), law);
    } else if (const auto* box = std::get_if<Box>(&b.shape)) {
      out("<geom type=\"box\" size=\"{}\" {}/>", text(box->half_extents_m), law);
    } else if (const auto* capsule = std::get_if<Capsule>(&b.shape)) {
      out("<geom type=\"capsule\" size=\"{} {}\" {}/>", capsule->radius_m, capsule->half_length_m, law);
    } else if (const auto* cylinder = std::get_if<Cylinder>(&b.shape)) {
      out("<geom type=\"cylinder\" size=\"{} {}\" {}/>", cylinder->radius_m, cylinder->half_length_m, law);
    } else if (std::holds_alternative<Convex>(b.shape)) {
      out("<geom type=\"mesh\" mesh=\"m{}\" {}/>", i, law);
    } else if (const auto* compound = std::get_if<Compound>(&b.shape)) {
      for (const auto& part : compound->boxes) {
        const std::size_t cut = law.find(' ');  // a name is for one geom
        out("<geom type=\"box\" size=\"{}\" pos=\"{}\" quat=\"{}\"{}/>", text(part.half_extents_m),
            text(part.position_body_m), text(part.orientation_wxyz), cut == std::string::npos ? "" : law.substr(cut));
      }
    }
  }

  void contact_pairs() {
    const std::string excluded = collide_ ? excluded_pairs(scene_) : "";
    if (order_ && excluded.empty()) return;
    out("<contact>\n");
    xml_ += excluded;
    if (!order_) listed_pairs();
    out("</contact>\n");
  }

  void listed_pairs() {
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      for (std::size_t j = i + 1; j < scene_.bodies.size(); ++j) {
        const Body &a = scene_.bodies[i], &b = scene_.bodies[j];
        if (!rivals::has_shape(a) || !rivals::has_shape(b) || (a.fixed && b.fixed)) continue;
        if (rivals::joined(scene_, static_cast<int>(i), static_cast<int>(j))) continue;
        const PairLaw& law = pair_law(scene_, static_cast<int>(i), static_cast<int>(j));
        out("<pair geom1=\"g{}\" geom2=\"g{}\" condim=\"{}\" friction=\"{} {} 0 {} {}\"/>\n", i, j,
            dimension(law.friction, law.rolling_friction_m), law.friction, law.friction, law.rolling_friction_m,
            law.rolling_friction_m);
      }
    }
  }

  const Scene& scene_;
  const Settings& settings_;
  const std::vector<bool>& held_;
  std::optional<std::vector<Precedence>> order_;
  std::vector<int> placing_;  // joint by body
  std::vector<std::vector<std::size_t>> children_;
  bool collide_ = false;
  int level_ = 0;  // of nested bodies
  std::string xml_;
  std::vector<std::pair<std::string, std::string>> included_;
};

}  // namespace

ModelFiles xml_of(const Scene& scene, const Settings& settings, const std::vector<bool>& held) {
  return Writer(scene, settings, held).write();
}

Model compile(const ModelFiles& files) {
  struct Folder {
    std::unique_ptr<mjVFS> held = std::make_unique<mjVFS>();
    Folder() { mj_defaultVFS(held.get()); }
    ~Folder() { mj_deleteVFS(held.get()); }
    void add(const std::string& name, const std::string& xml) {
      if (mj_makeEmptyFileVFS(held.get(), name.c_str(), static_cast<int>(xml.size())) != 0)
        throw std::invalid_argument("MuJoCo rejected a model file of " + std::to_string(xml.size()) + " bytes");
      std::memcpy(held->filedata[held->nfile - 1], xml.data(), xml.size());
    }
  } folder;
  folder.add("scene.xml", files.main);
  for (const auto& [name, xml] : files.included) folder.add(name, xml);
  char error[1000] = "";
  Model model(mj_loadXML("scene.xml", folder.held.get(), error, sizeof error));
  if (!model) {
    std::replace(std::begin(error), std::end(error), '\n', ' ');
    throw std::invalid_argument(std::string("MuJoCo's compiler says: ") + error);
  }
  return model;
}

int rows_of(const PairLaw& law, bool elliptic) {
  const int dim = dimension(law.friction, law.rolling_friction_m);
  return dim == 1 || elliptic ? dim : 2 * (dim - 1);
}

// For n rows and v velocities one buffer holds about 3/2 n^2 + 3 n v numbers, and its size in bytes is an int.
std::int64_t room_for_contacts(const Scene& scene, const Settings& settings) {
  const bool elliptic = std::get<std::string>(settings.at("cone")) == "elliptic";
  int rows = 1;
  for (const auto& law : rivals::laws_in_play(scene)) rows = std::max(rows, rows_of(law, elliptic));
  const auto bodies = std::count_if(scene.bodies.begin(), scene.bodies.end(),
                                    [](const Body& b) { return !b.fixed && rivals::has_shape(b); });
  const double v = 6.0 * static_cast<double>(scene.bodies.size()), numbers = 2.0e9 / 8;
  const double most_rows = std::sqrt(v * v + 2 * numbers / 3) - v;
  const auto most = static_cast<std::int64_t>(most_rows / rows);
  const std::int64_t wanted = std::max<std::int64_t>(100, rivals::count(settings, "contacts_per_body") * bodies);
  return most < 2 * bodies ? 0 : std::min(wanted, most);
}

std::int64_t listed_pairs(const Scene& scene) {
  std::int64_t moving = 0, fixed = 0;
  for (const auto& body : scene.bodies) {
    if (rivals::has_shape(body)) ++(body.fixed ? fixed : moving);
  }
  return moving * (moving - 1) / 2 + moving * fixed;
}

}  // namespace atwood::mujoco
