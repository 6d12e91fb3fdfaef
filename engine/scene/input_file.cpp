#include "scene/input_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <vector>

#include "scene/files.hpp"
#include "scene/system_fault.hpp"

namespace atwood {
namespace {

constexpr int kDeepestText = 64;
// Of TOML: toml++ and what is made of its tree take up to 3 microseconds a key and 0.5 a value. A body written out has
// 9 keys and 20 values; a list of a million instants is a scene's longest.
constexpr std::size_t kMaxTomlKeys = 300'000, kMaxTomlValues = 1'500'000;

constexpr std::size_t kMaxElements = 200'000, kMaxAttributes = 1'000'000;  // of XML

class Descriptor {
 public:
  explicit Descriptor(const std::string& path)
      : number_(open(path.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC)) {}
  ~Descriptor() {
    if (number_ >= 0) close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number() const { return number_; }

 private:
  int number_;
};

const char* kind_words(mode_t mode) {
  if (S_ISDIR(mode)) return "a directory";
  if (S_ISFIFO(mode)) return "a pipe";
  if (S_ISSOCK(mode)) return "a socket";
  return "a device";
}

std::string size_words(std::size_t bytes) { return std::to_string(bytes / largest::kMebibyte) + " MiB"; }

// Follows brackets and dotted keys through a text, and counts values by what stands before or between them. `open_`
// holds, for each bracket that is open, how many levels it stands for: itself, and the dots of the key in front of it.
class Nesting {
 public:
  Nesting(std::string_view text, const std::string& name, bool toml, const JsonBounds& most)
      : text_(text), name_(name), toml_(toml), most_(most) {}

  void check() {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '"' || (toml_ && c == '\'')) skip_string(c);
      else if (toml_ && c == '#') skip_line();
      else take(c);
    }
  }

 private:
  void take(char c) {
    if (c == '[' || c == '{' || c == ',') ++values_;
    if (toml_) count_key(c);
    if (c == '[' || c == '{') {
      open_.push_back(dots_ + 1);
      members_.push_back(0);
      depth_ += dots_ + 1;
      dots_ = 0;
    } else if (c == ']' || c == '}') {
      if (!open_.empty()) depth_ -= open_.back(), open_.pop_back(), members_.pop_back();
      dots_ = 0;
    } else if (c == ',' || c == '\n') {
      dots_ = 0;
    } else if (toml_ && c == '.') {
      ++dots_;
    } else if (!toml_ && c == ':' && !members_.empty()) {
      ++members_.back();
      values_ += 3;
    }
    if (depth_ + dots_ > kDeepestText)
      refuse("nesting deeper than " + std::to_string(kDeepestText) + " levels of brackets and dotted keys");
    if (keys_ > kMaxTomlKeys) refuse("more than " + std::to_string(kMaxTomlKeys) + " keys and tables");
    if (values_ > most_.values) refuse("more than " + std::to_string(most_.values) + " values");
    if (!members_.empty() && members_.back() > most_.members)
      refuse("more than " + std::to_string(most_.members) + " members in one object");
    ++at_;
  }

  // A key, or the name of a table, [a] or [[a]]: a line that begins with a bracket, outside of all others. Each dot
  // makes a table more.
  void count_key(char c) {
    if (c == '=' || (c == ']' && header_ > 0 && open_.size() == header_)) {
      keys_ += 1 + static_cast<std::size_t>(dots_);
      header_ = 0;
      assigned_ = true;
    } else if (c == '[' && !assigned_ && open_.size() == header_) {
      ++header_;
    } else if (c == '\n' && open_.empty()) {
      header_ = 0;
      assigned_ = false;
    }
  }

  bool starts(char quote, std::size_t count) const {
    return text_.size() - at_ >= count && text_.substr(at_, count) == std::string(count, quote);
  }

  // Past the closing quotes. Only TOML has three of them, and literal strings, in which a backslash is not an escape.
  void skip_string(char quote) {
    const std::size_t quotes = toml_ && starts(quote, 3) ? 3 : 1;
    at_ += quotes;
    while (at_ < text_.size() && !starts(quote, quotes)) {
      if (quotes == 1 && text_[at_] == '\n') return;  // never closed: no parser reads on from here
      at_ += text_[at_] == '\\' && quote == '"' ? 2 : 1;
    }
    at_ = std::min(at_ + quotes, text_.size());
    for (int extra = 0; quotes == 3 && extra < 2 && starts(quote, 1); ++extra) ++at_;  // """a""""" ends in two quotes
  }

  void skip_line() { at_ = std::min(text_.find('\n', at_), text_.size()); }

  [[noreturn]] void refuse(const std::string& what) const {
    const std::string_view before = text_.substr(0, at_);
    const auto line = 1 + std::count(before.begin(), before.end(), '\n');
    const std::string_view on_line = before.substr(before.rfind('\n') + 1);  // npos + 1 is 0
    const auto column = 1 + std::count_if(on_line.begin(), on_line.end(),
                                          [](char c) { return (static_cast<unsigned char>(c) & 0xc0u) != 0x80u; });
    throw InputError(name_ + ":" + std::to_string(line) + ":" + std::to_string(column) + ": found " + what +
                     "; expected fewer");
  }

  std::string_view text_;
  const std::string& name_;
  bool toml_;
  JsonBounds most_;
  std::size_t at_ = 0, keys_ = 0, values_ = 0;
  std::vector<int> open_;
  std::vector<std::size_t> members_;  // of each bracket that is open; JSON alone
  int depth_ = 0, dots_ = 0;
  std::size_t header_ = 0;  // brackets of a table's name that are open
  bool assigned_ = false;   // past the key on this line
};

}  // namespace

std::string read_input_file(const std::string& path, const std::string& expected, std::size_t most_bytes) {
  const std::string end = "; expected " + expected;
  const auto cannot = [&] {
    const int error = errno;
    const std::string what = path + ": cannot be read (" + std::strerror(error) + ")";
    if (is_system_fault(error)) throw std::runtime_error(what);
    throw InputError(what + end);
  };
  struct stat about {};
  // Before opening: to open a device can act on it.
  if (stat(path.c_str(), &about) == 0 && !S_ISREG(about.st_mode))
    throw InputError(path + ": found " + kind_words(about.st_mode) + end);
  const Descriptor file(path);
  if (file.number() < 0 || fstat(file.number(), &about) != 0) cannot();
  if (!S_ISREG(about.st_mode)) throw InputError(path + ": found " + kind_words(about.st_mode) + end);
  const auto too_large = [&](const std::string& found) {
    return InputError(path + ": found " + found + end + " of at most " + size_words(most_bytes));
  };
  if (about.st_size > 0 && static_cast<std::size_t>(about.st_size) > most_bytes)
    throw too_large(std::to_string(about.st_size) + " bytes");
  std::string text;
  text.reserve(static_cast<std::size_t>(about.st_size));
  std::vector<char> block(std::size_t{1} << 16);
  for (;;) {  // to its end, which may lie beyond the size of a moment ago, and files of /proc have none
    const ssize_t size = read(file.number(), block.data(), block.size());
    if (size < 0 && errno == EINTR) continue;
    if (size < 0) cannot();
    if (size == 0) return text;
    text.append(block.data(), static_cast<std::size_t>(size));
    if (text.size() > most_bytes) throw too_large("more than " + size_words(most_bytes));
  }
}

void require_small_xml(std::string_view text, const std::string& name) {
  std::size_t elements = 0, attributes = 0;
  std::ptrdiff_t line = 1;
  const auto count = [&](std::size_t& counted, std::size_t most, const char* what) {
    if (++counted > most)
      throw InputError(name + ":" + std::to_string(line) + ": found more than " + std::to_string(most) + " " + what +
                       "; expected fewer");
  };
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (text[at] == '\n') ++line;
    else if (text[at] == '=') count(attributes, kMaxAttributes, "attributes");
    else if (text[at] == '<' && (at + 1 == text.size() || text[at + 1] != '/'))
      count(elements, kMaxElements, "elements");
  }
}

void require_shallow_toml(std::string_view text, const std::string& name) {
  Nesting(text, name, true, {.values = kMaxTomlValues}).check();
}
void require_shallow_json(std::string_view text, const std::string& name, const JsonBounds& most) {
  Nesting(text, name, false, most).check();
}

}  // namespace atwood
