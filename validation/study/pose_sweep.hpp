// Cells that are sweeps of poses: a worker's contacts against the truth's, pair by pair.
#pragma once

#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "validation/study/store.hpp"
#include "validation/study/worker_client.hpp"

namespace atwood {

inline constexpr std::uint64_t kPoseSeed = 42;

// The exact answers to the poses of a pair: computed once by the worker of truths, kept in the store, shared by all
// threads.
class PoseTruths {
 public:
  PoseTruths(Store& store, std::string truth_worker) : store_(store), worker_(std::move(truth_worker)) {}
  // Empty where there is no answer; the outcome then has the reason.
  const std::vector<PoseAnswer>& of(const std::string& pair, std::int64_t count, bool swept, double limit_s,
                                    Outcome& outcome);

 private:
  struct Entry {
    std::mutex mutex;
    bool known = false;
    std::vector<PoseAnswer> poses;
    Outcome outcome;
  };
  Store& store_;
  std::string worker_;
  std::mutex mutex_;
  std::map<std::string, Entry> entries_;
};

// The deepest of the contacts found, as the answer to a pose; none: apart, at a distance that is not given.
PoseAnswer deepest_contact(const ContactAnswer& found);

// Rows of every pair (body: the pair); the worst poses go to FOLDER OF THE STORE/poses/PAIR/METHOD-WHAT.toml.
// `scalar`: the engine's, in which it takes its inputs. `outcome`: of the worker, where it failed otherwise than by not
// supporting a pair. A worker that refuses a sweep of poses is asked for the contacts of one pose after another.
std::vector<Row> sweep_rows(const Cell& cell, WorkerClient& client, PoseTruths& truths, const StudyOptions& options,
                            double cell_limit_s, const std::string& scalar, Outcome& outcome);

// ---- tables -------------------------------------------------------------------------------------------------------
// A case with an answer derived by hand. A pair's file (validation/scenarios/geometry/PAIR.toml) lists them: name,
// gap_m, normal where it is unique, and two [[case.body]] as in a scenario.
struct ContactCase {
  std::string name;
  Scene scene;
  PoseAnswer answer;
};
std::vector<ContactCase> read_contact_cases(const std::string& path);  // InputError
// Rows of every pair's file in the folder (body: the pair), by the contact test that the cell's method names.
std::vector<Row> table_rows(const Cell& cell, WorkerClient& client, const std::string& folder, double limit_s,
                            const std::string& scalar, Outcome& outcome);

}  // namespace atwood
