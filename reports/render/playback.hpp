// One scene in motion: the truth and any number of methods together, as one HTML file that opens without a network.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "protocol/truth.hpp"
#include "scene/scene.hpp"

namespace atwood {

// The motion of the truth or of one method. Curves have one entry a sample, or none where they are not known.
struct PlayedRun {
  std::string name;        // "truth", or the method's id
  std::string source;      // of a truth: its citation
  std::int64_t steps = 0;  // of the whole run; 0: a truth
  SampleSeries values;
  std::vector<Event> events;
  Outcome outcome;                                           // not ok: `values` end early
  std::vector<double> position_error_m, attitude_error_rad;  // largest of all bodies, against the truth
  std::vector<double> position_bar_m, attitude_bar_rad;      // of a truth alone
  std::vector<double> energy;                                // see `energy_title`
};

struct Playback {
  Scenario scenario;
  std::int64_t samples = 0;     // of the whole time: sample k is at t_end_s k / samples
  std::vector<PlayedRun> runs;  // the first is drawn solid, and the others are stored as differences from it
  bool truth = false;           // the first run is the truth
  std::string energy_title;     // what `energy` of the runs is
  std::string energy_unit;      // of it: "" relative to the scene's scale, or "J"
  std::string command;          // how the page was made
};

struct PlaybackPage {
  std::string html;
  std::size_t frames = 0;  // of the samples; fewer than samples + 1 where the page would be too large
  std::size_t particles_drawn = 0, particles = 0;
};

inline constexpr std::size_t kPlaybackLimit = 1'500'000;  // bytes of a page

// Samples are left out, evenly, until the page has at most kPlaybackLimit bytes or only nine are left.
PlaybackPage render_playback(const Playback& playback);

}  // namespace atwood
