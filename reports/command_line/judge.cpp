// gate and bless: judge the rows of the store, or make them the baseline.
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "reports/command_line/command_line.hpp"
#include "reports/command_line/many_cells.hpp"
#include "reports/command_line/verdicts.hpp"
#include "scene/files.hpp"
#include "validation/study/write_file.hpp"

namespace atwood {
namespace fs = std::filesystem;

namespace {

void print_gate(const Options& options, const ReportData& data, bool gates_judged) {
  if (options.json) {
    fmt::print("{}\n", gates_judged ? render_json(data) : render_baseline_json(data.baseline));
    return;
  }
  const std::string baseline = data.baseline_path.empty() ? "" : "baseline: " + data.baseline_path;
  if (options.quiet) {
    fmt::print("{}", render_quiet(data, baseline.empty() ? "store: " + options.out_dir + "/store.db" : baseline));
    return;
  }
  const bool colour = use_colour(STDOUT_FILENO);
  if (!data.baseline_path.empty())
    fmt::print("{}{}\n", render_baseline_table(data.baseline_path, data.baseline, colour),
               improvements_hint(options, data));
  for (const std::string& note : data.notes) fmt::print("{}\n", note);
  if (!data.notes.empty()) fmt::print("\n");
  fmt::print("{}", render_verdict_table(data.verdicts, data.rows, colour, terminal_width()));
}

}  // namespace

int no_baseline(const Options& options, const std::string& path) {
  fmt::print(stderr, "atwood: no baseline at {}; `{}` writes one\n", path, same_call(options, "bless", path));
  return exit_no_baseline;
}

int command_gate(const Place& place, const Options& options) {
  require_outputs_make_sense(options);
  const Selection selection = select_cells(place, options);
  // With a baseline on the command line and no tolerances the baseline alone is judged.
  const bool gates_judged = options.baseline.empty() || !selection.tolerances.empty();
  const Standards standards = read_standards(place, selection, gates_judged);
  if (!selection.baseline.empty() && !standards.baseline) return no_baseline(options, selection.baseline);
  if (standards.baseline && standards.baseline->entries.empty()) {
    fmt::print(stderr, "atwood: {} holds no figure; `{}` writes one that does\n", selection.baseline,
               same_call(options, "bless", selection.baseline));
    return exit_no_baseline;
  }
  if (has_many_cells(options, selection, standards) && fs::exists(options.out_dir + "/store.db"))
    return gate_many(place, options, selection, standards);
  const StudyResult stored = load_rows(options.out_dir + "/store.db", selection.cells);
  const bool no_store = !fs::exists(options.out_dir + "/store.db");
  if (no_store)
    fmt::print(stderr, "atwood: no store at {}/store.db; `{}` makes one\n", options.out_dir, same_call(options, "run"));
  const Judged judged = judge_everything(place, options, selection, standards, stored, false);
  ReportData data;
  data.title = "gate";
  data.command = options.program;
  data.program = shell_line(std::vector{options.words.front()});
  data.provenance = place.provenance;
  data.rows = stored.rows;
  add_judged(data, selection, judged);
  if (standards.baseline) data.baseline_path = selection.baseline;
  if (const std::string missing = missing_words(selection, stored); !missing.empty() && !no_store)
    data.notes.push_back(fmt::format("{}: `{}` makes them.", missing, same_call(options, "run")));
  if (options.json) data.rows.clear();  // `run` and `report` print them
  print_gate(options, data, gates_judged);
  if (!options.junit.empty()) write_file(options.junit, render_junit(data.verdicts, data.cells));
  report_to_github(options, data);
  const int code = exit_of(stored, data.verdicts);
  return no_store && code == exit_pass ? exit_gate : code;
}

int command_bless(const Place& place, const Options& options) {
  if (options.reason.find_first_not_of(" \t\n") == std::string::npos)
    throw InputError("bless: --reason is empty; expected words that say why");
  const Selection selection = select_cells(place, options);
  std::signal(SIGXFSZ, SIG_IGN);  // under a file-size limit writes then fail with EFBIG
  const StudyResult stored = load_rows(options.out_dir + "/store.db", selection.cells);
  if (!fs::exists(options.out_dir + "/store.db"))
    throw InputError(
        fmt::format("bless: no store at {}/store.db; `{}` makes one", options.out_dir, same_call(options, "run")));
  if (stored.rows.empty())
    throw InputError(fmt::format("bless: {}/store.db has no rows of this study; `{}` makes them", options.out_dir,
                                 same_call(options, "run")));
  if (const std::string missing = missing_words(selection, stored); !missing.empty())
    throw InputError(
        fmt::format("bless: {}; `{}` makes them, and then they can be blessed", missing, same_call(options, "run")));
  const std::string path = selection.baseline.empty() ? "atwood-baseline.tsv" : selection.baseline;
  const BaselineText text = baseline_text(stored.rows, options.reason);
  // The figures last: if the second write fails, old figures with a newer environment are only compared more carefully.
  write_file(path + ".env", text.environment);
  write_file(path, text.figures);
  if (options.json) {
    const nlohmann::ordered_json out{{"baseline", path}, {"rows", stored.rows.size()}, {"reason", options.reason}};
    fmt::print("{}\n", out.dump(2));
  } else {
    fmt::print("wrote the baseline {} (every row that can be judged) and {}.env (what it was measured with)\n", path,
               path);
  }
  return exit_pass;
}

}  // namespace atwood
