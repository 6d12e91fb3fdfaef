// Reading of the worker protocol's JSON with limits: lines that nest too deeply, have too many members or values of an
// unexpected type throw Garbage, with a short message for every line. Private to this room.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "protocol/wire.hpp"

namespace atwood::wire {

using Json = nlohmann::ordered_json;

inline constexpr int kDeepestLine = 64;                          // containers within containers
inline constexpr std::size_t kMaxMembers = 4096;                 // of one object
inline constexpr std::size_t kMaxValues = std::size_t{1} << 20;  // held of one line outside of its long arrays
inline constexpr std::size_t kLongestText = std::size_t{64} << 10;

// At most 120 bytes of a text, with "..." if it was cut.
std::string cut(std::string_view text);
// A value in about 120 characters at most, without nested values: `"text"`, `7`, "an array of 3", "an object of a, b".
std::string excerpt(const Json& json);

// A whole request as a tree. Throws Garbage if it is no JSON object or nests deeper than kDeepestLine.
Json parse(std::string_view line);

// How a member of a line is read: as one value, as the elements of its array, or not at all.
enum class Reading { whole, by_element, ignored };
// Reads a line member by member, with one member, or one element of a long array, in memory at a time. `reading` is
// called at each key; `take` gets its value, or its elements in order. Throws Garbage if the line is no JSON object,
// has a member twice, nests too deeply or is too large; `take` may throw as well.
void read_members(std::string_view line, const std::function<Reading(const std::string& member)>& reading,
                  const std::function<void(const std::string& member, Json& value)>& take);

// ---- values, checked ----------------------------------------------------------------------------------------------
const Json& need(const Json& json, const char* key);
std::int64_t integer(const Json& json, const char* what);  // also as 10.0, for languages with one type of numbers
std::int64_t count(const Json& json, const char* what);    // an integer that is not negative
int index(const Json& json, const char* what);             // an integer that an int holds
std::string text(const Json& json, const char* what);      // cut at kLongestText
std::string text_or(const Json& json, const char* key, const std::string& otherwise);
const Json& array(const Json& json, const char* what, std::size_t size = 0);  // size 0: any
Wide number(const Json& json);  // a number, or a string when it is wider than double or not finite
double narrow_number(const Json& json);
void check_protocol(const Json& version, const char* whose);  // `whose`: "this worker", the side with kProtocol

// ---- writing ------------------------------------------------------------------------------------------------------
std::string dump(const Json& json);  // bytes that are not UTF-8 are replaced
// `object`, not empty, with `name` as its last member: a document that is JSON text already, such as a scene. It is
// not read and written again: with 10^5 bodies that takes 0.8 s, appending the text 0.03 s.
std::string with_document(const Json& object, const char* name, const std::string& document);
void append(std::string& line, Wide value);  // a number where a double holds it, else its text
Json json_number(Wide value);                // the same as a value

}  // namespace atwood::wire
