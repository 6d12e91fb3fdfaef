// Baselines: sorted output, exact reading, regressions and improvements.
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include "scene/files.hpp"
#include "validation/gates/gates.hpp"

using namespace atwood;
namespace fs = std::filesystem;
using Kind = BaselineChange::Kind;

namespace {

struct Folder {
  fs::path path = fs::temp_directory_path() / ("atwood-baseline-" + std::to_string(getpid()));
  Folder() { fs::create_directories(path); }
  ~Folder() { fs::remove_all(path); }
  std::string file() const { return (path / "baseline.tsv").string(); }
};

std::string content(const std::string& path) {
  std::stringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

template <class Edit> void change(Row& row, Edit edit) {
  Provenance provenance = *row.provenance;
  edit(provenance);
  row.provenance = std::move(provenance);
}

Row row_of(const std::string& method, std::int64_t steps, const std::string& metric, double value, double bar = 0) {
  Row r;
  r.scenario = "kepler-e0.6";
  r.method = method;
  r.steps = steps;
  r.metric = metric;
  r.unit = "m";
  r.value = value;
  r.truth_bar = bar;
  r.provenance = Provenance{"1.0", "abc", "g++ 12", "-O3", "a cpu", "run 7"};
  return r;
}

std::vector<Row> rows() {
  return {row_of("ode/default", 960, "error-position-end", 0.1),
          row_of("atwood/rk4", 960, "error-position-end", 1.2345e-6, 1e-12),
          row_of("atwood/rk4", 240, "error-position-end", 5e-4), row_of("atwood/rk4", 0, "order-position", 4.05, 0.02),
          row_of("atwood/rk4", 960, "step-time", 5e-8)};
}

void write_baseline(const std::string& path, const std::vector<Row>& rows, const std::string& reason) {
  const BaselineText text = baseline_text(rows, reason);
  std::ofstream(path) << text.figures;
  std::ofstream(path + ".env") << text.environment;
}

Kind change_of(const std::vector<Row>& now, const std::string& path, const std::string& metric, std::int64_t steps) {
  for (const BaselineChange& c : compare_baseline(read_baseline(path), now))
    if (c.metric == metric && c.steps == steps && c.method != "ode/default") return c.kind;
  FAIL("no change for " + metric);
  return Kind::added;
}

}  // namespace

TEST_CASE("baseline: sorted, one metric a line, no timestamps, the same bytes from the same rows in any order") {
  const Folder folder;
  write_baseline(folder.file(), rows(), "first\nfigures");
  const std::string text = content(folder.file());
  CHECK(
      text ==
      "# atwood baseline 3\n# reason: first figures\n# definition\torder-position\t2\n# scenario\tmethod\tsteps\tmetric\tvalue\tbar\tunit\n"
      "kepler-e0.6\tatwood/rk4\t0\torder-position\t4.05\t0.02\tm\n"
      "kepler-e0.6\tatwood/rk4\t240\terror-position-end\t5e-04\t0\tm\n"
      "kepler-e0.6\tatwood/rk4\t960\terror-position-end\t1.2345e-06\t1e-12\tm\n"
      "kepler-e0.6\tatwood/rk4\t960\tstep-time\t5e-08\t0\tm\n"
      "kepler-e0.6\tode/default\t960\terror-position-end\t0.1\t0\tm\n"
      "# end 5\n");
  const std::string env = content(folder.file() + ".env");
  CHECK(env.find("cpu\ta cpu\n") != std::string::npos);
  CHECK(env.find("engine\tode\t1.0\n") != std::string::npos);
  std::vector<Row> reversed = rows();
  std::reverse(reversed.begin(), reversed.end());
  write_baseline(folder.file(), reversed, "first\nfigures");
  CHECK(content(folder.file()) == text);
  CHECK(std::distance(fs::directory_iterator(folder.path), fs::directory_iterator()) == 2);
  for (const BaselineChange& c : compare_baseline(read_baseline(folder.file()), rows()))
    CHECK(c.kind == Kind::unchanged);
  CHECK_THROWS_AS(write_baseline(folder.file(), rows(), " "), InputError);
}

TEST_CASE("baseline: worse is a regression, better an improvement, small moves neither") {
  const Folder folder;
  write_baseline(folder.file(), rows(), "figures");
  const auto with = [&](std::size_t index, double value) {
    std::vector<Row> now = rows();
    now[index].value = value;
    return now;
  };
  CHECK(change_of(with(1, 1.24e-6), folder.file(), "error-position-end", 960) == Kind::regression);
  CHECK(change_of(with(1, 1.20e-6), folder.file(), "error-position-end", 960) == Kind::improvement);
  CHECK(change_of(with(1, 1.2346e-6), folder.file(), "error-position-end", 960) == Kind::unchanged);
  CHECK(change_of(with(1, std::nan("")), folder.file(), "error-position-end", 960) == Kind::regression);
  CHECK(change_of(with(3, 3.5), folder.file(), "order-position", 0) == Kind::regression);
  CHECK(change_of(with(3, 4.06), folder.file(), "order-position", 0) == Kind::unchanged);
  CHECK(change_of(with(4, 9e-8), folder.file(), "step-time", 960) == Kind::regression);
  std::vector<Row> elsewhere = with(4, 9e-8);
  for (Row& r : elsewhere) change(r, [](Provenance& p) { p.cpu = "another cpu"; });
  CHECK(change_of(elsewhere, folder.file(), "step-time", 960) == Kind::unchanged);  // advisory
  elsewhere[1].value = 2e-6;
  CHECK(change_of(elsewhere, folder.file(), "error-position-end", 960) == Kind::regression);  // accuracy never is
}

TEST_CASE(
    "the time of a run is a time like that of a step: advisory elsewhere, and compared without a known interval") {
  const Folder folder;
  std::vector<Row> before = rows();
  before.push_back(row_of("atwood/rk4", 960, "run-time", 5e-5, std::nan("")));
  write_baseline(folder.file(), before, "figures");
  std::vector<Row> now = before;
  now.back().value = 5.2e-5;
  CHECK(change_of(now, folder.file(), "run-time", 960) == Kind::unchanged);
  now.back().value = 9e-5;
  CHECK(change_of(now, folder.file(), "run-time", 960) == Kind::regression);
  for (Row& r : now) change(r, [](Provenance& p) { p.cpu = "another cpu"; });
  CHECK(change_of(now, folder.file(), "run-time", 960) == Kind::unchanged);
}

TEST_CASE("baseline: what is missing and what is new is said; a signed figure is judged by its size") {
  const Folder folder;
  std::vector<Row> before = rows();
  before.push_back(row_of("atwood/rk4", 960, "energy-drift", -1e-9));
  write_baseline(folder.file(), before, "figures");
  std::vector<Row> now = before;
  now.erase(now.begin() + 2);
  now.back().value = 5e-9;
  now.push_back(row_of("atwood/rk4", 1920, "error-position-end", 1e-7));
  CHECK(change_of(now, folder.file(), "error-position-end", 240) == Kind::missing);
  CHECK(change_of(now, folder.file(), "error-position-end", 1920) == Kind::added);
  CHECK(change_of(now, folder.file(), "energy-drift", 960) == Kind::regression);
}

TEST_CASE("baseline: no file, and a file that is not one") {
  const Folder folder;
  CHECK_THROWS_AS(compare_baseline(read_baseline(folder.file()), rows()), std::runtime_error);
  std::ofstream(folder.file()) << "# atwood baseline 1\nkepler\tatwood/rk4\tmany\terror\t1\t0\tm\n";
  CHECK_THROWS_AS(compare_baseline(read_baseline(folder.file()), rows()), InputError);
  std::ofstream(folder.file()) << "something else\n";
  CHECK_THROWS_AS(compare_baseline(read_baseline(folder.file()), rows()), InputError);
}

TEST_CASE("baseline: a truncated file or an invalid number is refused") {
  const Folder folder;
  write_baseline(folder.file(), rows(), "figures");
  const std::string whole = content(folder.file());
  const auto with = [&](const std::string& text) {
    std::ofstream(folder.file()) << text;
    return folder.file();
  };
  for (std::size_t size = 0; size + 1 < whole.size(); ++size) {
    INFO(size);
    CHECK_THROWS_AS(read_baseline(with(whole.substr(0, size))), InputError);
  }
  CHECK(read_baseline(with(whole)).entries.size() == 5);
  CHECK(read_baseline(with(whole.substr(0, whole.size() - 1))).entries.size() == 5);  // the last line feed alone
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = whole;
    text.replace(text.find(from), from.size(), to);
    return with(text);
  };
  for (const auto& [from, to] : {std::pair{"1.2345e-06", "1zzz"},
                                 {"1.2345e-06", "inf"},
                                 {"1.2345e-06", ""},
                                 {"\t960", "\t60abc"},
                                 {"\t960", "\t-960"},
                                 {"\t960", "\t9.6e2"},
                                 {"1e-12", "inf"},
                                 {"1e-12", "nan"},
                                 {"1e-12", "-1"},
                                 {"1.2345e-06", " 1"},
                                 {"1.2345e-06", "1e999"},
                                 {"# end 5", "# end 4"},
                                 {"# end 5", "# end 5\nmore"},
                                 {"# definition\torder-position\t2", "# definition\torder-position"},
                                 {"# definition\torder-position\t2", "# definition\torder-position\t0"},
                                 {"# atwood baseline 3", "# atwood baseline 4"}}) {
    INFO(from << " -> " << to);
    CHECK_THROWS_AS(read_baseline(changed(from, to)), InputError);
  }
}

TEST_CASE("baseline: a figure by another definition is neither better nor worse, and says so") {
  const Folder folder;
  write_baseline(folder.file(), rows(), "figures");
  const std::string whole = content(folder.file()), line = "# definition\torder-position\t2\n";
  const auto change = [&](const std::string& text, double order) {
    std::ofstream(folder.file()) << text;
    std::vector<Row> now = rows();
    now[3].value = order;
    for (const BaselineChange& c : compare_baseline(read_baseline(folder.file()), now))
      if (c.metric == "order-position") return c;
    FAIL("no change");
    return BaselineChange{};
  };
  CHECK(change(whole, 4.05).kind == Kind::unchanged);
  CHECK(change(whole, 3).kind == Kind::regression);
  std::string of_version_2 = whole, without = whole;
  without.erase(without.find(line), line.size());
  of_version_2 = without;
  of_version_2.replace(0, std::string("# atwood baseline 3").size(), "# atwood baseline 2");
  for (const std::string& before : {of_version_2, without}) {
    for (const double order : {3.0, 4.05, 5.0}) {
      const BaselineChange c = change(before, order);
      CHECK(c.kind == Kind::added);
      CHECK(c.text == "definition changed: the order of the largest error over the run; it was the end's");
    }
  }
  // Others in the same file are compared.
  std::vector<Row> now = rows();
  now[2].value = 1;
  CHECK(change_of(now, folder.file(), "error-position-end", 240) == Kind::regression);
}

TEST_CASE("baseline: version 1 is read with a warning") {
  const Folder folder;
  std::ofstream(folder.file())
      << "# atwood baseline 1\nkepler-e0.6\tatwood/rk4\t960\terror-position-end\t1.2345e-06\t1e-12\tm\n";
  const Baseline old = read_baseline(folder.file());
  CHECK(old.entries.size() == 1);
  REQUIRE(old.notes.size() == 2);  // nor is there an environment beside it
  CHECK(old.notes[0].find("version 1") != std::string::npos);
}

TEST_CASE("baseline: a figure with an infinite bar agrees with every value and is left out") {
  const Folder folder;
  write_baseline(folder.file(), rows(), "figures");
  std::vector<Row> now = rows();
  now[1].value = 7;
  now[1].truth_bar = std::numeric_limits<double>::infinity();
  CHECK(change_of(now, folder.file(), "error-position-end", 960) == Kind::missing);
  CHECK(baseline_text(now, "x").figures.find("inf") == std::string::npos);
  now[1].value = std::numeric_limits<double>::infinity();
  now[1].truth_bar = 0;
  CHECK(change_of(now, folder.file(), "error-position-end", 960) == Kind::missing);
}

TEST_CASE("baseline: a change has the factor by which it is worse and the allowed value") {
  const Folder folder;
  write_baseline(folder.file(), rows(), "figures");
  std::vector<Row> now = rows();
  now[1].value = 2.469e-6;
  now[3].value = 2.025;
  for (const BaselineChange& c : compare_baseline(read_baseline(folder.file()), now)) {
    if (c.kind != Kind::regression) continue;
    CHECK(c.ratio == Approx(2));
    CHECK(c.allowed == Approx(c.metric == "order-position" ? 4.05 - 0.04 - 4.05e-3 : 1.2345e-6 * 1.001));
    CHECK(c.rerun.front() == "atwood");
  }
}

TEST_CASE("baseline: processor features and the mathematics library are kept, and said when they differ") {
  const Folder folder;
  std::vector<Row> before = rows();
  for (Row& r : before) {
    change(r, [](Provenance& p) { p.cpu_features = "avx2 fma", p.libm = "glibc 2.36"; });
  }
  write_baseline(folder.file(), before, "figures");
  CHECK(content(folder.file() + ".env").find("cpu_features\tavx2 fma\n") != std::string::npos);
  const Baseline baseline = read_baseline(folder.file());
  CHECK(baseline.notes.empty());
  CHECK(environment_changes(baseline, before).empty());
  std::vector<Row> now = before;
  for (Row& r : now) {
    change(r, [](Provenance& p) { p.cpu_features = "avx2 sse4a", p.libm = "glibc 2.31"; });
  }
  const std::vector<std::string> notes = environment_changes(baseline, now);
  REQUIRE(notes.size() == 2);
  CHECK(notes[0].find("+sse4a -fma") != std::string::npos);
  CHECK(notes[1].find("`glibc 2.31`, then `glibc 2.36`") != std::string::npos);
}

TEST_CASE("baseline: a bar that no measurement explains does not widen the tolerance") {
  const Folder folder;
  write_baseline(folder.file(), rows(), "figures");
  std::string text = content(folder.file());
  text.replace(text.find("\t1e-12\t"), 7, "\t1e300\t");
  std::ofstream(folder.file()) << text;
  std::vector<Row> now = rows();
  CHECK(change_of(now, folder.file(), "error-position-end", 960) == Kind::unchanged);
  now[1].value = 1.3e-6;
  CHECK(change_of(now, folder.file(), "error-position-end", 960) == Kind::regression);
  for (const BaselineChange& c : compare_baseline(read_baseline(folder.file()), now))
    if (c.kind == Kind::regression)
      CHECK(c.text.find("the baseline's bar of 1e+300 only 1.2345e-09 counts") != std::string::npos);
  now[1].truth_bar = 1e-8;  // today's own bar, and ten times as much of the baseline's
  CHECK(change_of(now, folder.file(), "error-position-end", 960) == Kind::unchanged);
}

TEST_CASE("baseline: a figure that was NaN and is a number now is new, not better") {
  const Folder folder;
  std::vector<Row> before = rows();
  before[1].value = std::nan("");
  write_baseline(folder.file(), before, "figures");
  CHECK(change_of(rows(), folder.file(), "error-position-end", 960) == Kind::added);
  CHECK(change_of(before, folder.file(), "error-position-end", 960) == Kind::unchanged);
}

TEST_CASE("baseline: a copy with Windows line ends is the same baseline, and a reason holds no escape bytes") {
  const Folder folder;
  write_baseline(folder.file(), rows(), "a\x1b[2Jb\x9b");
  CHECK(content(folder.file()).find_first_of("\x1b\x9b") == std::string::npos);
  for (const std::string& path : {folder.file(), folder.file() + ".env"}) {
    std::string windows;
    for (const char c : content(path)) windows += c == '\n' ? std::string("\r\n") : std::string(1, c);
    std::ofstream(path) << windows;
  }
  for (const BaselineChange& c : compare_baseline(read_baseline(folder.file()), rows()))
    CHECK(c.kind == Kind::unchanged);
  CHECK(read_baseline(folder.file()).entries.front().unit == "m");
  CHECK(environment_changes(read_baseline(folder.file()), rows()).empty());
}

TEST_CASE("baseline: each part of the environment that differs or is missing is reported") {
  const Folder folder;
  std::vector<Row> now = rows();
  for (Row& r : now) change(r, [](Provenance& p) { p.cpu_features = "avx2", p.libm = "glibc 2.36"; });
  write_baseline(folder.file(), now, "figures");
  const std::string env = content(folder.file() + ".env");
  const auto notes_with = [&](const std::string& from, const std::string& to) {
    std::string text = env;
    text.replace(text.find(from), from.size(), to);
    std::ofstream(folder.file() + ".env") << text;
    return environment_changes(read_baseline(folder.file()), now);
  };
  CHECK(notes_with("cpu\t", "cpu\t").empty());
  const std::pair<const char*, const char*> parts[] = {{"cpu\ta cpu\n", "The processor"},
                                                       {"cpu_features\tavx2\n", "The processor's features"},
                                                       {"libm\tglibc 2.36\n", "The mathematics library"},
                                                       {"compiler\tg++ 12\n", "The compiler"},
                                                       {"flags\t-O3\n", "The compiler's flags"},
                                                       {"engine\tatwood\t1.0\n", "The version of the engine atwood"},
                                                       {"engine\tode\t1.0\n", "The version of the engine ode"}};
  for (const auto& [line, words] : parts) {
    INFO(line);
    std::string other = line;
    other.insert(other.size() - 1, " x");
    for (const std::string& text : {other, std::string()}) {
      const std::vector<std::string> notes = notes_with(line, text);
      REQUIRE(notes.size() == 1);
      CHECK(notes[0].starts_with(words));
      CHECK(notes[0].find(text.empty() ? "is not in" : "differ") != std::string::npos);
    }
  }
}
