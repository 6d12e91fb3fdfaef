// The parts of a playback page: what is drawn (playback_scene.cpp) and how it moves (playback_motion.cpp).
#pragma once

#include "json_text.hpp"
#include "motion_blob.hpp"
#include "reports/render/playback.hpp"

namespace atwood {

// An object: bodies with their shapes, joints, ropes, forces that are drawn as arrows, fluids' names.
void append_played_scene(JsonText& json, const Scene& scene);

// How much of the motion goes along.
struct PlayedDetail {
  std::vector<std::size_t> samples;  // indices of the samples that become frames, rising, the first and last among them
  std::size_t particles = 3000;      // of a fluid, drawn in each run
  std::size_t particle_frames = 120;  // of them at most
};
struct DrawnParticles {
  std::size_t drawn = 0, all = 0;
};
// An array with one entry a run; numbers of the motion stand in `blob`, their offsets in `json`.
DrawnParticles append_played_runs(JsonText& json, MotionBlob& blob, const Playback& playback,
                                  const PlayedDetail& detail);

}  // namespace atwood
