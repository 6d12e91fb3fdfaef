// The tables of the store, and the upgrade of an older schema.
#pragma once

#include <array>
#include <string>

namespace SQLite {
class Database;
}

namespace atwood {

inline constexpr int kStoreApplication = 0x41747764;  // "Atwd", in the file's header
inline constexpr int kStoreSchema = 4;

// A table whose entries are found by their first column and end with the checksum of all the others. `counted`: the
// number and the sum of its keys are stored in `totals`, so that a missing entry is noticed.
struct StoreTable {
  const char* name;
  const char* columns;  // without the checksum
  int count;            // of columns
  bool counted;
};

inline constexpr StoreTable kProvenances{
    "provenances", "hash, engine_version, commit_id, compiler, flags, cpu, cpu_features, libm, run_id", 9, false};
inline constexpr StoreTable kRuns{"runs", "id, begun_ns, ended_ns", 3, false};
inline constexpr StoreTable kCampaigns{"campaigns", "id, series, engine, run_id, touched, complete", 6, true};
inline constexpr StoreTable kCells{"cells",
                                   "hash, scenario, method, steps, status, reason, steps_taken, rate_evaluations, "
                                   "wall_ns, limit_s, killed_from_outside, provenance",
                                   12, true};
// `kept`: 'all', or 'end' where only the last sample is kept. Blobs here and in `measured` are compressed.
inline constexpr StoreTable kSeries{"series", "hash, samples, events, kept", 4, false};
inline constexpr StoreTable kMeasured{"measured", "key, cell, basis, rows, errors", 5, true};
inline constexpr StoreTable kTimings{
    "timings", "hash, cell, status, reason, steps_taken, rate_evaluations, busy_ns, provenance, host, call_ns", 10,
    true};
// A truth of very many samples is several entries: its own, and parts of its samples and bars (store.cpp).
inline constexpr StoreTable kTruths{
    "truths", "hash, scenario, status, reason, source, note, condition, samples, bars, events, event_bars", 11, false};
// The plans that shards ran a share of, and those shares. `cells`: of the whole plan, to tell which ones are absent.
inline constexpr StoreTable kPlans{"plans", "hash, study, cells", 3, false};
inline constexpr StoreTable kShards{"shards", "id, plan, number, count, costs, source, host, complete", 8, false};
inline constexpr std::array kStoreTables{&kProvenances, &kRuns,    &kCampaigns, &kCells, &kSeries,
                                         &kMeasured,    &kTimings, &kTruths,    &kPlans, &kShards};

extern const char* const kStoreTablesSql;

}  // namespace atwood
