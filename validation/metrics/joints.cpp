// Errors of mechanisms: how far joints and ropes are from their constraints, joint coordinates and rates, reactions.
#include <quadmath.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "dynamics/joint_poses.hpp"
#include "dynamics/state.hpp"
#include "validation/metrics/joints.hpp"
#include "validation/metrics/measurements.hpp"

namespace atwood {
namespace {

const Wide kTurn = 2 * acosq(-1);

bool finite(Wide x) { return std::isfinite(static_cast<double>(x)); }
double narrow(Wide x) { return static_cast<double>(x); }
double size_of(Wide x) { return std::fabs(narrow(x)); }

// A bar that is not a number says that no bound is known.
double known(double bar) { return std::isnan(bar) ? std::numeric_limits<double>::infinity() : bar; }

Row row_of(const std::string& metric, const std::string& body, double value, double bar = 0, std::string reason = "") {
  Row r = metrics::row(metric, value, bar, std::move(reason));
  r.body = body;
  return r;
}

// ---- how far from the constraints ----------------------------------------------------------------------------------
void append_gaps(const Scenario& scenario, const Recording& run, std::vector<Row>& rows) {
  const Scene& scene = scenario.scene;
  std::vector<double> gap(scene.joints.size(), 0), tilt = gap, rope_gap(scene.ropes.size(), 0);
  for (const SampleView sample : run.values) {
    for (std::size_t j = 0; j < scene.joints.size(); ++j) {
      const dynamics::JointPose pose = dynamics::joint_pose(scene, static_cast<int>(j), sample);
      gap[j] = std::max(gap[j], narrow(pose.gap_m));
      tilt[j] = std::max(tilt[j], narrow(pose.tilt_rad));
    }
    for (std::size_t r = 0; r < scene.ropes.size(); ++r)
      rope_gap[r] = std::max(rope_gap[r], size_of(dynamics::rope_length_m(scene, scene.ropes[r], sample) -
                                                  dynamics::rope_length_m(scene, scene.ropes[r], run.values.front())));
  }
  double widest = 0, most = 0;
  bool tilts = false;
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    rows.push_back(row_of("joint-gap", scene.joints[j].name, gap[j]));
    widest = std::max(widest, gap[j]);
    if (scene.joints[j].kind == JointKind::ball) continue;
    rows.push_back(row_of("joint-tilt", scene.joints[j].name, tilt[j]));
    most = std::max(most, tilt[j]);
    tilts = true;
  }
  for (std::size_t r = 0; r < scene.ropes.size(); ++r) {
    rows.push_back(row_of("joint-gap", scene.ropes[r].name, rope_gap[r], 0, "change of the rope's length"));
    widest = std::max(widest, rope_gap[r]);
  }
  rows.push_back(metrics::row("joint-gap", widest));
  if (tilts) rows.push_back(metrics::row("joint-tilt", most));
}

// ---- against the truth -------------------------------------------------------------------------------------------
// The joints of every sample of a motion, read from the poses where they are not reported, and their bars.
struct Motion {
  std::vector<std::vector<JointSample>> joints;
  bool reported = true;
};

Motion motion_of(const Scene& scene, const SampleSeries& samples) {
  Motion motion;
  std::vector<JointSample> before = dynamics::joints_at_start(scene);
  for (const SampleView sample : samples) {
    motion.reported = motion.reported && sample.joints.size() == scene.joints.size();
    motion.joints.push_back(before = dynamics::joints_of(scene, sample, before));
  }
  return motion;
}

template <std::size_t N> double norm(const std::array<Wide, N>& a) {
  Wide sum = 0;
  for (const Wide& x : a) sum += x * x;
  return narrow(sqrtq(sum));
}

// Bars of a coordinate or rate that is computed from the truth's poses: those of the two bodies' own, added.
struct PoseBars {
  double angle = 0, offset = 0, angular_rate = 0, linear_rate = 0;
};
PoseBars pose_bars(const Joint& joint, const SampleView& bar) {
  PoseBars sum;
  for (const int end : {0, 1}) {
    const int b = end == 0 ? joint.parent : joint.child;
    if (b < 0) continue;
    const BodySample& body = bar.bodies[static_cast<std::size_t>(b)];
    double arm = 0;
    for (double x : joint.anchors_body_m[static_cast<std::size_t>(end)]) arm = std::hypot(arm, x);
    sum.angle += 2 * norm(body.q_wxyz);
    sum.offset += norm(body.p_m) + 2 * norm(body.q_wxyz) * arm;
    sum.angular_rate += norm(body.w_rad_per_s);
    sum.linear_rate += norm(body.v_m_per_s) + norm(body.w_rad_per_s) * arm;
  }
  return sum;
}

struct Bars {  // of one joint at one sample
  std::array<double, 2> q{};
  double attitude = 0;  // of a ball
  std::array<double, 3> u{};
};
Bars bars_of(const Scene& scene, const Truth& truth, std::size_t k, std::size_t j) {
  Bars bars;
  if (k >= truth.bars.size()) return bars;
  const Joint& joint = scene.joints[j];
  if (truth.bars[k].joints.size() == scene.joints.size()) {
    const JointSample& bar = truth.bars[k].joints[j];
    for (std::size_t i = 0; i < 2; ++i) bars.q[i] = known(size_of(bar.q[i]));
    bars.attitude = known(2 * norm(bar.q));
    for (std::size_t i = 0; i < 3; ++i) bars.u[i] = known(size_of(bar.u[i]));
    return bars;
  }
  const PoseBars pose = pose_bars(joint, truth.bars[k]);
  bars.attitude = pose.angle;
  for (int i = 0; i < 3; ++i) {
    const bool angle = dynamics::is_angle(joint.kind, i);
    if (i < 2) bars.q[i] = angle ? pose.angle : pose.offset;
    bars.u[i] = angle ? pose.angular_rate : pose.linear_rate;
  }
  return bars;
}

// Angle of the rotation between two quaternions, the same for q and -q.
double quaternion_angle(const std::array<Wide, 4>& a, const std::array<Wide, 4>& b) {
  BodySample x, y;
  x.q_wxyz = a, y.q_wxyz = b;
  return attitude_error_rad(x, y);
}

double angle_error(Wide mine, Wide truth, bool reported) {
  Wide apart = mine - truth;
  if (!reported) apart -= kTurn * floorq(apart / kTurn + Wide(0.5));  // from poses: the number of turns is not known
  return size_of(apart);
}

// Errors of angles [rad], or of offsets [m].
struct Kept {
  metrics::Largest end, largest, rate, rms;  // rms: of each coordinate over the judged instants
};

// The root mean square of errors and of their bars.
struct MeanSquare {
  double squares = 0, bar_squares = 0, count = 0;
  void take(double error, double bar) { squares += error * error, bar_squares += bar * bar, ++count; }
  void give(metrics::Largest& to) const {
    if (count > 0) to.take(std::sqrt(squares / count), std::sqrt(bar_squares / count));
  }
};

struct Comparison {
  const Scene& scene;
  const Truth& truth;
  const Motion &mine, &exact;
  std::vector<bool> on_impact, on_switch, judged;  // by sample

  // Coordinates and rates of joint j; `angles`: those that are angles, else those that are offsets.
  void take(std::size_t j, bool angles, Kept& kept) const {
    const Joint& joint = scene.joints[j];
    std::array<MeanSquare, 3> means;
    for (std::size_t k = 1; k < mine.joints.size(); ++k) {
      const JointSample &a = mine.joints[k][j], &b = exact.joints[k][j];
      const Bars bars = bars_of(scene, truth, k, j);
      const auto coordinate = [&](int i, double error, double bar) {
        kept.largest.take(error, bar);
        if (judged[k]) means[static_cast<std::size_t>(i)].take(error, bar);
        if (k + 1 == mine.joints.size()) kept.end.take(error, bar);
      };
      if (joint.kind == JointKind::ball) {
        coordinate(0, quaternion_angle(a.q, b.q), bars.attitude);
        if (on_impact[k]) continue;
        kept.rate.take(norm<3>({a.u[0] - b.u[0], a.u[1] - b.u[1], a.u[2] - b.u[2]}),
                       std::hypot(bars.u[0], bars.u[1], bars.u[2]));
        continue;
      }
      for (int i = 0; i < coordinate_count(joint.kind); ++i) {
        if (dynamics::is_angle(joint.kind, i) != angles) continue;
        coordinate(i, angles ? angle_error(a.q[i], b.q[i], mine.reported && exact.reported) : size_of(a.q[i] - b.q[i]),
                   bars.q[i]);
        if (!on_impact[k]) kept.rate.take(size_of(a.u[i] - b.u[i]), bars.u[i]);
      }
    }
    for (const MeanSquare& mean : means) mean.give(kept.rms);
  }
};

void merge(Kept& all, const Kept& one) {
  for (const auto& [to, from] :
       {std::pair{&all.end, &one.end}, {&all.largest, &one.largest}, {&all.rate, &one.rate}, {&all.rms, &one.rms}})
    to->figures.insert(to->figures.end(), from->figures.begin(), from->figures.end());
}

// `body` empty: of all joints. `unit`: "rad", "m" or, where figures of both stand beside each other, "rad, m".
void push_coordinates(const std::string& body, const std::string& unit, const Kept& kept, const std::string& reason,
                      std::vector<Row>& rows) {
  if (kept.largest.figures.empty()) return;
  const auto push = [&](const char* metric, const metrics::Largest& of, const std::string& unit_of) {
    if (of.figures.empty()) return;
    rows.push_back(row_of(metric, body, of.value(), of.bar(), reason));
    rows.back().unit = unit_of;
  };
  push("error-joint-coordinate", kept.largest, unit);
  if (body.empty()) {
    push("error-joint-coordinate-end", kept.end, unit);
    push("error-joint-coordinate-rms", kept.rms, unit);
  }
  push("error-joint-rate", kept.rate, unit == "rad, m" ? "rad/s, m/s" : unit + "/s");
}

void append_size(const Comparison& compare, std::vector<Row>& rows) {
  double largest = 0;
  for (const auto& joints : compare.exact.joints)
    for (std::size_t j = 0; j < joints.size(); ++j) {
      const JointKind kind = compare.scene.joints[j].kind;
      for (int i = 0; kind != JointKind::ball && i < coordinate_count(kind); ++i)
        largest = std::max(largest, size_of(joints[j].q[i]));
    }
  if (largest > 0) rows.push_back(metrics::row("size-joint-coordinate", largest));
}

// Prescribed coordinates have rows of their own and no part in those of all joints: every method has them right.
void append_coordinates(const Comparison& compare, std::vector<Row>& rows) {
  Kept angles, offsets;
  for (std::size_t j = 0; j < compare.scene.joints.size(); ++j) {
    const Joint& joint = compare.scene.joints[j];
    Kept turning, sliding;
    compare.take(j, true, turning);
    if (joint.kind != JointKind::ball) compare.take(j, false, sliding);
    const std::string reason = joint.driven_rate ? "prescribed: no part of the rows of all joints" : "";
    push_coordinates(joint.name, "rad", turning, reason, rows);
    push_coordinates(joint.kind == JointKind::cylindrical ? joint.name + ".offset" : joint.name, "m", sliding, reason,
                     rows);
    if (joint.driven_rate) continue;
    merge(angles, turning);
    merge(offsets, sliding);
  }
  const bool turns = !angles.largest.figures.empty(), slides = !offsets.largest.figures.empty();
  if (turns) rows.push_back(metrics::row("error-joint-angle", angles.largest.value(), angles.largest.bar()));
  if (slides) rows.push_back(metrics::row("error-joint-offset", offsets.largest.value(), offsets.largest.bar()));
  const std::string largest = offsets.largest.value() > angles.largest.value() ? "an offset [m]" : "an angle [rad]";
  Kept all = std::move(angles);
  merge(all, offsets);
  push_coordinates(
      "",
      turns && slides ? "rad, m"
      : turns         ? "rad"
                      : "m",
      all,
      turns && slides ? "of angles in rad and offsets in m; the largest coordinate error is that of " + largest : "",
      rows);
}

// Reactions of one joint. Components that the constraints leave open on either side are not compared.
struct Reaction {
  metrics::Largest worst;
  double size = 0;
  int compared = 0, open = 0, missing = 0;
};
Reaction reaction_of(const Comparison& compare, std::size_t j, bool torque) {
  Reaction out;
  for (std::size_t k = 0; k < compare.mine.joints.size(); ++k) {
    if (compare.on_impact[k] || compare.on_switch[k]) continue;
    const JointSample &a = compare.mine.joints[k][j], &b = compare.exact.joints[k][j];
    const auto& mine = torque ? a.torque_N_m : a.force_N;
    const auto& exact = torque ? b.torque_N_m : b.force_N;
    const unsigned open = (a.not_unique | b.not_unique) >> (torque ? 3 : 0);
    double squares = 0, bar_squares = 0;
    int compared = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      if ((open >> i) & 1U) {
        ++out.open;
        continue;
      }
      if (!finite(mine[i]) || !finite(exact[i])) {
        ++out.missing;
        continue;
      }
      ++compared;
      squares += std::pow(narrow(mine[i] - exact[i]), 2);
      double bar = 0;
      if (k < compare.truth.bars.size() && compare.truth.bars[k].joints.size() == compare.scene.joints.size()) {
        const JointSample& bars = compare.truth.bars[k].joints[j];
        bar = known(size_of(torque ? bars.torque_N_m[i] : bars.force_N[i]));
      }
      bar_squares += bar * bar;
      out.size = std::max(out.size, size_of(exact[i]));
    }
    if (compared == 0) continue;
    out.compared += compared;
    out.worst.take(std::sqrt(squares), std::sqrt(bar_squares));
  }
  return out;
}

void append_reactions(const Comparison& compare, bool torque, std::vector<Row>& rows) {
  const std::string metric = torque ? "error-reaction-torque" : "error-reaction-force";
  metrics::Largest all;
  double size = 0;
  int open = 0;
  const auto of_size = [&](double largest) {
    return "the largest true component is " + format_measure(largest, 0) + (torque ? " N m" : " N");
  };
  for (std::size_t j = 0; j < compare.scene.joints.size(); ++j) {
    const Reaction r = reaction_of(compare, j, torque);
    open += r.open;
    if (r.compared == 0) {
      if (r.open == 0) continue;  // not reported
      rows.push_back(row_of(metric, compare.scene.joints[j].name, std::nan(""), 0, "not unique"));
      rows.back().status = Status::unsupported;
      continue;
    }
    const std::string left_out =
        r.open > 0 ? "; " + std::to_string(r.open) + " components that are not unique are left out" : "";
    rows.push_back(
        row_of(metric, compare.scene.joints[j].name, r.worst.value(), r.worst.bar(), of_size(r.size) + left_out));
    all.figures.insert(all.figures.end(), r.worst.figures.begin(), r.worst.figures.end());
    size = std::max(size, r.size);
  }
  if (all.figures.empty()) return;
  rows.push_back(metrics::row(metric, all.value(), all.bar(),
                              of_size(size) + (open > 0 ? "; components that are not unique are left out" : "")));
}

std::vector<bool> samples_on_impacts(const Truth& truth) {
  std::vector<bool> on(truth.values.size(), false);
  for (std::size_t i = 0; i < truth.events.size(); ++i) {
    if (truth.events[i].kind != EventKind::impact) continue;
    const Wide bar = i < truth.event_bar_s.size() ? truth.event_bar_s[i] : 0;
    for (std::size_t k = 0; k < truth.values.size(); ++k)
      if (fabsq(truth.values[k].t_s - truth.events[i].t_s) <= bar) on[k] = true;
  }
  return on;
}

// Where a force is switched, to the rounding of the samples' times: a reaction may be that before or that after.
std::vector<bool> samples_on_switches(const Scenario& scenario, const Truth& truth) {
  constexpr double round_off = 0x1p-50;  // of the time
  const std::vector<double> switches = dynamics::switch_times(scenario.scene, 2 * scenario.t_end_s);
  std::vector<bool> on(truth.values.size(), false);
  for (std::size_t k = 0; k < on.size(); ++k) {
    const double t = narrow(truth.values[k].t_s);
    on[k] = std::any_of(switches.begin(), switches.end(),
                        [&](double at) { return std::abs(at - t) <= round_off * scenario.t_end_s; });
  }
  return on;
}

}  // namespace

bool has_mechanism(const Scene& scene) { return !scene.joints.empty() || !scene.ropes.empty(); }

int linked_bodies(const Scene& scene) {
  std::vector<bool> held(scene.bodies.size(), false);
  const auto hold = [&](int body) {
    if (body >= 0) held[static_cast<std::size_t>(body)] = !scene.bodies[static_cast<std::size_t>(body)].fixed;
  };
  for (const Joint& joint : scene.joints) hold(joint.parent), hold(joint.child);
  for (const Rope& rope : scene.ropes) hold(rope.bodies[0]), hold(rope.bodies[1]);
  return static_cast<int>(std::count(held.begin(), held.end(), true));
}

const Joint* stop_of(const Scene& scene, const Event& event) {
  for (const Joint& joint : scene.joints)
    if (joint.limits && ((joint.parent == event.body_a && joint.child == event.body_b) ||
                         (joint.parent == event.body_b && joint.child == event.body_a)))
      return &joint;
  return nullptr;
}

Recording with_joints(const Scene& scene, const Recording& run) {
  Recording full{{}, run.events, run.outcome};
  std::vector<JointSample> before = dynamics::joints_at_start(scene);
  for (const SampleView sample : run.values) {
    Sample whole = copy_of(sample);
    whole.joints = before = dynamics::joints_of(scene, sample, before);
    full.values.push_back(whole);
  }
  return full;
}

void metrics::append_joints(const Scenario& scenario, const Truth& truth, const Recording& run, const Observed& all,
                            std::vector<Row>& rows) {
  if (!has_mechanism(scenario.scene)) return;
  append_gaps(scenario, run, rows);
  if (!has_truth(truth) || scenario.scene.joints.empty()) return;
  const Motion exact = motion_of(scenario.scene, truth.values), mine = motion_of(scenario.scene, run.values),
               all_exact = motion_of(scenario.scene, all.truth.values),
               all_mine = motion_of(scenario.scene, all.run.values);
  const Comparison of_samples{
      scenario.scene, truth, mine, exact, samples_on_impacts(truth), samples_on_switches(scenario, truth), {}};
  const Comparison of_all{scenario.scene, all.truth, all_mine, all_exact, samples_on_impacts(all.truth), {},
                          all.judged};
  append_size(of_samples, rows);
  append_coordinates(of_all, rows);
  append_reactions(of_samples, false, rows);
  append_reactions(of_samples, true, rows);
}

std::vector<MetricInfo> joint_metrics() {
  return {
      {"joint-gap", "m",
       "Largest distance of a joint's two anchors over the samples, computed from the poses of its bodies; of a slider or "
       "cylindrical joint the part across its axis; of a rope the change of its length. `body` names the joint; without it: "
       "the largest of all."},
      {"joint-tilt", "rad",
       "Largest rotation that a joint does not allow, over the samples, computed from the poses of its bodies: of a hinge "
       "or cylindrical joint the angle between its axis as either body carries it, of a universal joint the change of the "
       "angle between its axes, of a slider or fixed joint the relative rotation. `body` names the joint."},
      {"error-joint-coordinate", "rad",
       "Largest error of a joint's coordinates over the instants of the run (see error-position-max): of angles and of a ball's rotation in rad, "
       "of offsets in m (the row's unit says which; the offset of a cylindrical joint stands in `body` joint.offset). "
       "Coordinates that are not reported are computed from the poses, whole turns left out. Without `body`: the largest of "
       "all that are not prescribed, angles in rad beside offsets in m."},
      {"error-joint-coordinate-end", "rad", "error-joint-coordinate of all joints, at the last sample only."},
      {"error-joint-coordinate-rms", "rad",
       "The largest of the root mean squares of the errors of all joints' coordinates, over the judged instants (see "
       "error-position-rms)."},
      {"error-joint-angle", "rad",
       "The largest error-joint-coordinate of angles and balls; prescribed ones are left out."},
      {"error-joint-offset", "m", "The largest error-joint-coordinate of offsets; prescribed ones are left out."},
      {"error-joint-rate", "rad/s",
       "Largest error of a joint's rates over the instants of the run (see error-position-max), those on the instant of an "
       "impact left out; of a ball the norm. Units and `body` as in error-joint-coordinate."},
      {"error-reaction-force", "N",
       "Largest norm of the error of a joint's constraint force on the child at its anchor over the samples, samples on the "
       "instant of an impact or of a force's switch left out. Components that the constraints leave open are not compared. Springs, dampers and "
       "motors are not part of it. The reason has the largest true component."},
      {"error-reaction-torque", "N m",
       "Largest norm of the error of a joint's constraint torque on the child about its anchor over the samples; left out "
       "is what error-reaction-force leaves out. The torque of a joint with a prescribed rate is part of it."},
      {"size-joint-coordinate", "rad",
       "Largest size of an angle [rad], whole turns counted, or an offset [m] of a joint along the true motion: what the "
       "round-off of joint coordinates is scaled by."},
      {"swinging-atwood-error", "1",
       "Largest change of the second invariant of a swinging Atwood machine with the mass ratio 3 (Tufillaro 1986), over "
       "the largest sum of the sizes of its terms."},
      {"step-time-per-link", "s", "step-time divided by the number of bodies that joints or ropes hold."},
  };
}

}  // namespace atwood
