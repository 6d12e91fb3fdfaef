// The motion of a playback page. The first run is stored as poses; the others, as far as it reaches, as their
// differences from it, each list with a scale of its own: so a difference of 1e-12 m is kept as well as one of 1 m, and
// the page can magnify it. Differences of attitude are rotation vectors of q_first^-1 q in the body's axes.
#include <algorithm>
#include <cmath>
#include <limits>

#include "playback_parts.hpp"

namespace atwood {
namespace {

using Vector = std::array<double, 3>;
using Samples = std::vector<std::size_t>;

double norm(const Vector& v) { return std::hypot(v[0], v[1], v[2]); }

Vector position(const BodySample& body) {
  return {static_cast<double>(body.p_m[0]), static_cast<double>(body.p_m[1]), static_cast<double>(body.p_m[2])};
}

// log(a^-1 b), the shorter way round; the products in wide arithmetic, so that a small rotation keeps its digits.
Vector rotation_between(const BodySample& a, const BodySample& b) {
  const auto& p = a.q_wxyz;
  const auto& q = b.q_wxyz;
  Wide w = p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3];
  std::array<Wide, 3> v{p[0] * q[1] - p[1] * q[0] - p[2] * q[3] + p[3] * q[2],
                        p[0] * q[2] + p[1] * q[3] - p[2] * q[0] - p[3] * q[1],
                        p[0] * q[3] - p[1] * q[2] + p[2] * q[1] - p[3] * q[0]};
  if (w < 0) {
    w = -w;
    for (Wide& x : v) x = -x;
  }
  const Vector n{static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
  const double sine = norm(n);
  const double scale = sine > 0 ? 2 * std::atan2(sine, static_cast<double>(w)) / sine : 2;
  return {n[0] * scale, n[1] * scale, n[2] * scale};
}

bool finite(const BodySample& body) {
  for (const Wide x : body.p_m)
    if (!std::isfinite(static_cast<double>(x))) return false;
  for (const Wide x : body.q_wxyz)
    if (!std::isfinite(static_cast<double>(x))) return false;
  return true;
}

std::size_t frames_before(const Samples& samples, std::size_t count) {
  return static_cast<std::size_t>(std::lower_bound(samples.begin(), samples.end(), count) - samples.begin());
}

// How far the bodies of the first run move from the start, and how far apart they are.
double extent_m(const PlayedRun& run) {
  Vector low, high;
  low.fill(std::numeric_limits<double>::infinity());
  high.fill(-std::numeric_limits<double>::infinity());
  for (const SampleView sample : run.values)
    for (const BodySample& body : sample.bodies) {
      const Vector p = position(body);
      for (std::size_t i = 0; i < 3; ++i)
        if (std::isfinite(p[i])) low[i] = std::min(low[i], p[i]), high[i] = std::max(high[i], p[i]);
    }
  const double size = norm({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
  return std::isfinite(size) && size > 0 ? size : 1;
}

// Samples of the run that can be drawn: before the first that is not finite or that left the scene by a hundred
// extents.
std::size_t drawable_samples(const PlayedRun& run, double extent) {
  for (std::size_t k = 0; k < run.values.size(); ++k)
    for (std::size_t i = 0; i < run.values[k].bodies.size(); ++i) {
      const BodySample& body = run.values[k].bodies[i];
      if (!finite(body)) return k;
      const Vector a = position(body), b = position(checked(run.values[0].bodies, i));
      if (norm({a[0] - b[0], a[1] - b[1], a[2] - b[2]}) > 100 * extent) return k;
    }
  return run.values.size();
}

void append_list(JsonText& json, MotionBlob& blob, const QuantisedList& list) {
  json.begin_array().number(list.low).number(list.step).integer(static_cast<std::int64_t>(blob.add_words(list.words)));
  json.end_array();
}

// Poses of the run's frames first..last as they are: [low, step, offset] for each of x, y, z, and for w, x, y, z.
void append_poses(JsonText& json, MotionBlob& blob, const PlayedRun& run, const Samples& samples, std::size_t first,
                  std::size_t last, const std::vector<std::size_t>& bodies) {
  json.begin_array();
  for (const std::size_t body : bodies) {
    json.begin_object().key("p").begin_array();
    std::vector<double> list(last - first);
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t f = first; f < last; ++f) list[f - first] = position(run.values[samples[f]].bodies[body])[i];
      append_list(json, blob, quantised(list));
    }
    json.end_array();
    std::array<std::vector<double>, 4> q;
    std::array<double, 4> before{};
    bool turns = false;
    for (std::size_t f = first; f < last; ++f) {
      std::array<double, 4> now{};
      double dot = 0;
      for (std::size_t i = 0; i < 4; ++i) {
        now[i] = static_cast<double>(run.values[samples[f]].bodies[body].q_wxyz[i]);
        dot += now[i] * before[i];
      }
      for (std::size_t i = 0; i < 4; ++i) q[i].push_back(before[i] = dot < 0 ? -now[i] : now[i]);
      if (f > first && before != std::array{q[0][0], q[1][0], q[2][0], q[3][0]}) turns = true;
    }
    json.key("q").begin_array();
    for (std::size_t i = 0; i < 4; ++i) {
      if (!turns) json.number(q[i].empty() ? (i == 0 ? 1.0 : 0.0) : q[i][0]);
      else append_list(json, blob, quantised_about_zero(q[i], 1));
    }
    json.end_array().end_object();
  }
  json.end_array();
}

// Differences from the first run at frames 0..last: [step, offset] for each component, or nothing where all are 0.
void append_differences(JsonText& json, MotionBlob& blob, const PlayedRun& first, const PlayedRun& run,
                        const Samples& samples, std::size_t last, const std::vector<std::size_t>& bodies) {
  const auto append = [&](const char* key, const std::array<std::vector<double>, 3>& lists) {
    double largest = 0;
    for (const auto& list : lists)
      for (const double value : list) largest = std::max(largest, std::fabs(value));
    if (!(largest > 0)) return;
    json.key(key).begin_array();
    for (const auto& list : lists) append_list(json, blob, quantised_about_zero(list, largest));
    json.end_array();
  };
  json.begin_array();
  for (const std::size_t body : bodies) {
    std::array<std::vector<double>, 3> dp, dr;
    for (std::size_t f = 0; f < last; ++f) {
      const BodySample& a = first.values[samples[f]].bodies[body];
      const BodySample& b = run.values[samples[f]].bodies[body];
      const Vector turn = rotation_between(a, b);
      for (std::size_t i = 0; i < 3; ++i) {
        dp[i].push_back(static_cast<double>(b.p_m[i] - a.p_m[i]));
        dr[i].push_back(turn[i]);
      }
    }
    json.begin_object();
    append("p", dp);
    append("r", dr);
    json.end_object();
  }
  json.end_array();
}

void append_curve(JsonText& json, MotionBlob& blob, const char* key, const std::vector<double>& values,
                  const Samples& samples) {
  if (values.empty()) return;
  std::vector<float> kept;
  for (const std::size_t k : samples)
    if (k < values.size()) kept.push_back(static_cast<float>(values[k]));
  json.key(key).begin_array().integer(static_cast<std::int64_t>(blob.add_floats(kept)));
  json.integer(static_cast<std::int64_t>(kept.size())).end_array();
}

constexpr std::size_t kMaxEvents = 600, kMaxContacts = 4000;

void append_events(JsonText& json, const PlayedRun& run) {
  json.key("events").begin_array();
  for (std::size_t k = 0; k < std::min(run.events.size(), kMaxEvents); ++k) {
    const Event& e = run.events[k];
    json.begin_array()
        .number(static_cast<double>(e.t_s), 9)
        .text(to_string(e.kind))
        .integer(e.body_a)
        .integer(e.body_b);
    for (const Wide x : e.x_m) json.number(static_cast<double>(x), 6);
    for (const Wide x : e.normal) json.number(static_cast<double>(x), 5);
    json.number(static_cast<double>(e.impulse_n_N_s), 4).number(static_cast<double>(e.impulse_t_N_s), 4).end_array();
  }
  json.end_array();
  if (run.events.size() > kMaxEvents)
    json.member_integer("events_left_out", static_cast<std::int64_t>(run.events.size() - kMaxEvents));
}

// [frame, x, y, z, normal, normal force, friction], the frames evenly chosen so that not too many contacts go along.
void append_contacts(JsonText& json, const PlayedRun& run, const Samples& samples, std::size_t frames) {
  std::size_t all = 0;
  for (std::size_t f = 0; f < frames; ++f) all += run.values[samples[f]].contacts.size();
  if (all == 0) return;
  const std::size_t every = std::max<std::size_t>(1, (all + kMaxContacts - 1) / kMaxContacts);
  json.member_integer("contacts_every", static_cast<std::int64_t>(every)).key("contacts").begin_array();
  for (std::size_t f = 0; f < frames; f += every)
    for (const ContactSample& c : run.values[samples[f]].contacts) {
      json.begin_array().integer(static_cast<std::int64_t>(f));
      for (const double x : c.x_m) json.number(x, 5);
      for (const double x : c.normal) json.number(x, 3);
      json.number(c.force_n_N, 3);
      for (const double x : c.force_t_N) json.number(x, 3);
      json.end_array();
    }
  json.end_array();
}

struct Field {
  const char *name, *unit;
  double (*value)(const ParticleSample&);
};
double speed(const ParticleSample& p) {
  return norm(
      {static_cast<double>(p.v_m_per_s[0]), static_cast<double>(p.v_m_per_s[1]), static_cast<double>(p.v_m_per_s[2])});
}
constexpr Field kFields[] = {
    {"speed", "m/s", speed},
    {"pressure", "Pa", [](const ParticleSample& p) { return static_cast<double>(p.pressure_Pa); }},
    {"density", "kg/m3", [](const ParticleSample& p) { return static_cast<double>(p.density_kg_per_m3); }},
    {"temperature", "K", [](const ParticleSample& p) { return static_cast<double>(p.temperature_K); }}};

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
  void take(double value) {
    if (std::isfinite(value)) low = std::min(low, value), high = std::max(high, value);
  }
  bool varies() const { return high > low; }
  double share(double value) const {
    return std::isfinite(value) && varies() ? std::clamp((value / 2 - low / 2) / (high / 2 - low / 2), 0.0, 1.0) : 0;
  }
};

// What all runs share, so that equal places and equal colours are equal values.
struct FluidRanges {
  std::array<Range, 3> place;
  std::array<Range, std::size(kFields)> field;
};

double wrapped(const Domain& domain, std::size_t axis, double x) {
  const double period = domain.periodic_m[axis];
  return period > 0 ? x - period * std::floor(x / period) : x;
}

FluidRanges fluid_ranges(const Playback& playback) {
  FluidRanges ranges;
  for (const PlayedRun& run : playback.runs)
    for (const SampleView sample : run.values)
      for (const ParticleSample& p : sample.particles) {
        for (std::size_t i = 0; i < 3; ++i)
          ranges.place[i].take(wrapped(playback.scenario.scene.domain, i, static_cast<double>(p.p_m[i])));
        for (std::size_t i = 0; i < std::size(kFields); ++i) ranges.field[i].take(kFields[i].value(p));
      }
  return ranges;
}

// Every n-th frame, and of the particles those nearest to evenly spaced places of the list.
DrawnParticles append_particles(JsonText& json, MotionBlob& blob, const Playback& playback, const PlayedRun& run,
                                const FluidRanges& ranges, const PlayedDetail& detail, std::size_t frames) {
  const std::size_t all = run.values.empty() ? 0 : run.values[0].particles.size();
  if (all == 0 || frames == 0) return {};
  const std::size_t drawn = std::min(all, detail.particles);
  const std::size_t every = (frames + detail.particle_frames - 1) / detail.particle_frames;
  Samples kept;
  for (std::size_t f = 0; f < frames; f += every) kept.push_back(f);
  json.key("particles").begin_object();
  json.member_integer("count", static_cast<std::int64_t>(drawn)).member_integer("all", static_cast<std::int64_t>(all));
  json.member_integer("every", static_cast<std::int64_t>(every));
  json.member_integer("frames", static_cast<std::int64_t>(kept.size()));
  const auto particle = [&](std::size_t frame, std::size_t i) -> const ParticleSample& {
    return run.values[detail.samples[frame]].particles[i * all / drawn];
  };
  json.key("place").begin_array();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!ranges.place[axis].varies()) {
      json.integer(-1);
      continue;
    }
    std::vector<std::uint16_t> words;
    for (std::size_t i = 0; i < drawn; ++i)
      for (const std::size_t f : kept)
        words.push_back(static_cast<std::uint16_t>(
            std::lround(65535 * ranges.place[axis].share(wrapped(playback.scenario.scene.domain, axis,
                                                                 static_cast<double>(particle(f, i).p_m[axis]))))));
    json.integer(static_cast<std::int64_t>(blob.add_words(words)));
  }
  json.end_array().key("fields").begin_array();
  for (std::size_t field = 0; field < std::size(kFields); ++field) {
    if (!ranges.field[field].varies()) {
      json.integer(-1);
      continue;
    }
    std::vector<std::uint8_t> words;
    for (std::size_t i = 0; i < drawn; ++i)
      for (const std::size_t f : kept)
        words.push_back(static_cast<std::uint8_t>(
            std::lround(255 * ranges.field[field].share(kFields[field].value(particle(f, i))))));
    json.integer(static_cast<std::int64_t>(blob.add_bytes(words)));
  }
  json.end_array().end_object();
  return {drawn, all};
}

std::vector<std::size_t> moving_bodies(const Playback& playback) {
  std::vector<std::size_t> moving;
  const std::size_t count =
      playback.runs.empty() || playback.runs[0].values.empty() ? 0 : playback.runs[0].values[0].bodies.size();
  for (std::size_t body = 0; body < count; ++body) {
    bool moves = false;
    for (const PlayedRun& run : playback.runs)
      for (const SampleView sample : run.values) {
        const BodySample& now = checked(sample.bodies, body);
        const BodySample& start = playback.runs[0].values[0].bodies[body];
        moves = moves || now.p_m != start.p_m || now.q_wxyz != start.q_wxyz;
      }
    if (moves) moving.push_back(body);
  }
  return moving;
}

}  // namespace

DrawnParticles append_played_runs(JsonText& json, MotionBlob& blob, const Playback& playback,
                                  const PlayedDetail& detail) {
  DrawnParticles particles;
  const std::vector<std::size_t> moving = moving_bodies(playback);
  const FluidRanges ranges = fluid_ranges(playback);
  json.begin_object().key("moving").begin_array();
  for (const std::size_t body : moving) json.integer(static_cast<std::int64_t>(body));
  json.end_array().key("ranges").begin_array();
  for (const Range& range : ranges.place)
    json.begin_array().number(range.varies() ? range.low : 0).number(range.varies() ? range.high : 0).end_array();
  json.end_array().key("fields").begin_array();
  for (std::size_t i = 0; i < std::size(kFields); ++i) {
    json.begin_array().text(kFields[i].name).text(kFields[i].unit);
    if (ranges.field[i].varies()) json.number(ranges.field[i].low).number(ranges.field[i].high);
    json.end_array();
  }
  json.end_array().key("runs").begin_array();
  const double extent = playback.runs.empty() ? 1 : extent_m(playback.runs[0]);
  std::size_t shared = 0;  // frames of the first run
  for (std::size_t r = 0; r < playback.runs.size(); ++r) {
    const PlayedRun& run = playback.runs[r];
    const std::size_t drawable = drawable_samples(run, extent), frames = frames_before(detail.samples, drawable);
    if (r == 0) shared = frames;
    json.begin_object().member("name", run.name).member("source", run.source).member_integer("steps", run.steps);
    json.member("status", to_string(run.outcome.status)).member("reason", run.outcome.reason);
    json.member_integer("frames", static_cast<std::int64_t>(frames));
    if (drawable < run.values.size()) json.key("left").boolean(true);
    const std::size_t differences = r == 0 ? 0 : std::min(frames, shared);
    json.key("poses");
    append_poses(json, blob, run, detail.samples, differences, frames, moving);
    if (r > 0) {
      json.member_integer("differences_to", static_cast<std::int64_t>(differences)).key("differences");
      append_differences(json, blob, playback.runs[0], run, detail.samples, differences, moving);
    }
    append_events(json, run);
    append_contacts(json, run, detail.samples, frames);
    append_curve(json, blob, "position", run.position_error_m, detail.samples);
    append_curve(json, blob, "attitude", run.attitude_error_rad, detail.samples);
    append_curve(json, blob, "position_bar", run.position_bar_m, detail.samples);
    append_curve(json, blob, "attitude_bar", run.attitude_bar_rad, detail.samples);
    append_curve(json, blob, "energy", run.energy, detail.samples);
    const DrawnParticles drawn = append_particles(json, blob, playback, run, ranges, detail, frames);
    if (drawn.all > 0) particles = drawn;
    json.end_object();
  }
  json.end_array().end_object();
  return particles;
}

}  // namespace atwood
