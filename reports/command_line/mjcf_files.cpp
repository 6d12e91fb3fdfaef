#include "reports/command_line/mjcf_files.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <vector>

#include <fmt/format.h>
#include <pugixml.hpp>

#include "scene/files.hpp"
#include "scene/input_file.hpp"
#include "scene/printable.hpp"

namespace atwood {
namespace {

namespace fs = std::filesystem;

constexpr int kDeepestInclude = 16;
constexpr std::size_t kMaxIncluded = 256;         // files
constexpr std::size_t kMaxNamed = 10'000;         // files, the included ones among them
constexpr std::size_t kMaxFolders = 4;            // that <compiler> elements name, of one kind
constexpr std::size_t kLongestName = 1024;        // bytes
constexpr std::size_t kMaxNameBytes = 256 << 10;  // of all names: each part of a path is looked up
constexpr const char* kIncluded = "include";      // the element

// Text that two parsers may read in two ways is refused, so references (`&#47;`) are left as they are written.
constexpr unsigned kParsing = pugi::parse_cdata | pugi::parse_fragment | pugi::parse_doctype;

enum class Kind { model, texture, mesh, any };

// As MuJoCo looks it up: textures in the compiler's texturedir; meshes, height fields and skins in its meshdir; models
// beside the model. An element of another name may do either.
Kind kind_of(std::string_view element) {
  if (element == kIncluded || element == "model") return Kind::model;
  if (element == "texture") return Kind::texture;
  if (element == "mesh" || element == "hfield" || element == "skin") return Kind::mesh;
  return Kind::any;
}

// Attributes of numbers that a scene is made of; none of them is a name in any element. MuJoCo takes NaN for an
// attribute that is not given.
constexpr std::array<std::string_view, 27> kNumbers{
    "anchor",       "armature",    "axis",         "axisangle",    "boundinertia", "boundmass",   "damping",
    "density",      "diaginertia", "euler",        "frictionloss", "fromto",       "fullinertia", "gravity",
    "margin",       "mass",        "pos",          "quat",         "range",        "ref",         "relpose",
    "settotalmass", "size",        "springdamper", "springref",    "stiffness",    "viscosity"};

// The first word of a list of numbers that is one and is not finite; empty: none.
std::string not_finite(const std::string& list) {
  std::istringstream words(list);
  for (std::string word; words >> word;) {
    char* end = nullptr;
    const double number = std::strtod(word.c_str(), &end);
    if (*end == 0 && !std::isfinite(number)) return word;
  }
  return "";
}

struct NamedFile {
  Kind kind;
  std::string name, where;  // "arm.xml:12: <mesh>"
  fs::path beside;          // the folder of the file that names it
};

const char* words_of(mode_t mode) {
  if (S_ISDIR(mode)) return "a folder";
  if (S_ISFIFO(mode)) return "a pipe";
  return S_ISSOCK(mode) ? "a socket" : "a device";
}

struct Place {
  fs::path full;    // links followed; where nothing is there, as the path reads
  mode_t mode = 0;  // 0: nothing is there
  int error = 0;    // why it cannot be told
};

// The kernel walks the path, once; O_PATH opens nothing.
Place place_of(const fs::path& path) {
  const int file = open(path.c_str(), O_PATH | O_CLOEXEC);
  if (file < 0) {
    if (errno != ENOENT && errno != ENOTDIR) return {{}, 0, errno};
    return {path.lexically_normal(), 0, 0};
  }
  Place place;
  struct stat about {};
  if (fstat(file, &about) != 0) place.error = errno;
  place.mode = about.st_mode;
  std::error_code error;
  place.full = fs::read_symlink("/proc/self/fd/" + std::to_string(file), error);
  if (error) place.full = fs::canonical(path, error);  // without /proc
  close(file);
  if (error) place.error = error.value();
  return place;
}

// The line of places in a text that come in its order.
class Lines {
 public:
  explicit Lines(std::string_view text) : text_(text) {}
  std::ptrdiff_t of(std::ptrdiff_t offset) {
    const auto end = std::min(static_cast<std::size_t>(std::max<std::ptrdiff_t>(offset, 0)), text_.size());
    for (; at_ < end; ++at_) line_ += text_[at_] == '\n' ? 1 : 0;
    return line_;
  }

 private:
  std::string_view text_;
  std::size_t at_ = 0;
  std::ptrdiff_t line_ = 1;
};

class Model {
 public:
  explicit Model(const std::string& path) {
    const fs::path parent = fs::path(path).parent_path();
    folder_ = fs::weakly_canonical(parent.empty() ? fs::path(".") : parent);
  }

  void read(std::string_view text, const std::string& name, const fs::path& beside, int depth) {
    bytes_ += text.size();
    if (bytes_ > largest::kRobot)
      throw InputError(fmt::format("{}: with it the model has more than {} MiB of XML; expected less", name,
                                   largest::kRobot / largest::kMebibyte));
    require_small_xml(text, name);
    if (text.find('\0') != std::string_view::npos)
      throw InputError(fmt::format("{}: found a zero byte; expected text (MJCF)", name));
    pugi::xml_document document;
    const auto parsed = document.load_buffer(text.data(), text.size(), kParsing, pugi::encoding_utf8);
    if (!parsed)
      throw InputError(fmt::format("{}:{}: found no XML: {}; expected a model (MJCF)", name,
                                   Lines(text).of(parsed.offset), parsed.description()));
    Lines lines(text);
    std::vector<NamedFile> included;
    for (pugi::xml_node node = document.first_child(); node; node = next(node, document)) {
      const auto where = [&] {
        return fmt::format("{}:{}: <{}>", name, lines.of(node.offset_debug()), printable(node.name()));
      };
      if (node.type() == pugi::node_doctype)
        throw InputError(
            fmt::format("{}:{}: found a <!DOCTYPE>; expected a model without", name, lines.of(node.offset_debug())));
      if (std::string_view(node.name()) == "compiler") take_folders(node, where);
      for (const pugi::xml_attribute attribute : node.attributes()) {
        require_finite(attribute, node, where);
        if (!std::string_view(attribute.name()).starts_with("file") || *attribute.value() == 0) continue;
        NamedFile file{kind_of(node.name()), attribute.value(), where(), beside};
        if (++named_ > kMaxNamed)
          throw InputError(
              fmt::format("{}: more than {} files are named in total; expected fewer", file.where, kMaxNamed));
        require_plain(file.name, file.where);
        if (std::string_view(node.name()) == kIncluded) included.push_back(file);
        files_.push_back(std::move(file));
      }
    }
    for (const NamedFile& file : included) include(file, depth + 1);
  }

  // When all files are read, so that every <compiler> is known.
  void check() const {
    std::vector<NamedFile> files = files_;
    // With `strippath` MuJoCo looks for what follows the last separator.
    for (const NamedFile& file : files_)
      if (const std::size_t last = file.name.find_last_of("/\\"); last != std::string::npos) {
        files.push_back(file);
        files.back().name = file.name.substr(last + 1);
      }
    for (const NamedFile& file : files) {
      const bool any = file.kind == Kind::any;
      if (file.kind == Kind::model || any) require_beside(file);
      for (const auto* folders : {&mesh_folders_, &texture_folders_}) {
        if (!any && file.kind != (folders == &mesh_folders_ ? Kind::mesh : Kind::texture)) continue;
        if (folders->empty()) require_inside(file, folder_, "");
        for (const auto& [name, full] : *folders) require_inside(file, full, name);
      }
    }
  }

 private:
  // In the order of the text, without recursion.
  static pugi::xml_node next(pugi::xml_node node, const pugi::xml_node& root) {
    if (node.first_child()) return node.first_child();
    while (node && node != root && !node.next_sibling()) node = node.parent();
    return node && node != root ? node.next_sibling() : pugi::xml_node();
  }

  void require_plain(std::string_view name, const std::string& where) {
    const auto acts = [](char c) { return c == '&' || (static_cast<unsigned char>(c) < 0x20); };
    if (std::any_of(name.begin(), name.end(), acts))
      throw InputError(fmt::format("{} has a path with `&` or a control character; expected a plain one", where));
    if (name.size() > kLongestName)
      throw InputError(fmt::format("{} has a path of {} bytes; expected at most {}", where, name.size(), kLongestName));
    name_bytes_ += name.size();
    if (name_bytes_ > kMaxNameBytes)
      throw InputError(fmt::format("{}: the paths of the named files exceed {} bytes in total; expected fewer", where,
                                   kMaxNameBytes));
  }

  template <class Where>
  static void require_finite(pugi::xml_attribute attribute, pugi::xml_node node, const Where& where) {
    if (std::find(kNumbers.begin(), kNumbers.end(), attribute.name()) == kNumbers.end()) return;
    const std::string bad = not_finite(attribute.value());
    if (bad.empty()) return;
    const std::string name = node.attribute("name").value();
    throw InputError(fmt::format("{}{}: `{}` holds {}; expected finite numbers", where(),
                                 name.empty() ? "" : " `" + printable(name.substr(0, 200)) + "`", attribute.name(),
                                 printable(bad)));
  }

  template <class Where> void take_folders(pugi::xml_node compiler, const Where& where) {
    const auto take = [&](const char* own, std::map<std::string, fs::path>& folders) {
      for (const char* key : {"assetdir", own})  // both: which one MuJoCo takes depends on its version
        if (const pugi::xml_attribute folder = compiler.attribute(key)) {
          require_plain(folder.value(), where());
          if (folders.contains(folder.value())) continue;
          std::error_code error;
          folders.emplace(folder.value(), fs::weakly_canonical(folder_ / folder.value(), error));
          if (error || folders.size() > kMaxFolders)
            throw InputError(
                fmt::format("{}: `{}` {}", where(), folder.name(),
                            error ? "cannot be followed; expected a folder"
                                  : fmt::format("is one of more than {} folders; expected fewer", kMaxFolders)));
        }
    };
    take("meshdir", mesh_folders_);
    take("texturedir", texture_folders_);
  }

  void include(const NamedFile& file, int depth) {
    for (const fs::path& full : require_beside(file)) {
      std::error_code error;
      if (!fs::is_regular_file(full, error) || !included_.insert(full.string()).second) continue;
      if (depth > kDeepestInclude)
        throw InputError(fmt::format("{} is nested in {} other files; expected fewer", file.where, depth - 1));
      if (included_.size() > kMaxIncluded)
        throw InputError(
            fmt::format("{} is the {}th file that is included; expected fewer", file.where, included_.size()));
      read(read_input_file(full.string(), "a part of a model (MJCF)", largest::kRobot), full.string(),
           full.parent_path(), depth);
    }
  }

  // Beside the model, and beside the file that names it: where a version of MuJoCo looks for a part of a model.
  std::vector<fs::path> require_beside(const NamedFile& file) const {
    std::vector<fs::path> places{require_inside(file, folder_, "")};
    if (file.beside != folder_) places.push_back(require_inside(file, file.beside, ""));
    return places;
  }

  // The file's place, links followed.
  fs::path require_inside(const NamedFile& file, const fs::path& folder, const std::string& subfolder) const {
    const Place place = place_of(folder / file.name);
    if (place.error != 0)
      throw InputError(fmt::format("{} names {}, which cannot be followed ({}); expected a file inside {}", file.where,
                                   quoted(subfolder, file.name), std::strerror(place.error), folder_words()));
    const fs::path inside = place.full.lexically_relative(folder_);
    if (inside.empty() || *inside.begin() == "..")
      throw InputError(fmt::format("{} names {}, outside of the model's folder; expected a file inside {}", file.where,
                                   quoted(subfolder, file.name), folder_words()));
    if (place.mode != 0 && !S_ISREG(place.mode))
      throw InputError(fmt::format("{} names {}, which is {}; expected an ordinary file", file.where,
                                   quoted(subfolder, file.name), words_of(place.mode)));
    return place.full;
  }

  std::string folder_words() const { return printable(folder_.string()); }

  static std::string quoted(const std::string& subfolder, const std::string& name) {
    return printable("\"" + (fs::path(subfolder) / name).string().substr(0, 200) + "\"");
  }

  fs::path folder_;
  std::size_t bytes_ = 0, named_ = 0, name_bytes_ = 0;
  std::set<std::string> included_;
  std::map<std::string, fs::path> mesh_folders_, texture_folders_;  // as they are named, and where they are
  std::vector<NamedFile> files_;
};

}  // namespace

void require_files_in_folder(std::string_view text, const std::string& path) {
  Model model(path);
  const fs::path parent = fs::path(path).parent_path();
  model.read(text, path, fs::weakly_canonical(parent.empty() ? fs::path(".") : parent), 0);
  model.check();
}

}  // namespace atwood
