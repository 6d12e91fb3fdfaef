#include "validation/study/pose_sweep.hpp"

#include <algorithm>
#include <chrono>
#include <filesystem>

#include "scene/files.hpp"
#include "scene/pair_sweep.hpp"
#include "validation/metrics/measurements.hpp"
#include "validation/metrics/pose_metrics.hpp"
#include "validation/study/content_hash.hpp"
#include "validation/study/pose_file.hpp"

namespace atwood {
namespace {

// A pose's answer as a sample for the store's table of truths: the fields of a body's state hold the numbers of the
// answer.
Sample packed(const PoseAnswer& pose) {
  BodySample body;
  for (std::size_t i = 0; i < 3; ++i) body.p_m[i] = pose.x_m[i], body.v_m_per_s[i] = pose.normal[i];
  body.w_rad_per_s = {pose.gap_m, pose.toi_s, pose.margin_m};
  body.q_wxyz = {pose.hit ? 1.0 : 0.0, static_cast<Wide>(pose.points), pose.bar, 0};
  return {0, {body}};
}

PoseAnswer unpacked(const SampleView& sample) {
  const BodySample& body = checked(sample.bodies, 0);
  const auto narrow = [](Wide x) { return static_cast<double>(x); };
  PoseAnswer pose;
  for (std::size_t i = 0; i < 3; ++i) pose.x_m[i] = narrow(body.p_m[i]), pose.normal[i] = narrow(body.v_m_per_s[i]);
  pose.gap_m = narrow(body.w_rad_per_s[0]), pose.toi_s = narrow(body.w_rad_per_s[1]);
  pose.margin_m = narrow(body.w_rad_per_s[2]);
  pose.hit = body.q_wxyz[0] != 0, pose.points = static_cast<int>(body.q_wxyz[1]), pose.bar = narrow(body.q_wxyz[2]);
  return pose;
}

Row failed_row(const std::string& pair, bool swept, const Outcome& outcome) {
  Row row = metrics::row(swept ? "touch-misses" : "contact-misses", 0, 0, outcome.reason);
  row.body = pair;
  row.status = outcome.status;
  return row;
}

// The poses of a pair, of a worker that answers questions about contacts but generates no poses: one scene after
// another.
std::vector<PoseAnswer> ask_pose_by_pose(WorkerClient& client, const std::string& test, const std::string& pair,
                                         std::int64_t count, double limit_s, Outcome& outcome) {
  const auto start = std::chrono::steady_clock::now();
  std::vector<PoseAnswer> poses;
  for (std::int64_t k = 0; k < count; ++k) {
    const std::chrono::duration<double> busy = std::chrono::steady_clock::now() - start;
    const ContactAnswer found = client.contacts(scene_to_json(sweep_scene(pair, kPoseSeed, k, false)), 2, {},
                                                std::max(limit_s - busy.count(), 1e-3), test);
    if (found.outcome.status != Status::ok) {
      outcome = found.outcome;
      if (k > 0) outcome.reason += " (pose " + std::to_string(k) + " of seed " + std::to_string(kPoseSeed) + ")";
      return {};
    }
    for (const auto& [solver, tally] : found.outcome.solvers) outcome.solvers[solver].add(tally);
    poses.push_back(deepest_contact(found));
  }
  outcome.status = Status::ok;
  outcome.reason.clear();
  return poses;
}

std::string file_name(std::string method) {
  std::replace(method.begin(), method.end(), '/', '-');
  return method;
}

// Keeps the worst poses of the sweep of one pair as scene files.
void keep_poses(const Cell& cell, const std::string& pair, bool swept, const std::vector<WorstPose>& worst,
                const StudyOptions& options) {
  const auto beside_store = std::filesystem::path(options.store_path).parent_path();
  const std::string folder = (beside_store / "poses" / (swept ? pair + "-swept" : pair)).string();
  for (const WorstPose& pose : worst) {
    const std::string name = file_name(cell.method) + "-" + pose.what;
    write_pose_file(folder + "/" + name + ".toml", pair + "-" + name,
                    cell.method + ": " + pose.what + ", pose " + std::to_string(pose.index) + " of seed " +
                        std::to_string(kPoseSeed) + ", error " + format_double(pose.error),
                    sweep_scene(pair, kPoseSeed, pose.index, swept), kSweepEndS);
  }
}

}  // namespace

const std::vector<PoseAnswer>& PoseTruths::of(const std::string& pair, std::int64_t count, bool swept, double limit_s,
                                              Outcome& outcome) {
  const std::string key = content_hash({"poses 1", pair, std::to_string(kPoseSeed), std::to_string(count),
                                        swept ? "swept" : "still", file_hash(worker_)});
  Entry* entry = nullptr;
  {
    const std::lock_guard<std::mutex> held(mutex_);
    entry = &entries_[key];
  }
  const std::lock_guard<std::mutex> held(entry->mutex);
  if (!entry->known) {
    if (!store_.truth_damage(key).empty()) store_.forget_truth(key);
    if (const auto stored = store_.truth(key)) {
      for (const SampleView sample : stored->values) entry->poses.push_back(unpacked(sample));
    } else {
      WorkerClient client({worker_});
      entry->poses = client.sweep("", pair, kPoseSeed, count, swept, limit_s, entry->outcome);
      if (entry->outcome.status == Status::ok) {
        Truth truth;
        truth.source = "exact geometry in long double";
        for (const PoseAnswer& pose : entry->poses) truth.values.push_back(packed(pose));
        store_.put_truth(key, pair, truth);
      }
    }
    entry->known = true;
  }
  outcome = entry->outcome;
  return entry->poses;
}

PoseAnswer deepest_contact(const ContactAnswer& found) {
  PoseAnswer pose;
  for (const FoundContact& contact : found.contacts) {
    const double gap = -static_cast<double>(contact.depth_m);
    if (pose.hit && !(gap < pose.gap_m)) continue;
    pose.hit = true;
    pose.gap_m = gap;
    for (std::size_t i = 0; i < 3; ++i) pose.normal[i] = static_cast<double>(contact.normal[i]);
  }
  return pose;
}

std::vector<Row> sweep_rows(const Cell& cell, WorkerClient& client, PoseTruths& truths, const StudyOptions& options,
                            double cell_limit_s, const std::string& scalar, Outcome& outcome) {
  const bool swept = cell.probe == Probe::touch_sweep;
  const std::string test = cell.method.substr(cell.method.find('/') + 1);
  const double limit_s = 10 * cell_limit_s + 0.01 * static_cast<double>(cell.plan.steps);
  std::vector<Row> rows;
  Recording all;  // of all pairs: how the engine's solvers ended
  for (const std::string& pair : swept ? touch_pairs() : sweep_pairs()) {
    Outcome answered, known;
    std::vector<PoseAnswer> poses = client.sweep(test, pair, kPoseSeed, cell.plan.steps, swept, limit_s, answered);
    if (answered.status == Status::unsupported && !swept)
      poses = ask_pose_by_pose(client, test, pair, cell.plan.steps, limit_s, answered);
    if (answered.status != Status::ok) {
      rows.push_back(failed_row(pair, swept, answered));
      if (answered.status != Status::unsupported) outcome = answered;
      continue;
    }
    for (const auto& [solver, tally] : answered.solvers) all.outcome.solvers[solver].add(tally);
    const std::vector<PoseAnswer>& exact = truths.of(pair, cell.plan.steps, swept, limit_s, known);
    if (known.status != Status::ok) {
      rows.push_back(failed_row(pair, swept, {Status::unsupported, "no truth: " + known.reason, 0, 0, {}}));
      continue;
    }
    const auto scene_of = [&, &pair = pair](std::int64_t k) { return sweep_scene(pair, kPoseSeed, k, swept); };
    const PoseRows measured = measure_poses(pair, swept, scene_of, poses, exact, input_rounding(scalar, test));
    rows.insert(rows.end(), measured.rows.begin(), measured.rows.end());
    keep_poses(cell, pair, swept, measured.worst, options);
  }
  const std::vector<Row> whole = over_all_pairs(rows);
  rows.insert(rows.begin(), whole.begin(), whole.end());
  metrics::append_solver_figures(all, rows);
  return rows;
}

}  // namespace atwood
