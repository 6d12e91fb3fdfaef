// trace of a scene with mechanisms: joints and ropes as CSV.
#pragma once

#include "protocol/truth.hpp"
#include "scene/scene.hpp"

namespace atwood {

// Throws InputError where --joints or --ropes is asked of a scene without them.
void require_mechanism(const Scene& scene, const std::string& id, bool joints, bool ropes);

// t_s,joint,q0..q3,u0..u2,fx_N,fy_N,fz_N,tx_N_m,ty_N_m,tz_N_m,applied0..applied2,stop0..stop2 of every sample:
// coordinates (unwrapped), rates, the reaction on the child at its anchor in world axes, what springs, dampers and
// motors apply along each rate, and what the stop of a joint with limits does. Columns that the joint has not and what
// the method does not report are empty; components that the constraints leave open say `not unique`. With `json` the
// reaction in the child's axes as well. With `truth` (one of as many samples) a column of each value's bar, and the
// source.
void print_joints(const Scene& scene, const SampleSeries& values, const Truth* truth, int digits, bool json);

// t_s,rope,tension_N,pulley0_rad,... of every sample, as many pulleys as the rope with the most of them has.
void print_ropes(const Scene& scene, const SampleSeries& values, const Truth* truth, int digits, bool json);

}  // namespace atwood
