#include "protocol/json_lines.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <set>

namespace atwood::wire {
namespace {

constexpr std::size_t kExcerpt = 120;

// Counts brackets and members in one pass, so that the recursive parser only gets lines of limited depth, and its
// objects, which look for each new member among those before, are small.
void refuse_deep(std::string_view line) {
  std::array<std::size_t, kDeepestLine + 1> members{};  // of the bracket that is open at each depth
  std::size_t depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (in_string) {
      if (c == '\\') ++i;
      else if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '[' || c == '{') {
      if (++depth > kDeepestLine)
        throw Garbage("nested deeper than " + std::to_string(kDeepestLine) + " levels: " + cut(line));
      members[depth] = 0;
    } else if (c == ']' || c == '}') {
      if (depth > 0) --depth;
    } else if (c == ':' && ++members[depth] > kMaxMembers) {
      throw Garbage("more than " + std::to_string(kMaxMembers) + " members in an object: " + cut(line));
    }
  }
}

// The first bare NaN or infinity outside strings, as Python and JavaScript print it; empty: none.
std::string_view bare_number(std::string_view line) {
  constexpr std::string_view words[] = {"NaN", "nan", "-Infinity", "Infinity", "-inf", "inf"};
  bool in_string = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"') in_string = !in_string;
    else if (in_string && line[i] == '\\') ++i;
    else if (!in_string)
      for (const std::string_view word : words)
        if (line.substr(i, word.size()) == word) return word;
  }
  return {};
}

Garbage not_an_object(std::string_view line) {
  const std::string_view bare = line.starts_with('{') ? bare_number(line) : std::string_view{};
  if (bare.empty()) return Garbage("not a JSON object: " + cut(line));
  return Garbage(
      "not a JSON object: it holds a bare " + std::string(bare) +
      ", which is not JSON; write non-finite numbers as the strings \"nan\", \"inf\" and \"-inf\": " + cut(line));
}

// Builds one value at a time from the events of nlohmann's parser.
class MemberReader : public nlohmann::json_sax<Json> {
 public:
  MemberReader(const std::function<Reading(const std::string&)>& reading,
               const std::function<void(const std::string&, Json&)>& take)
      : reading_(reading), take_(take) {}

  bool null() override { return scalar(nullptr); }
  bool boolean(bool value) override { return scalar(value); }
  bool number_integer(number_integer_t value) override { return scalar(value); }
  bool number_unsigned(number_unsigned_t value) override { return scalar(value); }
  bool number_float(number_float_t value, const string_t&) override { return scalar(value); }
  bool string(string_t& value) override { return scalar(std::move(value)); }
  bool binary(binary_t&) override { return false; }
  bool start_object(std::size_t) override { return open(Json::value_t::object); }
  bool start_array(std::size_t) override { return open(Json::value_t::array); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }
  bool key(string_t& name) override {
    if (depth_ == 1) {
      if (!seen_.insert(name).second) throw Garbage("the member \"" + cut(name) + "\" twice in a line");
      if (seen_.size() > kMaxMembers) throw too_many_members();
      member_ = name;
      how_ = reading_(name);
      values_ = 0;
    } else if (!open_.empty()) {
      if (open_.back()->size() >= kMaxMembers) throw too_many_members();
      slot_ = &(*open_.back())[name];
    }
    return true;
  }
  bool parse_error(std::size_t, const std::string&, const nlohmann::detail::exception&) override { return false; }

 private:
  static Garbage too_many_members() {
    return Garbage("more than " + std::to_string(kMaxMembers) + " members in an object");
  }

  // The place of the next value: in the innermost open container, or a new root.
  Json* place(Json value) {
    if (++values_ > kMaxValues)
      throw Garbage("more than " + std::to_string(kMaxValues) + " values in \"" + cut(member_) + "\"");
    if (open_.empty()) {
      root_ = std::move(value);
      return &root_;
    }
    if (open_.back()->is_object()) {
      *slot_ = std::move(value);
      return slot_;
    }
    open_.back()->push_back(std::move(value));
    return &open_.back()->back();
  }
  bool kept() const { return how_ != Reading::ignored; }
  // Whether a value that ends now is complete for the caller: that of a member, or an element.
  bool at_root() const { return open_.empty() && depth_ == (how_ == Reading::by_element ? 2 : 1); }

  template <class Value> bool scalar(Value&& value) {
    if (depth_ == 0) return false;
    if (!kept()) return true;
    if (how_ == Reading::by_element && depth_ == 1) throw Garbage("\"" + cut(member_) + "\" is not an array");
    place(Json(std::forward<Value>(value)));
    hand_out();
    return true;
  }
  bool open(Json::value_t type) {
    const int outside = depth_++;
    if (outside == 0) return type == Json::value_t::object;
    if (!kept()) return true;
    if (how_ == Reading::by_element && outside == 1) {
      if (type != Json::value_t::array) throw Garbage("\"" + cut(member_) + "\" is not an array");
      return true;
    }
    open_.push_back(place(Json(type)));
    return true;
  }
  bool close() {
    --depth_;
    if (open_.empty()) return true;
    open_.pop_back();
    hand_out();
    return true;
  }
  void hand_out() {
    if (!at_root()) return;
    take_(member_, root_);
    if (how_ == Reading::by_element) values_ = 0;
  }

  const std::function<Reading(const std::string&)>& reading_;
  const std::function<void(const std::string&, Json&)>& take_;
  int depth_ = 0;
  std::set<std::string> seen_;
  std::string member_;
  Reading how_ = Reading::whole;
  std::size_t values_ = 0;
  Json root_;
  std::vector<Json*> open_;  // open containers of root_, outermost first
  Json* slot_ = nullptr;     // in the innermost object: the value of the last key
};

}  // namespace

// ---- messages -----------------------------------------------------------------------------------------------------
std::string cut(std::string_view text) {
  return std::string(text.substr(0, kExcerpt)) + (text.size() > kExcerpt ? "..." : "");
}

std::string excerpt(const Json& json) {
  if (json.is_array()) return json.empty() ? "an empty array" : "an array of " + std::to_string(json.size());
  if (json.is_string()) return "\"" + cut(json.get_ref<const std::string&>()) + "\"";
  if (!json.is_object()) return json.dump();
  std::string names;
  for (const auto& item : json.items()) {
    names += (names.empty() ? "" : ", ") + cut(item.key());
    if (names.size() > kExcerpt) break;
  }
  return names.empty() ? "an empty object" : "an object of " + cut(names);
}

// ---- lines --------------------------------------------------------------------------------------------------------
Json parse(std::string_view line) {
  refuse_deep(line);
  Json json = Json::parse(line, nullptr, false);
  if (json.is_discarded() || !json.is_object()) throw not_an_object(line);
  return json;
}

void read_members(std::string_view line, const std::function<Reading(const std::string&)>& reading,
                  const std::function<void(const std::string&, Json&)>& take) {
  refuse_deep(line);
  MemberReader reader(reading, take);
  if (!Json::sax_parse(line, &reader)) throw not_an_object(line);
}

// ---- values, checked ----------------------------------------------------------------------------------------------
const Json& need(const Json& json, const char* key) {
  const auto found = json.find(key);
  if (found == json.end()) throw Garbage("no \"" + std::string(key) + "\" in " + excerpt(json));
  return *found;
}

std::int64_t integer(const Json& json, const char* what) {
  constexpr auto most = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  const bool too_large = json.is_number_unsigned() && json.get<std::uint64_t>() > most;
  if (json.is_number_integer() && !too_large) return json.get<std::int64_t>();
  if (json.is_number_float() && std::floor(json.get<double>()) == json.get<double>() &&
      std::fabs(json.get<double>()) < 9e15) {
    return static_cast<std::int64_t>(json.get<double>());
  }
  throw Garbage("\"" + std::string(what) + "\" is not an integer: " + excerpt(json));
}

std::int64_t count(const Json& json, const char* what) {
  const std::int64_t value = integer(json, what);
  if (value < 0) throw Garbage("\"" + std::string(what) + "\" is negative: " + std::to_string(value));
  return value;
}

int index(const Json& json, const char* what) {
  const std::int64_t value = integer(json, what);
  if (value < std::numeric_limits<int>::min() || value > std::numeric_limits<int>::max())
    throw Garbage("\"" + std::string(what) + "\" is out of range: " + std::to_string(value));
  return static_cast<int>(value);
}

std::string text(const Json& json, const char* what) {
  if (!json.is_string()) throw Garbage("\"" + std::string(what) + "\" is not a string: " + excerpt(json));
  const auto& all = json.get_ref<const std::string&>();
  return all.size() <= kLongestText ? all : all.substr(0, kLongestText) + "...";
}

std::string text_or(const Json& json, const char* key, const std::string& otherwise) {
  return json.contains(key) ? text(json[key], key) : otherwise;
}

const Json& array(const Json& json, const char* what, std::size_t size) {
  if (!json.is_array() || (size > 0 && json.size() != size)) {
    throw Garbage("\"" + std::string(what) + "\" is not an array" + (size > 0 ? " of " + std::to_string(size) : "") +
                  ": " + excerpt(json));
  }
  return json;
}

Wide number(const Json& json) {
  if (json.is_number()) return json.get<double>();
  if (!json.is_string()) throw Garbage("a number or its text was expected, found " + excerpt(json));
  const auto& written = json.get_ref<const std::string&>();
  try {
    if (written.size() <= kExcerpt) return parse_wide(written);
  } catch (const std::invalid_argument&) {}
  throw Garbage("not a number: `" + cut(written) + "`");
}

double narrow_number(const Json& json) { return static_cast<double>(number(json)); }

void check_protocol(const Json& json, const char* whose) {
  const std::int64_t version = integer(json, "protocol");
  if (version != kProtocol)
    throw Garbage("protocol " + std::to_string(version) + "; " + whose + " speaks protocol " +
                  std::to_string(kProtocol));
}

// ---- writing ------------------------------------------------------------------------------------------------------
std::string dump(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

namespace {

std::string wide_text(Wide value) {
  const long double longer = static_cast<long double>(value);
  return format_number(value, static_cast<Wide>(longer) == value ? 21 : 36);
}

}  // namespace

std::string with_document(const Json& object, const char* name, const std::string& document) {
  std::string line = dump(object);
  line.pop_back();
  return line + ',' + dump(name) + ':' + document + '}';
}

void append(std::string& line, Wide value) {
  const double narrow = static_cast<double>(value);
  if (static_cast<Wide>(narrow) == value && std::isfinite(narrow)) {
    line += narrow == 0 && std::signbit(narrow) ? "-0.0" : format_double(narrow);  // "-0" is read as the integer 0
    return;
  }
  line += '"' + wide_text(value) + '"';
}

Json json_number(Wide value) {
  const double narrow = static_cast<double>(value);
  if (static_cast<Wide>(narrow) == value && std::isfinite(narrow)) return narrow;
  return wide_text(value);
}

}  // namespace atwood::wire
