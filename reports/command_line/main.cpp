// The command line: parses arguments into Options, runs one command, returns its exit code.
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <functional>
#include <new>
#include <sstream>
#include <system_error>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "protocol/descriptors.hpp"
#include "protocol/wire.hpp"
#include "reports/command_line/command_line.hpp"
#include "reports/command_line/history.hpp"
#include "reports/command_line/manual.hpp"
#include "reports/command_line/play.hpp"
#include "scene/files.hpp"
#include "scene/printable.hpp"
#include "validation/study/process.hpp"
#include "version.hpp"

namespace {

using namespace atwood;
using Command = std::function<int(const Place&, const Options&)>;

struct Parser {
  CLI::App app{
      "Atwood measures the accuracy of physics engines: convergence, conservation, collision and cost, against "
      "reference solutions (truths) with error bars.",
      "atwood"};
  Options options;
  Command chosen;

  CLI::App* add(const std::string& name, const std::string& doc, Command command) {
    auto* sub = app.add_subcommand(name, doc);
    sub->callback([this, command] { chosen = command; });
    sub->add_flag("--json", options.json, "Print JSON on standard output");
    return sub;
  }
  void counts(CLI::App* sub, const char* what) {
    auto* steps = sub->add_option("--steps", options.steps, what)->expected(1)->take_all();
    sub->add_option("--hz", options.hz, "Steps per second: the step count is t_end_s times HZ")
        ->expected(1)
        ->take_all()
        ->excludes(steps);
  }
  void resolution(CLI::App* sub) {
    sub->add_option("--spacing", options.spacings,
                    "Fluids: this spacing of the particles [m] instead of the scenario's")
        ->expected(1)
        ->take_all();
    sub->add_option("--sound-speed", options.sound_speeds, "Fluids: this sound speed [m/s] instead of the scenario's")
        ->expected(1)
        ->take_all();
  }
  void confining(CLI::App* sub) {
    sub->add_flag("--no-sandbox", options.no_sandbox,
                  "Engines of --engine may use the network and write anywhere (in a study: sandbox = false)");
    sub->add_option("--memory", options.memory_GiB, "Memory of each worker with its descendants [GiB]; 0: no limit")
        ->capture_default_str();
  }
  void other_engines(CLI::App* sub) {
    sub->add_option("--engine", options.engines, "Add an engine: an executable that speaks the worker protocol")
        ->expected(1)
        ->take_all();
    confining(sub);
  }
  void narrowing(CLI::App* sub) {
    sub->add_option("--scenario,--filter", options.scenarios, "Only these scenarios: ids, globs or files")
        ->expected(1)
        ->take_all();
    sub->add_option("--method", options.methods, "Only these methods: ids or globs")->expected(1)->take_all();
    counts(sub, "Only these step counts");
    resolution(sub);
    other_engines(sub);
    sub->add_option("--out", options.out_dir, "Where the store and the report go")->capture_default_str();
    sub->add_option("--max-cells", options.max_cells, "Refuse a study that plans more cells than this")
        ->capture_default_str();
  }
  void shown_progress(CLI::App* sub) {
    sub->add_flag("--progress", options.progress, "Show progress even if standard error is not a terminal");
  }
  void running(CLI::App* sub) {
    narrowing(sub);
    sub->add_option("-j,--jobs", options.jobs, "Cells run at once (default: one per core)");
    sub->add_option(
        "--limit", options.cell_limit_s,
        fmt::format("Seconds allowed for a cell (default: {:g}), instead of a `limit` in the study. A truth gets 6\n"
                    "times this; 120 s where --limit is not given",
                    options.cell_limit_s));
    auto* fresh = sub->add_flag("--fresh", options.fresh, "Run every cell again, also those in the store");
    sub->add_flag("--reuse", options.reuse,
                  "Reuse stored cells of the last completed run also for engines whose build cannot be identified\n"
                  "(by default they are measured again)")
        ->excludes(fresh);
    sub->add_flag("--no-timing", options.no_timing, "Skip the timed pass");
    shown_progress(sub);
    sub->add_option("-o,--output", options.outputs, "Also write this file; format csv, json, markdown, junit or html")
        ->expected(1)
        ->take_all();
    sub->add_option("--junit", options.junit, "Write verdicts as JUnit XML");
    sub->add_option("--tolerances", options.tolerances, "Gates from this file instead of the catalogue's own");
  }
  void telling(CLI::App* sub) {
    sub->add_flag("--quiet", options.quiet, "Print one line, and the gates and cells that did not pass");
    sub->add_flag("--github", options.github,
                  "Print annotations of GitHub Actions, and append a summary to $GITHUB_STEP_SUMMARY");
  }
};

// What there is, and one of it.
void declare_catalogue(Parser& p) {
  Options& o = p.options;
  auto* list = p.add("list", "Scenarios, methods, metrics, gates and studies", command_list);
  list->add_option("KIND", o.input, "scenarios, methods, metrics, gates or studies (default: all but studies)");
  list->add_flag("--long", o.long_list, "Methods with their documentation, source and settings");
  list->add_flag("--names", o.names, "Only names, one a line, as completion reads them")->group("");
  p.other_engines(list);

  auto* describe =
      p.add("describe", "A scene, a method with its claims and settings, or a metric's definition", command_describe);
  describe->add_option("SCENE|METHOD|METRIC", o.input, "A file, a catalogue id, a method id, or a metric's name")
      ->required();
  describe->add_flag("--program", o.evidence,
                     "For a library's method: print a standalone program that shows the order it executes");
  describe->add_option("--scenario", o.scenarios, "The scene of that program (default: kepler-e0.6)")->expected(1);
  p.other_engines(describe);
}

void declare_run(Parser& p) {
  Options& o = p.options;
  auto* run = p.add("run", "Run a study: measure, judge, report", command_run);
  run->add_option("STUDY", o.study,
                  "A study file, or the id of a study of the catalogue (default: the study `default`)");
  p.running(run);
  run->add_option("--baseline", o.baseline, "Also compare with this baseline: regressions and improvements");
  run->add_option("--shard", o.shard,
                  "Run share I of N, I from 1 to N, into OUT/shard-I-of-N.db (default: the share of Slurm,\n"
                  "MPI or an indexed Kubernetes job); `atwood merge` joins the stores");
  run->add_option("--costs", o.costs, "Split by these costs, a file of `atwood costs`, instead of steps times bodies");
  run->add_option("--lease", o.lease,
                  "Split the study while it runs: processes take chunks of it from this shared directory");
  run->add_option("--lease-expiry", o.lease_expiry_s,
                  "Seconds without a heartbeat after which another process takes over a chunk")
      ->capture_default_str();
  for (const char* name : {"--shard", "--costs", "--lease"})  // `--shard "$SHARE"` where SHARE is not set
    run->get_option(name)->each([name](const std::string& text) {
      if (text.empty()) throw InputError(std::string(name) + ": found an empty text; expected a value, or no " + name);
    });
  run->add_flag("--dry-run", o.dry_run, "Print how the study is split, and run nothing");
  run->add_option("--keep", o.keep,
                  "Recordings that are kept: all; worst (of each ladder the run with the largest error, and runs that\n"
                  "did not end ok); none. New metrics, plots and events can be computed from kept recordings only")
      ->check(CLI::IsMember({"all", "worst", "none"}))
      ->capture_default_str();
  p.telling(run);
}

// One scene: its motion, its pictures, its contacts, its derivatives.
void declare_single_scenes(Parser& p) {
  Options& o = p.options;
  auto* trace =
      p.add("trace",
            "One run's motion as CSV; --method truth prints the truth with its bars. Positions, velocities and\n"
            "q, which turns body axes into world axes, are in world axes; wx_rad_per_s, wy_rad_per_s and\n"
            "wz_rad_per_s are in body axes",
            command_trace);
  trace->add_option("SCENE", o.input, "A file or a catalogue id")->required();
  trace->add_option("--method", o.methods, "A method id, or truth")->required()->expected(1);
  p.counts(trace, "Step count (default: the scenario's last rung)");
  trace->add_option("--samples", o.samples, "Samples (default: the scenario's)");
  p.other_engines(trace);
  trace->add_option("--limit", o.cell_limit_s, "Seconds that the run may take")->capture_default_str();
  trace->add_flag("--events", o.events,
                  "Print impacts and changes of regime (stick, slip, roll, rest) instead of the motion");
  auto* particles = trace->add_flag("--particles", o.particles, "The particles of fluids instead of the bodies");
  trace->add_flag("--probes", o.probes, "The scene's probes of fluids instead of the bodies")->excludes(particles);
  auto* joints = trace->add_flag("--joints", o.joints,
                                 "The joints instead of the bodies: coordinates, rates, reactions, applied torques");
  trace->add_flag("--ropes", o.ropes, "The ropes instead of the bodies: tensions and angles of pulleys")
      ->excludes(joints);
  p.resolution(trace);
  trace
      ->add_option("-o,--output", o.outputs,
                   "vtk:DIR, the particles as files for ParaView: DIR/ID.pvd and one .vtp a sample")
      ->expected(1)
      ->take_all();

  auto* play = p.add("play", "The truth and methods in motion, as one page for a browser", command_play);
  play->add_option("SCENE", o.input, "A file or a catalogue id")->required();
  play->add_option("--method", o.methods, "A method drawn beside the truth; any number of them")
      ->expected(1)
      ->take_all();
  p.counts(play, "Step count of every method (default: the scenario's last rung)");
  play->add_option("--samples", o.samples, "Frames, each the pose at one instant (default: up to 600)");
  p.other_engines(play);
  play->add_option("--limit", o.cell_limit_s, "Seconds that a run may take")->capture_default_str();
  p.resolution(play);
  play->add_option("--out", o.out_dir, "Where the page goes unless -o names it")->capture_default_str();
  play->add_option("-o,--output", o.outputs, "html:FILE, the page (default: html:OUT/play-SCENE.html)")
      ->expected(1)
      ->take_all();

  auto* import =
      p.add("import", "A scene from a robot's description: URDF, or MJCF where MuJoCo is built", command_import);
  import->add_option("FILE", o.input, "FILE.urdf, or FILE.xml (MJCF)")->required();
  import->add_option("-o,--output", o.outputs, "The scene's file (default: standard output)")->expected(1);

  auto* contacts =
      p.add("contacts", "Contacts of the initial pose as CSV, or (--swept) the first touch of moving bodies",
            command_contacts);
  contacts->add_option("SCENE", o.input, "A file or a catalogue id")->required();
  contacts
      ->add_option(
          "--engine", o.engines,
          "The engine that answers: atwood (the default), truth, bullet64, bullet32, ode, fcl, libccd, jolt, mujoco3, rapier, or\n"
          "the path of an executable that speaks the worker protocol. Variants: box-edges (the naive test of edges against faces);\n"
          "bullet64/closest-points, bullet32/closest-points (the algorithms of contactPairTest instead of the stepped\n"
          "world's); ENGINE/unit-size (bodies scaled to unit size; bullet64, bullet32, ode, fcl, libccd)")
      ->expected(1);
  contacts->add_flag("--swept", o.swept,
                     "Move bodies with constant velocity and spin to the scene's end, and report the first touch");
  contacts->add_option("--limit", o.cell_limit_s, "Seconds that the answer may take")->capture_default_str();

  auto* derivatives =
      p.add("derivatives",
            "Derivatives of joint accelerations by coordinates, rates and forces, compared with finite differences",
            command_derivatives);
  derivatives->add_option("SCENE", o.input, "A file or a catalogue id: joints without loops")->required();
  derivatives->add_option("--at", o.at_s, "The time of the run")->capture_default_str();
  derivatives
      ->add_option("--method", o.methods,
                   "The method that runs the scene up to this time, or truth (default: atwood/dop853)")
      ->expected(1);
  p.counts(derivatives, "Steps of the whole run, and of MuJoCo's step (default: the scenario's last rung)");
  derivatives->add_flag("--ladder", o.ladder,
                        "The errors of forward and central differences against their steps instead, with MuJoCo's\n"
                        "derivatives of its own step");
  p.other_engines(derivatives);
  derivatives->add_option("--limit", o.cell_limit_s, "Seconds that the run, and each answer, may take")
      ->capture_default_str();
}

// Which method for a scene.
void declare_choices(Parser& p) {
  Options& o = p.options;
  auto* compare = p.add("compare", "Methods side by side: error, order and cost on each scenario", command_compare);
  compare->add_option("METHODS", o.methods, "Two or more method ids")->required()->expected(1, 64);
  compare->add_option("--scenario,--filter", o.scenarios, "Scenarios: ids, globs or files")->expected(1)->take_all();
  p.counts(compare, "Only these step counts");
  p.resolution(compare);
  compare->add_option("--metric", o.metric,
                      "The error that is compared: position, velocity, attitude, body-rate, state, energy, or a\n"
                      "metric's name (default: position, or attitude where the positions do not differ)");
  compare->add_option("--error", o.wanted_error, "Compare only the costs of this error, with its unit: 1e-6rad, 0.1mm");
  compare->add_option("--budget", o.budget, "Compare only the errors reached within this time: 16.7ms, 40us");
  compare->add_flag(
      "--same-rate", o.same_rate,
      "Give every method the reference's right-hand side and rank by these times (ours run as\n"
      "atwood-same-rate/...); native times are also printed. The default where every compared method allows it");
  compare->add_flag("--native-rate", o.native_rate, "Rank each method by times with its engine's own right-hand side")
      ->excludes("--same-rate");
  p.other_engines(compare);
  compare->add_option("--out", o.out_dir, "Where the store is")->capture_default_str();
  compare->add_option("-j,--jobs", o.jobs, "Cells run at once (default: one per core)");
  compare->add_option("--limit", o.cell_limit_s, "Seconds a cell may take; a truth six times that")
      ->capture_default_str();
  compare->add_flag("--no-timing", o.no_timing, "Skip the timed pass");
  p.shown_progress(compare);
  compare
      ->add_option("-o,--output", o.outputs,
                   "Write this file; format csv, json, markdown, junit or html (default: html:OUT/compare.html)")
      ->expected(1)
      ->take_all();

  auto* advise = p.add("advise", "Recommend a method and its step for a scene, with evidence", command_advise);
  advise->add_option("SCENE", o.input, "A file or a catalogue id")->required();
  advise->add_option(
      "--error", o.wanted_error,
      "The error that is allowed: 1e-8 (in the metric's unit; metres unless --metric says otherwise), 0.1mm,\n"
      "1e-6rad, 2cm/s; a unit decides the metric");
  advise->add_option("--budget", o.budget, "The time that a whole run may take: 16.7ms, 40us");
  advise->add_option("--metric", o.metric,
                     "position (the default), velocity, attitude, body-rate, state, energy, or a metric's name");
  advise->add_option("--method", o.methods, "Only these methods: ids or globs")->expected(1)->take_all();
  p.resolution(advise);
  advise->add_flag(
      "--same-rate", o.same_rate,
      "Only methods that evaluate the reference's right-hand side: ours and those of odeint, ARKODE, CVODE");
  p.other_engines(advise);
  advise
      ->add_option("--time", o.search_s,
                   "Seconds after which no further method is started; of fluids what runs ends, too")
      ->capture_default_str();
  p.shown_progress(advise);
  advise->add_option("--out", o.out_dir, "Where the store is")->capture_default_str();
  advise->add_option("-j,--jobs", o.jobs, "Cells run at once (default: one per core)");
  advise->add_option("--limit", o.cell_limit_s, "Seconds a run may take; a truth six times that")
      ->capture_default_str();

  auto* tune = p.add(
      "tune", "Search an engine's best settings for a class of scenes; its default settings are one of the trials",
      command_tune);
  tune->add_option("ENGINE", o.input, "atwood, bullet32, bullet64, jolt, mujoco3, ode or rapier")->required();
  tune->add_option("--class", o.scene_class, "free-flight, bounce, friction, stack, heap or mechanism")->required();
  tune->add_option("--trials", o.trials, "Sets of settings that are tried, the default included")
      ->capture_default_str();
  tune->add_option("--seed", o.seed, "Seed of the random sets and of the choice of scenes")->capture_default_str();
  tune->add_option("--scenario", o.scenarios, "Only these scenes of the class: ids or globs")->expected(1)->take_all();
  tune->add_option(
      "--file", o.tuned_file,
      "Where settings and evidence are kept (default: OUT/tuned.json). The `tuned` presets are built from\n"
      "reference/rivals/tuned.json");
  tune->add_flag("--no-timing", o.no_timing, "Compare at equal steps instead of equal time");
  tune->add_option("--out", o.out_dir, "Where the store is")->capture_default_str();
  tune->add_option("-j,--jobs", o.jobs, "Cells run at once (default: one per core)");
  tune->add_option("--limit", o.cell_limit_s, "Seconds a run may take")->capture_default_str();
  p.shown_progress(tune);
}

void declare_judgements(Parser& p) {
  Options& o = p.options;
  auto* check = p.add("check", "Judge a trace that any program recorded", command_check);
  check
      ->add_option("RUN.CSV", o.input,
                   "A file with the columns of `atwood trace`; those of attitude and angular velocity may be missing")
      ->required();
  check->add_option("--scenario", o.scenarios, "The scenario that the program ran: an id or a file")
      ->required()
      ->expected(1);
  check->add_option("--as", o.as_method,
                    "Judge the trace by the gates of this method (default: the method name `check`)");
  check->add_option("--max", o.limits, "Fail where the metric is above the value")->expected(1)->take_all();
  check->add_option("--tolerances", o.tolerances, "Gates from this file instead of the catalogue's own");
  check->add_option("--junit", o.junit, "Write verdicts as JUnit XML");

  auto* gate = p.add("gate", "Judge the rows in the store, by tolerances or against a baseline", command_gate);
  gate->add_option("STUDY", o.study, "The study whose rows are judged");
  p.narrowing(gate);
  gate->add_option("--tolerances", o.tolerances, "Gates from this file instead of the catalogue's own");
  gate->add_option("--baseline", o.baseline, "Compare with this baseline: regressions and improvements");
  gate->add_option("--junit", o.junit, "Write verdicts as JUnit XML");
  p.telling(gate);

  auto* bless = p.add("bless", "Write the rows in the store as the baseline", command_bless);
  bless->add_option("STUDY", o.study, "The study whose rows become the baseline");
  p.narrowing(bless);
  bless->add_option("--reason", o.reason, "Why this is the new baseline")->required();
  bless->add_option("--baseline", o.baseline, "The file (default: atwood-baseline.tsv)");
}

void declare_bench(Parser& p) {
  Options& o = p.options;
  auto* bench = p.add(
      "bench",
      "Measure times: kernels and steps with Google Benchmark, goals, the largest pile of bodies within a frame, broad phases",
      command_bench);
  bench->add_option(
      "FILTER", o.input,
      "`goals`: the project's goals beside its rivals, in one run. `frame-budget`: the largest heap and the\n"
      "largest block of fluid that each engine steps within a frame. `broad-phases`: pairs and times of the\n"
      "broad phases. Anything else: a regular expression over the names of benchmarks");
  bench->add_option("--goal", o.goals, "goals: only these, by ids or globs")->expected(1)->take_all();
  bench->add_option("--goals", o.goals_file, "goals: from this file instead of benchmarks/goals.toml");
  bench->add_option("--method", o.methods, "frame-budget: only these methods")->expected(1)->take_all();
  bench
      ->add_option("--engine", o.engines,
                   "goals, frame-budget: add an engine, an executable that speaks the worker protocol")
      ->expected(1)
      ->take_all();
  p.confining(bench);
  bench->add_option("--limit", o.cell_limit_s, "goals, frame-budget: seconds that a run may take")
      ->capture_default_str();
  bench->add_option("-j,--jobs", o.jobs, "goals: cells run at once in the accuracy pass");
  bench->add_flag("--no-timing", o.no_timing, "goals: measure errors and evaluations only");
  bench->add_option("--out", o.out_dir, "Where the figures go")->capture_default_str();
}

// What is made of a store.
void declare_stored_runs(Parser& p) {
  Options& o = p.options;
  auto* report = p.add("report", "Make the report again from the store", command_report);
  report->add_option("STUDY", o.study, "The study to report");
  p.narrowing(report);
  report->add_option("-o,--output", o.outputs, "Format csv, json, markdown, junit or html")->expected(1)->take_all();
  report->add_option(
      "--against", o.baseline,
      "Compare with an earlier run (its number, its commit, `last` or `previous`; `atwood history` lists\n"
      "the runs) or with a baseline's file: what became better or worse, appeared, vanished");
  report->add_option("--tolerances", o.tolerances, "Gates from this file instead of the catalogue's own");

  auto* history = p.add("history", "The runs so far, or with --metric a metric over runs", command_history);
  history->add_option("STUDY", o.study, "Only runs of the study with this id");
  history->add_option(
      "--metric", o.metric,
      "This metric over runs (a glob), with the runs where its level changes; each scenario, method and\n"
      "step count is a figure of its own");
  history->add_option("--scenario", o.scenarios, "Only these scenarios: ids or globs (--metric)")
      ->expected(1)
      ->take_all();
  history->add_option("--method", o.methods, "Only these methods: ids or globs (--metric)")->expected(1)->take_all();
  history->add_option("--steps", o.steps, "Only these step counts (--metric)")->expected(1)->take_all();
  history->add_option("--out", o.out_dir, "Where the store is")->capture_default_str();
  history->add_option("-o,--output", o.outputs, "html:FILE, plots of the metric (--metric)")->expected(1)->take_all();
  auto* keep = history->add_option(
      "--prune-keep", o.prune_keep,
      "Of each study, and of each part of one, keep only the newest N judged runs and all runs after them");
  history->add_option("--prune-older", o.prune_older_days, "Remove runs that began more than DAYS ago")->excludes(keep);
  history->add_flag("--dry-run", o.dry_run, "Print how many runs would be removed (--prune-keep, --prune-older)");

  auto* merge = p.add("merge", "Join the stores of shards into one", command_merge);
  merge->add_option("STORE", o.stores, "Stores: OUT/shard-I-of-N.db, or any store.db")->required();
  merge->add_option("-o,--output", o.outputs, "The joined store, which must not exist")->required()->expected(1);

  auto* costs = p.add("costs", "What a study's cells cost, learned from the store, for `run --costs`", command_costs);
  costs->add_option("STUDY", o.study, "The study whose cells are asked for");
  p.narrowing(costs);
  costs->add_option("-o,--output", o.outputs, "The file (default: standard output)")->expected(1);
}

// About the program itself.
void declare_program(Parser& p) {
  Options& o = p.options;
  auto* doctor = p.add("doctor", "The installation: engines, versions, precisions, the machine", command_doctor);
  p.other_engines(doctor);
  doctor->add_option("--out", o.out_dir, "Where the store is")->capture_default_str();
  doctor->add_flag("--check-store", o.check_store,
                   "Compare the store's entries with their checksums; exit code 5 where it is damaged");

  auto* schema = p.add("schema", "The JSON Schema of scenario files and of rows", command_schema);
  schema->add_option("SCHEMA", o.input, "scenario (the default) or rows");

  auto* help = p.add("help", "The commands, or one command's options", [&p](const Place&, const Options& asked) {
    if (asked.manual) {
      fmt::print("{}", man_page(p.app));
      return exit_pass;
    }
    fmt::print("{}", help_text(asked.input.empty() ? p.app : command_of(p.app, asked.input), terminal_width()));
    return exit_pass;
  });
  help->add_option("COMMAND", o.input, "One command (default: all)");
  help->add_flag("--man", o.manual, "The manual page, as roff: atwood help --man | man -l -");

  auto* completion = p.add("completion", "A script that completes commands, options and ids in a shell",
                           [&p](const Place&, const Options& asked) {
                             fmt::print("{}", completion_script(p.app, asked.input));
                             return exit_pass;
                           });
  completion->add_option("SHELL", o.input, "bash, zsh or fish: source <(atwood completion bash)")->required();
}

// In the order in which `atwood --help` lists them.
void declare_commands(Parser& p) {
  declare_catalogue(p);
  declare_run(p);
  declare_single_scenes(p);
  declare_choices(p);
  declare_judgements(p);
  declare_bench(p);
  declare_stored_runs(p);
  declare_program(p);
  name_values(p.app);
  check_values(p.app);
}

// Prints what is wrong with the command line.
void complain(const CLI::App& app, const CLI::ParseError& error, const std::vector<std::string>& words) {
  std::string what = unknown_words(app, words);
  if (what.empty()) {
    const std::string command = app.get_subcommands().empty() ? "" : " " + app.get_subcommands().front()->get_name();
    const std::string plain = value_words(app, error);
    what = fmt::format("atwood{}: {}; `atwood help{}` shows the options", command, plain.empty() ? error.what() : plain,
                       command);
  }
  std::fputs(printable_lines(fmt::format("{}{}\n", what.rfind("atwood", 0) == 0 ? "" : "atwood: ", what)).c_str(),
             stderr);
}

int run(int argc, char** argv) {
  Parser parser;
  parser.app.require_subcommand(1);
  parser.app.set_version_flag("--version", fmt::format("atwood {} (protocol {})", kVersion, wire::kProtocol));
  parser.app.footer(
      "Exit codes: 0 pass; 1 a gate failed, is unverifiable or was not run, or a trace ended early (`unsupported`,\n"
      "`diverged`, `not finite`); 2 input or usage; 3 a cell crashed, hung or sent an invalid answer; 4 no baseline;\n"
      "5 input/output or internal; 130, 143 interrupted.");
  parser.app.formatter_fn(
      [](const CLI::App* app, const std::string&, CLI::AppFormatMode) { return help_text(*app, terminal_width()); });
  declare_commands(parser);
  try {
    parser.app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {
      std::ostringstream out;  // arguments may hold any character
      parser.app.exit(error, out, out);
      std::fputs(printable_lines(out.str()).c_str(), stdout);
      return exit_pass;
    }
    complain(parser.app, error, {argv + 1, argv + std::max(argc, 1)});
    return exit_input;
  }
  for (const CLI::App* sub : parser.app.get_subcommands())
    parser.options.limit_given = sub->get_option_no_throw("--limit") != nullptr && sub->count("--limit") > 0;
  // Printed commands that rerun a cell begin with the program as it was called: its own name, or that of the wrapper
  // script.
  const char* called_as = std::getenv("ATWOOD_CALLED_AS");
  parser.options.words = {called_as && *called_as ? called_as : argc > 0 ? argv[0] : "atwood"};
  for (int i = 1; i < argc; ++i) parser.options.words.emplace_back(argv[i]);
  parser.options.program = shell_line(parser.options.words);
  return parser.chosen(find_place(), parser.options);
}

// Reports that memory is exhausted, without allocating any.
int out_of_memory() {
  constexpr char words[] = "atwood: out of memory\n";
  [[maybe_unused]] const auto written = write(STDERR_FILENO, words, sizeof words - 1);
  return exit_internal;
}

// Destructors that need memory cannot report that there is none: those of nlohmann-json build a stack of what they
// destroy. The store is as after a kill.
[[noreturn]] void end_without_memory() {
  try {
    if (const std::exception_ptr thrown = std::current_exception()) std::rethrow_exception(thrown);
  } catch (const std::bad_alloc&) {
    _exit(out_of_memory());
  } catch (...) {}
  std::abort();
}

// Before the constructors of global objects, which need memory too.
[[gnu::constructor(101)]] void install_terminate_handler() { std::set_terminate(end_without_memory); }

// A message repeats what it found, which may be a file's whole content: its middle is left out.
std::string shortened(std::string text) {
  constexpr std::size_t before_title = 6000, tail = 2000;
  if (text.size() <= before_title + tail) return text;
  return text.substr(0, before_title) + " [...] " + text.substr(text.size() - tail);
}

// Uses fputs, which does not throw where standard error cannot be written.
void print_error(const char* what) {
  std::fflush(stdout);
  try {
    std::fputs(("atwood: " + printable_lines(shortened(what)) + "\n").c_str(), stderr);
  } catch (const std::bad_alloc&) {
    out_of_memory();
  }
}

}  // namespace

int main(int argc, char** argv) {
  open_standard_descriptors();
  forgive_standard_error();
  int code = exit_internal;
  try {
    code = run(argc, argv);
  } catch (const InputError& error) {
    print_error(error.what());
    return exit_input;
  } catch (const WorkerFailure& error) {
    print_error(error.what());
    return exit_cell;
  } catch (const std::bad_alloc&) {
    return out_of_memory();
  } catch (const std::filesystem::filesystem_error& error) {  // a folder whose rights were taken away meanwhile
    print_error((error.path1().string() + ": cannot be reached: " + error.code().message()).c_str());
    return exit_internal;
  } catch (const std::system_error& error) {  // fmt::print's message names no stream
    const bool printing = std::string(error.what()).rfind("cannot write to file", 0) == 0;
    print_error(printing ? ("standard output: " + error.code().message()).c_str() : error.what());
    return exit_internal;
  } catch (const std::exception& error) {
    print_error(error.what());
    return exit_internal;
  }
  if (std::fflush(stdout) != 0 || std::ferror(stdout)) {
    print_error((std::string("standard output: ") + std::strerror(errno)).c_str());
    return exit_internal;
  }
  if (interrupt_signal() != 0) return 128 + interrupt_signal();  // the signal came after the command's last check
  return code;
}
