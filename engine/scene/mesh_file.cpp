// OBJ files: the lines `v x y z` and `f a b c ...`; normals, textures, groups and materials are ignored.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string_view>

#include "scene/declarations.hpp"
#include "scene/input_file.hpp"

namespace atwood {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail_line(const std::string& path, int line, std::string_view found, const std::string& expected) {
  throw InputError(path + ":" + std::to_string(line) + ":1: found `" + std::string(found.substr(0, 80)) +
                   "`; expected " + expected);
}

// The line up to the next line feed, and the next word of a line; what follows stays in `rest`. Nothing is copied: a
// file of one line may be as long as a file may be.
std::string_view take_line(std::string_view& rest) {
  const std::size_t end = std::min(rest.find('\n'), rest.size());
  const std::string_view line = rest.substr(0, end);
  rest.remove_prefix(std::min(end + 1, rest.size()));
  return line;
}

std::string_view take_word(std::string_view& rest) {
  constexpr const char* space = " \t\r\v\f";
  rest.remove_prefix(std::min(rest.find_first_not_of(space), rest.size()));
  const std::string_view word = rest.substr(0, rest.find_first_of(space));
  rest.remove_prefix(word.size());
  return word;
}

bool read_double(std::string_view word, double& out) {
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), out);
  return error == std::errc() && end == word.data() + word.size() && std::isfinite(out);
}

// `7`, `7/1`, `7//3`, `-1` (from the end): the index of a point, from 0; negative when it is none.
int corner_index(std::string_view word, std::size_t points) {
  long long index = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), index);
  if (error != std::errc() || (end != word.data() + word.size() && *end != '/')) return -1;
  const auto count = static_cast<long long>(points);
  if (index < 0) index += count + 1;
  return index < 1 || index > count ? -1 : static_cast<int>(index - 1);
}

}  // namespace

std::string path_in_folder(Reading& r, const Value& file) {
  const std::string* given = file.text();
  if (!given || given->empty()) fail_value(r, file, "the name of a file in the scene's folder");
  std::error_code error;
  const fs::path folder = fs::weakly_canonical(r.folder.empty() ? fs::path(".") : fs::path(r.folder), error);
  const fs::path full = fs::weakly_canonical(folder / *given, error);
  const fs::path inside = full.lexically_relative(folder);
  if (error || fs::path(*given).is_absolute() || inside.empty() || *inside.begin() == "..")
    fail_value(r, file, "a file inside the scene's folder " + folder.string());
  if (fs::exists(full, error) && !fs::is_regular_file(full, error))
    fail(r, file.location,
         "`" + r.key + "` in " + r.where + ": " + *given + " is " +
             (fs::is_fifo(full, error)        ? "a pipe"
              : fs::is_directory(full, error) ? "a folder"
                                              : "a device") +
             "; expected an ordinary file");
  if (!fs::is_regular_file(full, error)) fail_value(r, file, "a file that exists in " + folder.string());
  return full.string();
}

void load_mesh(Reading& r, const Value& file, Mesh& mesh) {
  constexpr std::size_t max_elements = 1 << 19;
  r.key = "file";
  const std::string path = path_in_folder(r, file);
  const std::string text = read_input_file(path, "meshes (OBJ)", largest::kMesh - r.mesh_bytes);
  r.mesh_bytes += text.size();
  std::string_view rest = text;
  for (int number = 1; !rest.empty(); ++number) {
    const std::string_view line = take_line(rest);
    std::string_view words = line;
    const std::string_view kind = take_word(words);
    if (kind == "v") {
      Real3 point{};
      for (double& x : point)
        if (!read_double(take_word(words), x)) fail_line(path, number, line, "`v x y z` with finite numbers");
      mesh.points_m.push_back(point);
    } else if (kind == "f") {
      std::vector<int> corners;
      for (std::string_view word = take_word(words); !word.empty() && corners.size() < max_elements + 3;
           word = take_word(words)) {
        corners.push_back(corner_index(word, mesh.points_m.size()));
        if (corners.back() < 0)
          fail_line(path, number, line, "indices of the " + std::to_string(mesh.points_m.size()) + " points above");
      }
      if (corners.size() < 3) fail_line(path, number, line, "at least three corners");
      for (std::size_t i = 2; i < corners.size(); ++i)
        mesh.triangles.push_back({corners[0], corners[i - 1], corners[i]});
    }
    if (r.mesh_points + mesh.points_m.size() > max_elements || r.mesh_triangles + mesh.triangles.size() > max_elements)
      fail_line(path, number, line,
                "at most " + std::to_string(max_elements) + " points and triangles in all meshes of a scene");
  }
  r.mesh_points += mesh.points_m.size();
  r.mesh_triangles += mesh.triangles.size();
  if (mesh.triangles.empty()) fail_value(r, file, "an OBJ file with at least one face");
}

}  // namespace atwood
