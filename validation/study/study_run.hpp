// The state of a running study: its plan, and the data that its threads share. Private to run_study.cpp and
// timed_pass.cpp.
#pragma once

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "validation/study/campaigns.hpp"
#include "validation/study/pose_sweep.hpp"
#include "validation/study/progress.hpp"
#include "validation/study/store.hpp"
#include "validation/study/store_overview.hpp"
#include "validation/study/study.hpp"
#include "validation/study/worker_client.hpp"

namespace atwood {

struct TruthWork {
  enum class State { pending, running, ready };
  std::string hash;
  const Scenario* scenario = nullptr;
  State state = State::pending;
  std::string basis = {};              // of rows that are measured with it
  bool reused = false;                 // already known when planned
  std::shared_ptr<const Truth> truth;  // null while it is only in the store
  std::size_t ladders_left = 0;        // that still ask for it
};

struct Todo {
  const Cell* cell = nullptr;
  std::unique_ptr<const RunRecord> stored;  // set: the cell only has to be measured
};

struct Ladder {
  std::vector<Todo> todo;
  std::size_t truth = 0;
  double cost_ns = 0;  // expected; set where ladders run by cost
};

// One run of a study. Threads take work under `mutex_`, which protects everything below "the plan".
class StudyRun {
 public:
  StudyRun(const std::vector<Cell>& cells, const std::vector<Worker>& workers, const StudyOptions& options,
           Store& store, const Campaigns& campaigns)
      : cells_(cells), workers_(workers), options_(options), store_(store), campaigns_(campaigns),
        progress_(0, options.progress), touched_(cells.size()), ran_(cells.size()) {}

  void accuracy_pass();
  void timed_pass();
  int touched() const { return count(touched_); }  // cells that were run or measured
  int ran() const { return count(ran_); }
  int timed() const { return timed_; }
  int measured_again() const { return measured_again_; }
  int failed_truths() const { return failed_truths_; }
  const std::set<std::string>& without_recording() const { return without_recording_; }
  std::vector<Reused> reused() const;

 private:
  struct Task {
    enum class Kind { none, truth, ladder } kind = Kind::none;
    std::size_t index = 0;
  };

  static int count(const std::vector<bool>& cells) {
    return static_cast<int>(std::count(cells.begin(), cells.end(), true));
  }
  std::size_t index_of(const Cell& cell) const { return static_cast<std::size_t>(&cell - cells_.data()); }
  void plan_work();
  void order_by_cost();
  void forget_damaged();
  void plan_cell(const Cell& cell, const StoreOverview* overview);
  std::size_t truth_index(const Scenario& scenario);
  std::size_t find_truth(const Scenario& scenario);
  bool is_known(const TruthWork& work);
  RunRecord new_run(const Cell& cell) const;
  bool is_measured(const Cell& cell, const std::string& basis, const StoreOverview* overview) const;
  double left_s() const;         // of StudyOptions::until
  double truth_limit_s() const;  // of a truth that is asked for now
  bool loads_more(int worker, const WorkerClient& client);
  Task next();
  void work();
  void stop_for_failure();
  void solve_truth(TruthWork& work, WorkerClient& client);
  void run_ladder(const Ladder& ladder, std::map<int, WorkerClient>& clients, WorkerClient& truth_client);
  void run_probe_cell(const Cell& cell, const Truth& truth, const std::string& truth_hash,
                      std::map<int, WorkerClient>& clients);
  void run_sweep_cell(const Cell& cell, const std::string& truth_hash, std::map<int, WorkerClient>& clients);
  void note_without_recording(const std::vector<Row>& rows);
  WorkerClient& client_of(const Cell& cell, std::map<int, WorkerClient>& clients) const;
  std::shared_ptr<const Truth> truth_of(TruthWork& work);
  MeasuredRecord measured(const Cell& cell, const Truth& truth, const std::string& hash, const Recording& recording,
                          WorkerClient& truth_client);
  MeasuredRecord measured_fluid(const Cell& cell, const std::string& hash, const Recording& recording,
                                WorkerClient& client);
  Truth semi_discrete(const Cell& cell, const std::string& hash, const std::string& response, WorkerClient& client);
  std::vector<const Cell*> cells_to_time();

  const std::vector<Cell>& cells_;
  const std::vector<Worker>& workers_;
  const StudyOptions& options_;
  Store& store_;
  const Campaigns& campaigns_;
  Progress progress_;

  // the plan
  std::vector<TruthWork> truths_;
  std::map<std::string, std::size_t> truth_by_scenario_, truth_by_hash_;
  const Scenario* last_scenario_ = nullptr;  // whose truth was asked for last: that of many cells in turn
  std::size_t last_truth_ = 0;
  std::vector<Ladder> ladders_;
  std::map<std::string, std::size_t> ladder_index_;  // empty when all is planned
  std::string truth_build_;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<bool> taken_;                         // of ladders_
  std::size_t first_truth_ = 0, first_ladder_ = 0;  // all before them are taken
  std::exception_ptr failure_;
  bool stop_ = false;
  int failed_truths_ = 0, timed_ = 0, measured_again_ = 0;
  std::set<int> told_to_load_more_;          // workers
  std::set<std::string> without_recording_;  // metrics
  std::vector<bool> touched_, ran_;          // of cells_; ran_: those whose accuracy run is new
  PoseTruths pose_truths_{store_, options_.truth_worker};
};

inline double limit_of(const Cell& cell, const StudyOptions& options) {
  return cell.limit_s > 0 ? cell.limit_s : options.cell_limit_s;
}

}  // namespace atwood
