// Baselines: written sorted, read back to the bit, regressions told from improvements.
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
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

Row row_of(const std::string& method, std::int64_t steps, const std::string& metric, double value, double bar = 0) {
  Row r;
  r.scenario = "kepler-e0.6";
  r.method = method;
  r.steps = steps;
  r.metric = metric;
  r.unit = "m";
  r.value = value;
  r.truth_bar = bar;
  r.provenance = {"1.0", "abc", "g++ 12", "-O3", "a cpu", "run 7"};
  return r;
}

std::vector<Row> rows() {
  return {row_of("ode/default", 960, "error-position-end", 0.1),
          row_of("atwood/rk4", 960, "error-position-end", 1.2345e-6, 1e-12),
          row_of("atwood/rk4", 240, "error-position-end", 5e-4), row_of("atwood/rk4", 0, "order-position", 4.05, 0.02),
          row_of("atwood/rk4", 960, "step-time", 5e-8)};
}

Kind change_of(const std::vector<Row>& now, const std::string& path, const std::string& metric, std::int64_t steps) {
  for (const BaselineChange& c : compare_baseline(path, now))
    if (c.metric == metric && c.steps == steps && c.method != "ode/default") return c.kind;
  FAIL("no change for " + metric);
  return Kind::added;
}

}  // namespace

TEST_CASE("baseline: sorted, one metric a line, no timestamps, the same bytes from the same rows in any order") {
  const Folder folder;
  write_baseline(folder.file(), rows(), "first\nfigures");
  const std::string text = content(folder.file());
  CHECK(text ==
        "# atwood baseline 1\n# reason: first figures\n# scenario\tmethod\tsteps\tmetric\tvalue\tbar\tunit\n"
        "kepler-e0.6\tatwood/rk4\t0\torder-position\t4.05\t0.02\tm\n"
        "kepler-e0.6\tatwood/rk4\t240\terror-position-end\t5e-04\t0\tm\n"
        "kepler-e0.6\tatwood/rk4\t960\terror-position-end\t1.2345e-06\t1e-12\tm\n"
        "kepler-e0.6\tatwood/rk4\t960\tstep-time\t5e-08\t0\tm\n"
        "kepler-e0.6\tode/default\t960\terror-position-end\t0.1\t0\tm\n");
  const std::string env = content(folder.file() + ".env");
  CHECK(env.find("cpu\ta cpu\n") != std::string::npos);
  CHECK(env.find("engine\tode\t1.0\n") != std::string::npos);
  std::vector<Row> reversed = rows();
  std::reverse(reversed.begin(), reversed.end());
  write_baseline(folder.file(), reversed, "first\nfigures");
  CHECK(content(folder.file()) == text);
  CHECK(std::distance(fs::directory_iterator(folder.path), fs::directory_iterator()) == 2);
  for (const BaselineChange& c : compare_baseline(folder.file(), rows())) CHECK(c.kind == Kind::unchanged);
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
  for (Row& r : elsewhere) r.provenance.cpu = "another cpu";
  CHECK(change_of(elsewhere, folder.file(), "step-time", 960) == Kind::unchanged);  // advisory
  elsewhere[1].value = 2e-6;
  CHECK(change_of(elsewhere, folder.file(), "error-position-end", 960) == Kind::regression);  // accuracy never is
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
  CHECK_THROWS_AS(compare_baseline(folder.file(), rows()), std::runtime_error);
  std::ofstream(folder.file()) << "# atwood baseline 1\nkepler\tatwood/rk4\tmany\terror\t1\t0\tm\n";
  CHECK_THROWS_AS(compare_baseline(folder.file(), rows()), InputError);
  std::ofstream(folder.file()) << "something else\n";
  CHECK_THROWS_AS(compare_baseline(folder.file(), rows()), InputError);
  CHECK_THROWS_AS(write_baseline((folder.path / "no" / "such" / "folder").string(), rows(), "figures"),
                  std::runtime_error);
}
