#include "validation/study/pose_file.hpp"

#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "protocol/sample.hpp"

namespace atwood {
namespace {

namespace fs = std::filesystem;

template <std::size_t n> std::string list(const std::array<double, n>& values) {
  std::string text = "[";
  for (const double value : values) text += (text.size() > 1 ? ", " : "") + format_double(value);
  return text + "]";
}

void write(const fs::path& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  out << text;
  if (!out.flush()) throw std::runtime_error(file.string() + ": cannot be written");
}

struct ShapeText {
  const fs::path& stem;
  const std::string& body;

  std::string operator()(const std::monostate&) const { return ""; }
  std::string operator()(const Sphere& s) const {
    return "shape.sphere = { radius_m = " + format_double(s.radius_m) + " }\n";
  }
  std::string operator()(const Plane& s) const {
    return "shape.plane = { normal = " + list(s.normal) + ", offset_m = " + format_double(s.offset_m) + " }\n";
  }
  std::string operator()(const Rectangle& s) const {
    return "shape.rectangle = { half_extents_m = " + list(s.half_extents_m) + " }\n";
  }
  std::string operator()(const Box& s) const {
    return "shape.box = { half_extents_m = " + list(s.half_extents_m) + " }\n";
  }
  static std::string round(const char* kind, double radius, double half) {
    return std::string("shape.") + kind + " = { radius_m = " + format_double(radius) +
           ", half_length_m = " + format_double(half) + " }\n";
  }
  std::string operator()(const Capsule& s) const { return round("capsule", s.radius_m, s.half_length_m); }
  std::string operator()(const Cylinder& s) const { return round("cylinder", s.radius_m, s.half_length_m); }
  std::string operator()(const Convex& s) const {
    std::string text = "shape.convex = { points_m = [";
    for (const Real3& p : s.points_m) text += list(p) + ", ";
    return text + "] }\n";
  }
  std::string operator()(const Mesh& s) const {
    std::string text;
    for (const Real3& p : s.points_m) {
      text += "v";
      for (const double x : p) text += " " + format_double(x);
      text += "\n";
    }
    for (const auto& t : s.triangles) {
      text += "f";
      for (const int corner : t) text += " " + std::to_string(corner + 1);
      text += "\n";
    }
    const std::string name = stem.filename().string() + "." + body + ".obj";
    write(stem.parent_path() / name, text);
    return "shape.mesh = { file = \"" + name + "\" }\n";
  }
  std::string operator()(const Compound& s) const {
    std::string text = "shape.compound = { boxes = [";
    for (const auto& part : s.boxes)
      text += "{ half_extents_m = " + list(part.half_extents_m) + ", position_body_m = " + list(part.position_body_m) +
              ", orientation_wxyz = " + list(part.orientation_wxyz) + " }, ";
    return text + "] }\n";
  }
};

}  // namespace

void write_pose_file(const std::string& file, const std::string& id, const std::string& claim, const Scene& scene,
                     double t_end_s) {
  const fs::path path(file);
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  fs::path stem = path;
  stem.replace_extension();
  std::string text = "id = \"" + id + "\"\ntitle = \"" + id + "\"\nclaim = \"" + claim + "\"\n" +
                     "source = \"A pose of geometry-sweep\"\n\n[run]\nt_end_s = " + format_double(t_end_s) +
                     "\nsteps = [1]\nsamples = 1\n\n[world]\ngravity_m_per_s2 = [0, 0, 0]\n";
  for (const Body& body : scene.bodies) {
    text += "\n[[body]]\nname = \"" + body.name + "\"\n" + std::visit(ShapeText{stem, body.name}, body.shape);
    if (body.fixed) {
      text += "fixed = true\n";
      continue;
    }
    text += "mass_kg = 1\ninertia_kg_m2 = [1, 1, 1]\nposition_m = " + list(body.position_m) +
            "\norientation_wxyz = " + list(body.orientation_wxyz) +
            "\nvelocity_m_per_s = " + list(body.velocity_m_per_s) +
            "\nangular_velocity_body_rad_per_s = " + list(body.angular_velocity_body_rad_per_s) + "\n";
  }
  write(path, text + "\n[truth]\nkind = \"none\"\n");
}

}  // namespace atwood
