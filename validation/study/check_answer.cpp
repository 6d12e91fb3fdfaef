#include "validation/study/check_answer.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "scene/bounding_radius.hpp"

namespace atwood {
namespace {

double length(const Real3& v) { return std::hypot(v[0], v[1], v[2]); }

std::string listed(const double* values, std::size_t size) {
  std::string text = "[";
  for (std::size_t i = 0; i < size; ++i) text += (i ? ", " : "") + format_double(values[i]);
  return text + "]";
}

template <std::size_t n> std::array<double, n> narrowed(const std::array<Wide, n>& wide) {
  std::array<double, n> narrow{};
  for (std::size_t i = 0; i < n; ++i) narrow[i] = static_cast<double>(wide[i]);
  return narrow;
}

template <std::size_t n> bool near(const std::array<double, n>& a, const std::array<double, n>& b, double tolerance) {
  for (std::size_t i = 0; i < n; ++i)
    if (!(std::fabs(a[i] - b[i]) <= tolerance)) return false;
  return true;
}

template <std::size_t n>
[[noreturn]] void wrong_start(std::size_t body, const char* what, const std::array<double, n>& found,
                              const std::array<double, n>& expected) {
  throw wire::Garbage("sample 0 is not the scene's initial state: body " + std::to_string(body) + " has " + what + " " +
                      listed(found.data(), n) + " where the scene has " + listed(expected.data(), n));
}

void check_start(const BodySample& sample, std::size_t i, double t_end_s, const SampledBodies& bodies) {
  const SampledBodies::Start& start = bodies.start[i];
  // Without sizes and speeds the run itself sets the scale: bodies that start at rest at the origin move somewhere.
  const double falls = bodies.gravity_m_per_s2 * t_end_s;
  const double size = bodies.size_m > 0 ? bodies.size_m : std::max(bodies.speed_m_per_s, falls) * t_end_s;
  const double fastest = std::max(bodies.speed_m_per_s, bodies.rate_rad_per_s * size);
  const double speed = fastest > 0 ? fastest : std::max(falls, size / t_end_s);
  const double rate = bodies.rate_rad_per_s > 0 ? bodies.rate_rad_per_s : 1 / t_end_s;
  const Real3 p = narrowed(sample.p_m), v = narrowed(sample.v_m_per_s), w = narrowed(sample.w_rad_per_s);
  const Real4 q = narrowed(sample.q_wxyz), minus_q{-q[0], -q[1], -q[2], -q[3]};
  if (start.placed && !near(p, start.p_m, kStartTolerance * size)) wrong_start(i, "position_m", p, start.p_m);
  if (!start.moves) return;
  if (start.turns && !near(q, start.q_wxyz, kStartTolerance) && !near(minus_q, start.q_wxyz, kStartTolerance))
    wrong_start(i, "orientation_wxyz", q, start.q_wxyz);
  const auto agrees = [&](const Real3& found, const Real3& expected, double tolerance) {
    return near(found, expected, tolerance) || (start.still && near(found, {}, tolerance));
  };
  if (!agrees(v, start.v_m_per_s, kStartTolerance * speed)) wrong_start(i, "velocity_m_per_s", v, start.v_m_per_s);
  if ((start.turns || start.still) && !agrees(w, start.w_rad_per_s, kStartTolerance * rate))
    wrong_start(i, "angular_velocity_body_rad_per_s", w, start.w_rad_per_s);
}

bool is_finite(const BodySample& sample) {
  const auto all = [](const auto& values) {
    return std::all_of(values.begin(), values.end(), [](Wide x) { return std::isfinite(static_cast<double>(x)); });
  };
  return all(sample.p_m) && all(sample.q_wxyz) && all(sample.v_m_per_s) && all(sample.w_rad_per_s);
}

void check_norm(const BodySample& sample, std::size_t i, std::size_t k, const SampledBodies& bodies, bool foreign) {
  const bool drifts = k > 0 && (bodies.start.empty() || bodies.start[i].turns);
  if (drifts && !foreign) return;
  const Real4 q = narrowed(sample.q_wxyz);
  const double norm = std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3]));
  if (std::fabs(norm - 1) <= (drifts ? kNormDrift : kNormTolerance)) return;
  throw wire::Garbage("sample " + std::to_string(k) + ": the quaternion of body " + std::to_string(i) + ", " +
                      listed(q.data(), 4) + ", has norm " + format_double(norm) +
                      "; a unit quaternion w, x, y, z was expected" +
                      (drifts ? " (of a body that turns, a norm within 10 % of 1)" : ""));
}

// A likely cause of a wrong t_s (another unit, an index); empty where none fits.
std::string slip_of_time(double t, double due, std::size_t k, std::int64_t samples) {
  const auto is = [&](double other) { return std::fabs(t - other) <= 1e-6 * std::fabs(other); };
  std::string slips;
  const auto slip = [&](bool fits, const char* what) {
    slips += fits ? (slips.empty() ? "" : " or ") + std::string(what) : "";
  };
  if (k == 0) return "";
  slip(is(due * 1e3), "in milliseconds");
  slip(is(due * 1e6), "in microseconds");
  slip(is(due * 1e9), "in nanoseconds");
  slip(is(due / 60), "in minutes");
  slip(is(static_cast<double>(k)), "the index of the sample");
  slip(is(static_cast<double>(k) / static_cast<double>(samples)), "a part of the whole run");
  return slips.empty() ? "" : ": is it " + slips + "?";
}

// A shorter time per step shows that the unit is not nanoseconds.
constexpr double kQuickestStepNs = 0.1;

// No engine steps faster than this.
constexpr double kMinStepNs = 0.3;

std::string slip_of_busy(double sum, double steps, double wall_ns, bool foreign) {
  const auto would_fill = [&](double unit_ns) {
    return sum * unit_ns >= 0.2 * wall_ns && sum * unit_ns <= 1.1 * wall_ns;
  };
  if (foreign && sum < 3 * steps && would_fill(1e3)) return "microseconds";
  if (sum >= kQuickestStepNs * steps) return "";
  if (would_fill(1e9)) return "seconds";
  return would_fill(1e6) ? "milliseconds" : "";
}

double distance(const Real3& a, const Real3& b) { return length({a[0] - b[0], a[1] - b[1], a[2] - b[2]}); }

bool finite(const Real3& v) { return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]); }

}  // namespace

SampledBodies::SampledBodies(const Scene& scene) : count(scene.problem.empty() ? scene.bodies.size() : 1) {
  gravity_m_per_s2 = length(scene.gravity_m_per_s2);
  for (const Fluid& fluid : scene.fluids) {
    const Particles& p = fluid.particles;
    particles += p.position_m.size();
    particle_start.insert(particle_start.end(), p.position_m.begin(), p.position_m.end());
    for (const Real3& x : p.position_m) size_m = std::max(size_m, length(x));
    for (const Real3& v : p.velocity_m_per_s) speed_m_per_s = std::max(speed_m_per_s, length(v));
  }
  joints = scene.joints;
  for (const Rope& rope : scene.ropes) rope_pulleys.push_back(rope.over.size());
  if (scene.bodies.size() != count) return;
  start.reserve(count);
  for (const Body& body : scene.bodies) {
    Start& one = start.emplace_back();
    one.p_m = body.position_m, one.q_wxyz = body.orientation_wxyz;
    one.v_m_per_s = body.velocity_m_per_s, one.w_rad_per_s = body.angular_velocity_body_rad_per_s;
    one.turns = rotates(body) && !body.fixed;
    one.placed = !std::holds_alternative<Plane>(body.shape);
    one.still = body.fixed || body.release_s > 0;
    one.moves = scene.problem.empty();
    size_m = std::max({size_m, length(body.position_m), one.placed ? bounding_radius_m(body.shape) : 0});
    speed_m_per_s = std::max(speed_m_per_s, length(body.velocity_m_per_s));
    rate_rad_per_s = std::max(rate_rad_per_s, length(body.angular_velocity_body_rad_per_s));
  }
}

void check_layout(const SampleView& sample, std::size_t k, double t_end_s, std::int64_t samples,
                  const SampledBodies& bodies) {
  if (sample.bodies.size() != bodies.count) {
    throw wire::Garbage("sample " + std::to_string(k) + " has " + std::to_string(sample.bodies.size()) +
                        " bodies; the scene has " + std::to_string(bodies.count));
  }
  if (sample.particles.size() != bodies.particles)
    throw wire::Garbage("sample " + std::to_string(k) + " has " + std::to_string(sample.particles.size()) +
                        " particles; the scene has " + std::to_string(bodies.particles));
  const double due = t_end_s * static_cast<double>(k) / static_cast<double>(samples);
  const double near = std::min(1e-6, 0.25 / static_cast<double>(samples)) * t_end_s;
  const double t = static_cast<double>(sample.t_s);
  const double last = k > 0 ? t_end_s * static_cast<double>(k - 1) / static_cast<double>(samples) : -1;
  if (k > 0 && std::fabs(t - last) <= near)
    throw wire::Garbage("sample " + std::to_string(k - 1) + ", at t_s = " + format_double(t) +
                        ", came twice; the next one is due at " + format_double(due));
  if (!(std::fabs(t - due) <= near)) {
    throw wire::Garbage("sample " + std::to_string(k) + " is at t_s = " + format_double(t) + "; asked for " +
                        format_double(due) + slip_of_time(t, due, k, samples));
  }
}

void check_joints(const wire::Answer& answer, const SampledBodies& bodies) {
  const SampleView& sample = answer.sample;
  const auto refuse_count = [](std::size_t found, std::size_t expected, const char* what) {
    if (found != 0 && found != expected)
      throw wire::Garbage("a sample has " + std::to_string(found) + " " + what + "; the scene has " +
                          std::to_string(expected));
  };
  refuse_count(sample.joints.size(), bodies.joints.size(), "joints");
  refuse_count(sample.ropes.size(), bodies.rope_pulleys.size(), "ropes");
  for (std::size_t i = 0; i < answer.joint_coordinates.size() && i < bodies.joints.size(); ++i) {
    const int expected = coordinate_count(bodies.joints[i].kind), found = answer.joint_coordinates[i];
    if (found != expected && found != 4)
      throw wire::Garbage("joint `" + bodies.joints[i].name + "` has a row of " + std::to_string(found) +
                          " coordinates; expected " + std::to_string(expected));
  }
  for (std::size_t i = 0; i < sample.ropes.size(); ++i)
    if (sample.ropes[i].pulley_angle_rad.size() != bodies.rope_pulleys[i])
      throw wire::Garbage("rope " + std::to_string(i) + " has " +
                          std::to_string(sample.ropes[i].pulley_angle_rad.size()) + " pulleys; the scene has " +
                          std::to_string(bodies.rope_pulleys[i]));
}

void check_states(const SampleView& sample, std::size_t k, double t_end_s, const SampledBodies& bodies, bool foreign) {
  for (std::size_t i = 0; i < sample.bodies.size(); ++i) {
    if (!is_finite(sample.bodies[i])) continue;  // allowed: the cell ends as `not finite`
    check_norm(sample.bodies[i], i, k, bodies, foreign);
    if (k == 0 && !bodies.start.empty()) check_start(sample.bodies[i], i, t_end_s, bodies);
  }
  for (std::size_t i = 0; k == 0 && i < sample.particles.size(); ++i) {
    const Real3 p = narrowed(sample.particles[i].p_m);
    if (near(p, bodies.particle_start[i], kStartTolerance * bodies.size_m)) continue;
    throw wire::Garbage("sample 0 is not the scene's initial state: particle " + std::to_string(i) + " is at " +
                        listed(p.data(), 3) + " where the scene has " + listed(bodies.particle_start[i].data(), 3));
  }
}

std::string blow_up(const SampleSeries& samples, double t_end_s, const SampledBodies& bodies) {
  const double run_m = std::max(bodies.speed_m_per_s, bodies.gravity_m_per_s2 * t_end_s) * t_end_s;
  const double size = std::max(bodies.size_m, run_m) > 0 ? std::max(bodies.size_m, run_m) : 1;
  const double speed = std::max(bodies.speed_m_per_s, size / t_end_s);
  const double rate = std::max(bodies.rate_rad_per_s, 1 / t_end_s);
  const auto beyond = [&](const Real3& v, double scale) { return finite(v) && !(length(v) <= kBlowUp * scale); };
  for (std::size_t k = 1; k < samples.size(); ++k) {
    for (std::size_t i = 0; i < samples[k].bodies.size(); ++i) {
      const BodySample& now = samples[k].bodies[i];
      const Real3 p = narrowed(now.p_m), before = narrowed(samples[k - 1].bodies[i].p_m);
      const Real3 v = narrowed(now.v_m_per_s), w = narrowed(now.w_rad_per_s);
      const std::string who = "body " + std::to_string(i);
      const std::string when = " at sample " + std::to_string(k);
      if (finite(p) && finite(before) && !(distance(p, before) <= kBlowUp * size))
        return who + " moves " + format_double(distance(p, before)) + " m from sample " + std::to_string(k - 1) +
               " to " + std::to_string(k) + "; the scene's size is " + format_double(size) + " m";
      if (beyond(v, speed))
        return who + " has a speed of " + format_double(length(v)) + " m/s" + when +
               "; the scene's size over the run is " + format_double(speed) + " m/s";
      if (!bodies.start.empty() && bodies.start[i].turns && beyond(w, rate))
        return who + " turns at " + format_double(length(w)) + " rad/s" + when + "; the scene's rate is " +
               format_double(rate) + " rad/s";
    }
  }
  return "";
}

void check_busy(const std::vector<std::int64_t>& busy_ns, int repeats, std::int64_t steps, std::int64_t wall_ns,
                bool foreign) {
  if (busy_ns.empty()) throw wire::Garbage("a timed pass without busy_ns");
  if (busy_ns.size() != static_cast<std::size_t>(repeats))
    throw wire::Garbage("busy_ns has " + std::to_string(busy_ns.size()) + " entries; asked for " +
                        std::to_string(repeats) + " repeats");
  double sum = 0;
  for (const std::int64_t each : busy_ns) {
    if (each <= 0)
      throw wire::Garbage("busy_ns has " + std::to_string(each) + "; the nanoseconds of a run are positive" +
                          (each == 0 ? ": is it in seconds or milliseconds?" : ""));
    sum += static_cast<double>(each);
  }
  const double wall = static_cast<double>(wall_ns);
  if (sum > 1.05 * wall + 1e6)
    throw wire::Garbage("busy_ns of all repeats is " + format_double(sum) + " ns, longer than the whole answer took (" +
                        format_double(wall) + " ns on the wall): is it in another unit, or summed over threads?");
  const std::string unit = slip_of_busy(sum, static_cast<double>(steps) * repeats, wall, foreign);
  if (!unit.empty())
    throw wire::Garbage("busy_ns of " + std::to_string(busy_ns.front()) + " for " + std::to_string(steps) +
                        " steps; nanoseconds were expected: is it in " + unit + "?");
  const double step_ns = sum / (static_cast<double>(steps) * repeats);
  if (foreign && step_ns < kMinStepNs)
    throw wire::Garbage("busy_ns of " + std::to_string(busy_ns.front()) + " for " + std::to_string(steps) +
                        " steps is " + format_double(step_ns) +
                        " ns a step; at least 0.3 ns were expected: is busy_ns in another unit?");
}

}  // namespace atwood
