// Functions common to the probes. Private to this room.
#pragma once

#include <array>
#include <stdexcept>

#include "validation/metrics/measurements.hpp"
#include "validation/metrics/probes.hpp"

namespace atwood::metrics {

// Thrown where a probe has no figures: it does not apply (unsupported), or one of its runs failed.
struct ProbeEnds : std::runtime_error {
  Status status;
  ProbeEnds(Status s, const std::string& why) : std::runtime_error(why), status(s) {}
};

// A run with status ok and all requested samples; else throws ProbeEnds.
Recording good_run(const ProbeRequest& request, const std::string& method, const Scene& scene, const Plan& plan);
inline Recording good_run(const ProbeRequest& request, const Scene& scene, const Plan& plan) {
  return good_run(request, request.method, scene, plan);
}

// The scene with a sample, rounded to double, as initial state.
Scene started_from(const Scene& scene, const SampleView& sample);

// Refusals that several probes share: bare systems, contacts, recorded frames, forces that depend on time.
void require_bodies(const ProbeRequest& request);
void require_no_contacts(const ProbeRequest& request);
void require_no_clock(const ProbeRequest& request);
void require_no_dissipation(const ProbeRequest& request);

// Largest over samples and mobile bodies of |p| [m], |v| [m/s], |w| [rad/s].
struct Sizes {
  double position_m = 0, velocity_m_per_s = 0, rate_rad_per_s = 0;
};
Sizes sizes_of(const Scene& scene, const SampleSeries& samples);

std::vector<Row> probe_ensemble(const ProbeRequest& request);
std::vector<Row> probe_reversal(const ProbeRequest& request);
std::vector<Row> probe_symplecticity(const ProbeRequest& request);
std::vector<Row> probe_lyapunov(const ProbeRequest& request);
std::vector<Row> probe_determinism(const ProbeRequest& request);

}  // namespace atwood::metrics
