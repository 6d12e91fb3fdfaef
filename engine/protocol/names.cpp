// Names of statuses and events in files and in the protocol.
#include <array>
#include <stdexcept>
#include <utility>

#include "protocol/sample.hpp"

namespace atwood {
namespace {

constexpr std::array<std::pair<Status, const char*>, 7> kStatuses{{{Status::ok, "ok"},
                                                                   {Status::unsupported, "unsupported"},
                                                                   {Status::diverged, "diverged"},
                                                                   {Status::not_finite, "not finite"},
                                                                   {Status::timeout, "timeout"},
                                                                   {Status::crashed, "crashed"},
                                                                   {Status::not_built, "not built"}}};
constexpr std::array<std::pair<EventKind, const char*>, 6> kEvents{{{EventKind::impact, "impact"},
                                                                    {EventKind::rest, "rest"},
                                                                    {EventKind::slip, "slip"},
                                                                    {EventKind::stick, "stick"},
                                                                    {EventKind::roll, "roll"},
                                                                    {EventKind::separate, "separate"}}};

template <class Table, class Value> std::string name_of(const Table& table, Value value) {
  for (const auto& [candidate, name] : table) {
    if (candidate == value) return name;
  }
  throw std::invalid_argument("no name for value " + std::to_string(static_cast<int>(value)));
}

template <class Table> auto value_of(const Table& table, const std::string& text, const std::string& what) {
  std::string expected;
  for (const auto& [value, name] : table) {
    if (text == name) return value;
    expected += expected.empty() ? name : std::string(", ") + name;
  }
  throw std::invalid_argument("unknown " + what + " `" + text + "`; expected one of " + expected);
}

}  // namespace

std::string to_string(Status status) { return name_of(kStatuses, status); }
Status status_from_string(const std::string& text) { return value_of(kStatuses, text, "status"); }
std::string to_string(EventKind kind) { return name_of(kEvents, kind); }
EventKind event_kind_from_string(const std::string& text) { return value_of(kEvents, text, "kind of event"); }

}  // namespace atwood
