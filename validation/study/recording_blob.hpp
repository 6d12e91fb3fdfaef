// Recordings, truths and series as bytes for the store. Bit for bit: 8 bytes a value where every value is a double,
// 16 (quad) otherwise. Little-endian, as the machines this runs on.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

#include "protocol/truth.hpp"
#include "validation/metrics/metrics.hpp"
#include "validation/row.hpp"

namespace atwood {

// Bytes that are not what was written.
struct BadBlob : std::runtime_error {
  using std::runtime_error::runtime_error;
};

std::string pack_samples(const std::vector<Sample>& samples);
std::vector<Sample> unpack_samples(std::string_view bytes);
std::string pack_events(const std::vector<Event>& events);
std::vector<Event> unpack_events(std::string_view bytes);
// The events, and behind them how the solvers ended; of recordings that were stored before they were told, none.
std::string pack_events_and_solvers(const std::vector<Event>& events, const std::map<std::string, SolveTally>& solvers);
std::vector<Event> unpack_events_and_solvers(std::string_view bytes, std::map<std::string, SolveTally>& solvers);
std::string pack_reals(const std::vector<double>& values);
std::vector<double> unpack_reals(std::string_view bytes);
std::string pack_series(const Series& series);
Series unpack_series(std::string_view bytes);

}  // namespace atwood
