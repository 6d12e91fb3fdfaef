// run as a share of a study, dry runs of its split, merge, costs.
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <numeric>
#include <set>
#include <tuple>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "reports/command_line/command_line.hpp"
#include "reports/command_line/history.hpp"
#include "reports/command_line/shard.hpp"
#include "reports/command_line/verdicts.hpp"
#include "scene/files.hpp"
#include "validation/study/content_hash.hpp"
#include "validation/study/lease.hpp"
#include "validation/study/merge.hpp"
#include "validation/study/process.hpp"
#include "validation/study/shares.hpp"
#include "validation/study/write_file.hpp"

namespace atwood {
namespace {

// Of a plan: enough that the last ones are short, few enough that a chunk is worth a process.
constexpr std::size_t kMaxChunks = 256;
constexpr std::size_t kMaxListed = 50;  // cells named in a message
constexpr int kMaxShares = 100'000;     // shares listed by a dry run

std::string plural(std::size_t count, const char* word) {
  return fmt::format("{} {}{}", count, word, count == 1 ? "" : std::string_view(word).ends_with('s') ? "es" : "s");
}

Costs costs_of(const Options& options) { return options.costs.empty() ? Costs{} : read_costs(options.costs); }

std::string variable(const std::string& name) {
  const char* value = std::getenv(name.c_str());
  return value ? value : "";
}

// The cells of one share, in the order of the study.
std::vector<std::size_t> own_share(const Ladders& ladders, const StudyShare& share) {
  std::vector<std::size_t> cells;
  const std::vector<int> dealt = deal(ladders.cells.size(), share.count);
  for (std::size_t i = 0; i < dealt.size(); ++i)
    if (dealt[i] == share.number - 1) cells.insert(cells.end(), ladders.cells[i].begin(), ladders.cells[i].end());
  std::sort(cells.begin(), cells.end());
  return cells;
}

// The cells of each share, in the order of the study.
std::vector<std::vector<std::size_t>> split(const Ladders& ladders, int count) {
  std::vector<std::vector<std::size_t>> shares(static_cast<std::size_t>(count));
  const std::vector<int> dealt = deal(ladders.cells.size(), count);
  for (std::size_t i = 0; i < dealt.size(); ++i) {
    auto& share = shares[static_cast<std::size_t>(dealt[i])];
    share.insert(share.end(), ladders.cells[i].begin(), ladders.cells[i].end());
  }
  for (auto& share : shares) std::sort(share.begin(), share.end());
  return shares;
}

std::vector<Cell> cells_at(const std::vector<Cell>& cells, const std::vector<std::size_t>& indices) {
  std::vector<Cell> some;
  some.reserve(indices.size());
  for (const std::size_t i : indices) some.push_back(cells[i]);
  return some;
}

void refuse_documents(const Options& options, const std::string& source) {
  const char* named = !options.outputs.empty()    ? "-o"
                      : !options.junit.empty()    ? "--junit"
                      : !options.baseline.empty() ? "--baseline"
                      : options.json              ? "--json"
                                                  : nullptr;
  if (named)
    throw InputError(fmt::format(
        "{}: a share of a study ({}) makes no documents: orders and gates need all shares; `atwood merge` joins their "
        "stores, and `atwood report` and `atwood gate` read the joined one",
        named, source));
}

// What a share's cells came to, over all of its calls of run_study.
struct Ended {
  int code = exit_pass, cells = 0, ran = 0, timed = 0, failed = 0, signal = 0;
  std::set<std::string> without_recording = {};
};

// The cells that a row names: a share's rows are those that are not ok, of few of its cells.
std::vector<Cell> cells_of_rows(const std::vector<Cell>& cells, const std::vector<Row>& rows) {
  std::set<std::tuple<std::string, std::string, std::int64_t>> named;
  for (const Row& row : rows) named.insert({row.scenario, row.method, row.steps});
  std::vector<Cell> some;
  if (named.empty()) return some;
  for (const Cell& cell : cells)
    if (named.contains({cell.scenario->id, cell.method, cell.plan.steps})) some.push_back(cell);
  return some;
}

void add(Ended& ended, const StudyResult& result, Selection& part, const std::vector<Cell>& cells) {
  part.cells = cells_of_rows(cells, result.rows);
  int bad = 0;
  for (const CellEnding& ending : endings_of(part, result.rows)) {
    if (!ending.fails) continue;
    ++bad;
    fmt::print(stderr, "atwood: {}, {}, {} steps: {}: {}\n", ending.scenario, ending.method, ending.steps,
               to_string(ending.status), printable(ending.reason));
  }
  ended.cells += result.cells, ended.ran += result.ran, ended.timed += result.timed, ended.failed += bad;
  ended.without_recording.insert(result.without_recording.begin(), result.without_recording.end());
  if (result.failed_cells > 0) ended.code = exit_cell;
  else if (bad > 0 && ended.code == exit_pass) ended.code = exit_gate;
  if (result.interrupted) ended.signal = result.signal;
}

Ended run_chunks(const Selection& selection, const Ladders& ladders, const Options& options, const Costs& costs,
                 StudyOptions& how) {
  const InterruptGuard guard;
  Ended ended;
  Selection part = without_cells(selection);
  const auto all = chunks(ladders, kMaxChunks);
  const std::string plan =
      content_hash({"lease 1", plan_hash(selection.cells), costs.hash, std::to_string(all.size())});
  Lease lease(options.lease, plan, all.size(), fmt::format("{}-{}", how.host, getpid()), options.lease_expiry_s);
  how.shard->last = false;
  while (const auto chunk = lease.take()) {
    const std::vector<Cell> cells = cells_at(selection.cells, all[*chunk]);
    const StudyResult result = run_study(cells, selection.workers, how);
    how.shard->plan = result.plan;
    add(ended, result, part, cells);
    if (ended.signal != 0) return ended;
    lease.done();
  }
  ended.signal = interrupt_signal();
  if (ended.signal != 0) return ended;
  how.shard->last = true;
  run_study({}, selection.workers, how);
  return ended;
}

}  // namespace

std::optional<StudyShare> share_of(const Options& options) {
  if (!options.shard.empty()) return parse_share(options.shard);
  std::optional<StudyShare> share = share_of_launcher(variable);
  return share && share->count > 1 ? share : std::nullopt;
}

int dry_run(const Selection& selection, const Options& options, const std::optional<StudyShare>& share) {
  const Costs costs = costs_of(options);
  const Ladders ladders = ladders_by_cost(selection.cells, costs);
  const int count = share ? share->count : 1;
  if (count > kMaxShares)
    throw InputError(
        fmt::format("--dry-run: lists every share, and there are {}; expected at most {}", count, kMaxShares));
  const auto shares = split(ladders, count);
  std::vector<double> cost_ns(shares.size());
  std::vector<std::size_t> ladders_of(shares.size());
  const std::vector<int> dealt = deal(ladders.cells.size(), count);
  for (std::size_t i = 0; i < dealt.size(); ++i) {
    cost_ns[static_cast<std::size_t>(dealt[i])] += ladders.cost_ns[i];
    ++ladders_of[static_cast<std::size_t>(dealt[i])];
  }
  const double total = std::accumulate(cost_ns.begin(), cost_ns.end(), 0.0);
  const std::size_t cells = std::accumulate(shares.begin(), shares.end(), std::size_t{0},
                                            [](std::size_t sum, const auto& one) { return sum + one.size(); });
  if (options.json) {
    nlohmann::ordered_json out{{"study", selection.study}, {"plan", plan_hash(selection.cells)}, {"costs", costs.hash}};
    for (std::size_t i = 0; i < shares.size(); ++i) {
      nlohmann::ordered_json names = nlohmann::ordered_json::array();
      for (const std::size_t cell : shares[i])
        names.push_back(
            fmt::format("{}, {} steps", ladder_name(selection.cells[cell]), selection.cells[cell].plan.steps));
      out["shares"].push_back(
          {{"share", i + 1}, {"ladders", ladders_of[i]}, {"cost_ns", cost_ns[i]}, {"cells", names}});
    }
    fmt::print("{}\n", out.dump(2));
    return exit_pass;
  }
  for (std::size_t i = 0; i < shares.size(); ++i)
    fmt::print("{}/{}  {:>9}  {:>10}  {:5.1f} % of the cost{}\n", i + 1, count, plural(shares[i].size(), "cell"),
               plural(ladders_of[i], "ladder"), total > 0 ? 100 * cost_ns[i] / total : 0.0,
               share && share->number == static_cast<int>(i) + 1 ? "  <- this process" : "");
  fmt::print("{}: {} in {}; costs: {}; nothing was run\n", selection.study, plural(cells, "cell"),
             plural(static_cast<std::size_t>(count), "share"),
             options.costs.empty() ? "steps times bodies" : options.costs);
  return exit_pass;
}

int run_share(const Place& place, const Options& options, const Selection& selection,
              const std::optional<StudyShare>& given) {
  const StudyShare share = given ? *given : StudyShare{1, 1, "--lease"};
  refuse_documents(options, share.source);
  const Costs costs = costs_of(options);
  make_out_dir(options.out_dir);
  StudyOptions how = study_options(place, options);
  how.narrowed =
      !options.scenarios.empty() || !options.methods.empty() || !options.steps.empty() || !options.hz.empty();
  // A lease without a launcher: each process has a store of its own, which a process with the same name goes on with.
  how.store_path = given ? fmt::format("{}/shard-{}-of-{}.db", options.out_dir, share.number, share.count)
                         : fmt::format("{}/lease-{}-{}.db", options.out_dir, how.host, getpid());
  how.shard = ShardOfPlan{selection.study, &selection.cells, share.number, share.count, costs.hash, share.source, true};
  how.costs = std::make_shared<const Costs>(costs);
  if (!options.quiet) how.progress = progress_printer(options);
  Ended ended;
  if (!options.lease.empty()) {
    ended = run_chunks(selection, ladders_by_cost(selection.cells, costs), options, costs, how);
  } else {
    const std::vector<std::size_t> own = own_share(ladders_by_cost(selection.cells, costs), share);
    const bool whole = own.size() == selection.cells.size();  // a million cells are not copied
    const std::vector<Cell> some = whole ? std::vector<Cell>() : cells_at(selection.cells, own);
    const std::vector<Cell>& cells = whole ? selection.cells : some;
    const StudyResult result = run_study(cells, selection.workers, how);
    if (!options.quiet && !result.reused.empty())
      std::fputs(("atwood: " + reused_text(result.reused) + "\n").c_str(), stderr);
    Selection part = without_cells(selection);
    add(ended, result, part, cells);
  }
  end_progress();
  if (ended.signal != 0) {
    if (options.lease.empty())
      fmt::print(stderr, "atwood: interrupted; what was done is in {}, and the same command goes on from there\n",
                 how.store_path);
    else
      fmt::print(stderr,
                 "atwood: interrupted; what was done is in {}; a chunk that was not finished is back in {}, where the "
                 "next process of the same command takes it; merge the stores of all of them\n",
                 how.store_path, options.lease);
    return 128 + ended.signal;
  }
  report_without_recording(options, ended.without_recording);
  fmt::print("share {} of {} ({}): {}, {} of them run, {} timed, {} ended badly; store: {}\n", share.number,
             share.count, options.lease.empty() ? share.source : "--lease",
             plural(static_cast<std::size_t>(ended.cells), "cell"), ended.ran, ended.timed, ended.failed,
             how.store_path);
  return ended.code;
}

int command_merge(const Place& place, const Options& options) {
  if (options.outputs.size() != 1) throw InputError("merge: expected one -o FILE, the joined store");
  const std::string& out = options.outputs.front();
  if (const auto folder = std::filesystem::path(out).parent_path(); !folder.empty()) make_out_dir(folder.string());
  const Merged merged = merge_stores(options.stores, out);
  if (!merged.conflicts.empty()) {
    fmt::print(stderr,
               "atwood: merge: nothing was written, for the same cells have different results: their engine is "
               "not deterministic, or their hash does not cover all of its code\n");
    for (const std::string& line : merged.conflicts) fmt::print(stderr, "  {}\n", line);
    return exit_gate;
  }
  note_merge(place, options, out);
  if (options.json) {
    const nlohmann::ordered_json told{{"store", out},
                                      {"cells", merged.cells},
                                      {"twice", merged.twice},
                                      {"ended_differently", merged.ended_differently},
                                      {"times_of_other_hosts", merged.other_host},
                                      {"absent", merged.absent}};
    fmt::print("{}\n", told.dump(2));
    return exit_pass;
  }
  fmt::print("{}: {} of {}", out, plural(merged.cells, "cell"), plural(options.stores.size(), "store"));
  if (merged.twice > 0) fmt::print("; {} in several, with the same results", merged.twice);
  if (merged.ended_differently > 0)
    fmt::print("; {} in several, with different endings: what ended by itself is taken before a timeout or a kill",
               merged.ended_differently);
  fmt::print("\n");
  if (merged.other_host > 0)
    fmt::print("{} left out: another host's of the same cell was taken\n", plural(merged.other_host, "timed pass"));
  if (merged.absent.empty()) return exit_pass;
  fmt::print("{} of the shards' plan {} in none of these stores:\n", plural(merged.absent.size(), "cell"),
             merged.absent.size() == 1 ? "is" : "are");
  for (std::size_t i = 0; i < merged.absent.size() && i < kMaxListed; ++i) fmt::print("  {}\n", merged.absent[i]);
  if (merged.absent.size() > kMaxListed) fmt::print("  ... and {} more (--json)\n", merged.absent.size() - kMaxListed);
  return exit_pass;
}

int command_costs(const Place& place, const Options& options) {
  if (options.outputs.size() > 1) throw InputError("-o: expected one file");
  if (!options.outputs.empty()) require_output(options.outputs.front());
  const Selection selection = select_cells(place, options);
  const Costs costs = learn_costs(options.out_dir + "/store.db", selection.cells);
  const std::string text = costs_to_json(costs);
  if (options.outputs.empty()) fmt::print("{}", text);
  else write_file(options.outputs.front(), text);
  return exit_pass;
}

}  // namespace atwood
