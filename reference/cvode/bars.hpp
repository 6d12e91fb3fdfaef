// Runs and bars of CVODE's truths, with and without joints.
#pragma once

namespace atwood::cvode {

inline constexpr double kLooseRtol = 1e-10, kTightRtol = 1e-12;
// With contacts: a bar decides whether a graze is answered.
inline constexpr double kLooseContactRtol = 1e-11, kTightContactRtol = 1e-13;
inline constexpr double kSafety = 2;             // of the largest difference between the runs
inline constexpr double kRelativeFloor = 1e-13;  // of the scale so far: double's round-off over a run

}  // namespace atwood::cvode
