// Recordings, truths and series as bytes for the store, without loss: 8 bytes per value where every value is a double,
// else 16 (quad). Little-endian.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

#include "protocol/truth.hpp"
#include "validation/metrics/fluid_picture.hpp"
#include "validation/metrics/metrics.hpp"
#include "validation/row.hpp"

namespace atwood {

// Thrown where bytes are not a valid recording.
struct BadBlob : std::runtime_error {
  using std::runtime_error::runtime_error;
};

std::string pack_samples(const SampleSeries& samples);
// The samples from number `from` to number `to`, without it.
std::string pack_samples(const SampleSeries& samples, std::size_t from, std::size_t to);
SampleSeries unpack_samples(std::string_view bytes);
void append_samples(std::string_view bytes, SampleSeries& samples);
std::string pack_events(const std::vector<Event>& events);
std::vector<Event> unpack_events(std::string_view bytes);
// What a recording has besides its own samples: the events, then the tallies of solver endings, then the further
// instants. Recordings that were stored before tallies or instants existed have none.
std::string pack_beside_samples(const Recording& recording, const std::map<std::string, SolveTally>& solvers);
void unpack_beside_samples(std::string_view bytes, Recording& recording);  // tallies: to its outcome
std::string pack_reals(const std::vector<double>& values);
std::vector<double> unpack_reals(std::string_view bytes);
std::string pack_series(const Series& series);
Series unpack_series(std::string_view bytes);
// The series, then the picture of a fluid where there is one.
std::string pack_series_and_picture(const Series& series, const FluidPicture& picture);
Series unpack_series_and_picture(std::string_view bytes, FluidPicture& picture);

}  // namespace atwood
