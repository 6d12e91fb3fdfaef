#include "validation/study/run_history.hpp"

#include <sqlite3.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <csignal>
#include <filesystem>
#include <sstream>
#include <stdexcept>
#include <tuple>

#include <SQLiteCpp/SQLiteCpp.h>

#include "validation/study/blob_bytes.hpp"
#include "validation/study/content_hash.hpp"
#include "validation/study/row_blob.hpp"

namespace atwood {

struct HistoryFile {
  std::string path;
  std::unique_ptr<SQLite::Database> sql;  // null: there is none, and it is only read
};

namespace {

constexpr int kApplication = 0x41744869;  // "AtHi", in the file's header
constexpr int kSchema = 1;
constexpr int kPatienceMs = 20000;  // for another program that writes

constexpr const char* kTables = R"(
CREATE TABLE runs(id INTEGER PRIMARY KEY AUTOINCREMENT, begun_ns INTEGER NOT NULL, ended_ns INTEGER NOT NULL,
  study TEXT NOT NULL, selection TEXT NOT NULL, cells INTEGER NOT NULL, command TEXT NOT NULL, commit_id TEXT NOT NULL,
  host TEXT NOT NULL, cpu TEXT NOT NULL, verdict TEXT NOT NULL, passed INTEGER NOT NULL, failed INTEGER NOT NULL,
  unverifiable INTEGER NOT NULL, not_run INTEGER NOT NULL, environment TEXT NOT NULL);
CREATE TABLE contents(hash TEXT PRIMARY KEY, bytes BLOB NOT NULL) WITHOUT ROWID;
CREATE TABLE figures(run INTEGER NOT NULL, scenario TEXT NOT NULL, method TEXT NOT NULL, kind TEXT NOT NULL,
  content TEXT NOT NULL, PRIMARY KEY(run, scenario, method, kind)) WITHOUT ROWID;
CREATE INDEX figures_by_name ON figures(scenario, method, run);
CREATE TABLE reports(file TEXT PRIMARY KEY, study TEXT NOT NULL, selection TEXT NOT NULL, title TEXT NOT NULL,
  verdict TEXT NOT NULL, cells INTEGER NOT NULL, written_ns INTEGER NOT NULL, shown INTEGER NOT NULL) WITHOUT ROWID;
)";
constexpr const char* kRunColumns =
    "id, begun_ns, ended_ns, study, selection, cells, command, commit_id, host, cpu, verdict, passed, failed, "
    "unverifiable, not_run";

// A file size limit (ulimit -f) raises SIGXFSZ, which ends the program; where it is ignored, SQLite fails.
class IgnoreSizeSignal {
 public:
  IgnoreSizeSignal() : before_(std::signal(SIGXFSZ, SIG_IGN)) {}
  ~IgnoreSizeSignal() { std::signal(SIGXFSZ, before_); }
  IgnoreSizeSignal(const IgnoreSizeSignal&) = delete;
  IgnoreSizeSignal& operator=(const IgnoreSizeSignal&) = delete;

 private:
  void (*before_)(int);
};

template <class Work> auto guarded(const HistoryFile& file, Work work) {
  const IgnoreSizeSignal guard;
  try {
    return work();
  } catch (const SQLite::Exception& error) {
    throw std::runtime_error(file.path + ": the history of runs: " + error.what());
  } catch (const BadBlob& error) {
    throw std::runtime_error(file.path + ": the history of runs is damaged: " + error.what());
  }
}

HistoryRun run_of(SQLite::Statement& select) {
  const auto whole = [&](int i) { return select.getColumn(i).getInt64(); };
  const auto text = [&](int i) { return select.getColumn(i).getString(); };
  HistoryRun run;
  run.id = whole(0), run.begun_ns = whole(1), run.ended_ns = whole(2);
  run.study = text(3), run.selection = text(4), run.cells = whole(5);
  run.command = text(6), run.commit = text(7), run.host = text(8), run.cpu = text(9), run.verdict = text(10);
  run.passed = whole(11), run.failed = whole(12), run.unverifiable = whole(13), run.not_run = whole(14);
  return run;
}

bool is_time(const std::string& metric) {
  return metric.starts_with("step-time") || metric.starts_with("run-time") || metric == "call-time-wasm";
}

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::size_t from = 0;
  for (std::size_t tab; (tab = line.find('\t', from)) != std::string::npos; from = tab + 1)
    cells.push_back(line.substr(from, tab - from));
  cells.push_back(line.substr(from));
  return cells;
}

template <class Number> Number number_of(const std::string& text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) throw BadBlob("`" + text + "` is no number");
  return value;
}

std::string stored_text(SQLite::Database& sql, const std::string& hash) {
  SQLite::Statement select(sql, "SELECT bytes FROM contents WHERE hash=?");
  select.bind(1, hash);
  if (!select.executeStep()) throw BadBlob("an entry is missing");
  const SQLite::Column bytes = select.getColumn(0);
  const std::string text =
      expanded({static_cast<const char*>(bytes.getBlob()), static_cast<std::size_t>(bytes.getBytes())});
  if (content_hash(text) != hash) throw BadBlob("an entry differs from its checksum");
  return text;
}

std::string store_text(SQLite::Database& sql, const std::string& text) {
  const std::string hash = content_hash(text), bytes = compressed(text);
  SQLite::Statement insert(sql, "INSERT OR IGNORE INTO contents VALUES(?, ?)");
  insert.bind(1, hash);
  insert.bind(2, bytes.data(), static_cast<int>(bytes.size()));
  insert.exec();
  return hash;
}

void append_figures(const std::string& scenario, const std::string& method, const std::string& text,
                    std::vector<HistoryFigure>& figures) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::vector<std::string> cells = cells_of(line);
    if (cells.size() != 5) throw BadBlob("a figure has not five parts");
    figures.push_back({scenario, method, cells[1], cells[4], number_of<std::int64_t>(cells[0]),
                       number_of<double>(cells[2]), number_of<double>(cells[3])});
  }
}

void store_figures(SQLite::Database& sql, std::int64_t run, const std::string& baseline) {
  SQLite::Statement insert(sql, "INSERT INTO figures VALUES(?, ?, ?, ?, ?)");
  std::string scenario, method, errors, times;
  const auto flush = [&] {
    for (const auto& [kind, text] : {std::pair("errors", &errors), std::pair("times", &times)}) {
      if (text->empty()) continue;
      insert.reset();
      insert.bind(1, run);
      insert.bind(2, scenario);
      insert.bind(3, method);
      insert.bind(4, kind);
      insert.bind(5, store_text(sql, *text));
      insert.exec();
    }
    errors.clear();
    times.clear();
  };
  std::istringstream lines(baseline);
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line[0] == '#') continue;
    const std::vector<std::string> cells = cells_of(line);
    if (cells.size() != 7) throw BadBlob("a figure of a baseline has not seven columns");
    if (cells[0] != scenario || cells[1] != method) {
      flush();
      scenario = cells[0], method = cells[1];
    }
    (is_time(cells[3]) ? times : errors) +=
        cells[2] + "\t" + cells[3] + "\t" + cells[4] + "\t" + cells[5] + "\t" + cells[6] + "\n";
  }
  flush();
}

bool is_writable(const std::string& path) {
  const std::string folder = std::filesystem::absolute(path).parent_path().string();
  return access(folder.c_str(), W_OK) == 0 && access(path.c_str(), W_OK) == 0;
}

}  // namespace

RunHistory::RunHistory(const std::string& path, Mode mode) : file_(new HistoryFile{path, nullptr}) {
  std::error_code ignored;
  if (mode == Mode::read && !std::filesystem::exists(path, ignored)) return;
  guarded(*file_, [&] {
    // What a killed program left is rolled back even by a reader, where it may write.
    const int flags = mode == Mode::write ? SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE
                      : is_writable(path) ? SQLite::OPEN_READWRITE
                                          : SQLite::OPEN_READONLY;
    auto sql = std::make_unique<SQLite::Database>(path, flags, kPatienceMs);
    if (mode == Mode::read) sql->exec("PRAGMA query_only=1");
    const auto pragma = [&](const char* text) { return sql->execAndGet(text).getInt(); };
    const auto is_new = [&] {
      return pragma("PRAGMA application_id") == 0 && pragma("SELECT count(*) FROM sqlite_master") == 0;
    };
    if (is_new()) {
      if (mode == Mode::read) return;  // a program was killed before it had made the tables
      SQLite::Transaction transaction(*sql, SQLite::TransactionBehavior::IMMEDIATE);
      if (is_new()) {  // another program may have made them meanwhile
        sql->exec(kTables);
        sql->exec("PRAGMA application_id=" + std::to_string(kApplication));
        sql->exec("PRAGMA user_version=" + std::to_string(kSchema));
      }
      transaction.commit();
    }
    if (pragma("PRAGMA application_id") != kApplication)
      throw std::runtime_error(path + ": found another kind of database; expected a history of runs");
    if (const int schema = pragma("PRAGMA user_version"); schema != kSchema)
      throw std::runtime_error(path + ": the history of runs has schema " + std::to_string(schema) +
                               "; this program reads and writes " + std::to_string(kSchema));
    file_->sql = std::move(sql);
  });
}

RunHistory::~RunHistory() = default;

std::int64_t RunHistory::begin(const HistoryRun& run) {
  return guarded(*file_, [&] {
    SQLite::Statement insert(*file_->sql,
                             "INSERT INTO runs VALUES(NULL, ?, 0, ?, ?, ?, ?, ?, ?, ?, '', 0, 0, 0, 0, '')");
    insert.bind(1, run.begun_ns);
    insert.bind(2, run.study);
    insert.bind(3, run.selection);
    insert.bind(4, run.cells);
    insert.bind(5, run.command);
    insert.bind(6, run.commit);
    insert.bind(7, run.host);
    insert.bind(8, run.cpu);
    insert.exec();
    return static_cast<std::int64_t>(file_->sql->getLastInsertRowid());
  });
}

void RunHistory::finish(const HistoryRun& run, const std::string& figures, const std::string& environment) {
  guarded(*file_, [&] {
    SQLite::Transaction transaction(*file_->sql, SQLite::TransactionBehavior::IMMEDIATE);
    store_figures(*file_->sql, run.id, figures);
    SQLite::Statement update(*file_->sql,
                             "UPDATE runs SET ended_ns=?, verdict=?, passed=?, failed=?, unverifiable=?, not_run=?, "
                             "environment=? WHERE id=?");
    update.bind(1, run.ended_ns);
    update.bind(2, run.verdict);
    update.bind(3, run.passed);
    update.bind(4, run.failed);
    update.bind(5, run.unverifiable);
    update.bind(6, run.not_run);
    update.bind(7, environment.empty() ? "" : store_text(*file_->sql, environment));
    update.bind(8, run.id);
    update.exec();
    transaction.commit();
  });
}

std::vector<HistoryRun> RunHistory::runs(const std::string& study, std::int64_t most) const {
  std::vector<HistoryRun> all;
  if (!file_->sql) return all;
  guarded(*file_, [&] {
    SQLite::Statement select(*file_->sql, std::string("SELECT ") + kRunColumns +
                                              " FROM runs WHERE ?1='' OR study=?1 ORDER BY id DESC LIMIT ?2");
    select.bind(1, study);
    select.bind(2, most);
    while (select.executeStep()) all.push_back(run_of(select));
  });
  return all;
}

std::optional<HistoryRun> RunHistory::run(std::int64_t id) const {
  std::optional<HistoryRun> found;
  if (!file_->sql) return found;
  guarded(*file_, [&] {
    SQLite::Statement select(*file_->sql, std::string("SELECT ") + kRunColumns + " FROM runs WHERE id=?");
    select.bind(1, id);
    if (select.executeStep()) found = run_of(select);
  });
  return found;
}

std::vector<HistoryFigure> RunHistory::figures(std::int64_t run) const {
  std::vector<HistoryFigure> all;
  if (!file_->sql) return all;
  guarded(*file_, [&] {
    SQLite::Statement select(*file_->sql, "SELECT scenario, method, content FROM figures WHERE run=?");
    select.bind(1, run);
    while (select.executeStep())
      append_figures(select.getColumn(0).getString(), select.getColumn(1).getString(),
                     stored_text(*file_->sql, select.getColumn(2).getString()), all);
  });
  std::sort(all.begin(), all.end(), [](const HistoryFigure& a, const HistoryFigure& b) {
    return std::tie(a.scenario, a.method, a.steps, a.metric) < std::tie(b.scenario, b.method, b.steps, b.metric);
  });
  return all;
}

std::string RunHistory::environment(std::int64_t run) const {
  if (!file_->sql) return "";
  return guarded(*file_, [&]() -> std::string {
    SQLite::Statement select(*file_->sql, "SELECT environment FROM runs WHERE id=?");
    select.bind(1, run);
    if (!select.executeStep() || select.getColumn(0).getString().empty()) return "";
    return stored_text(*file_->sql, select.getColumn(0).getString());
  });
}

std::vector<std::pair<std::string, std::string>> RunHistory::measured() const {
  std::vector<std::pair<std::string, std::string>> all;
  if (!file_->sql) return all;
  guarded(*file_, [&] {
    SQLite::Statement select(*file_->sql, "SELECT DISTINCT scenario, method FROM figures ORDER BY scenario, method");
    while (select.executeStep()) all.emplace_back(select.getColumn(0).getString(), select.getColumn(1).getString());
  });
  return all;
}

void RunHistory::each_run(const std::string& scenario, const std::string& method,
                          const std::function<void(const HistoryRun&, const std::vector<HistoryFigure>&)>& each) const {
  if (!file_->sql) return;
  guarded(*file_, [&] {
    SQLite::Statement select(*file_->sql, std::string("SELECT ") + kRunColumns +
                                              ", content FROM figures JOIN runs ON runs.id=figures.run WHERE "
                                              "scenario=? AND method=? ORDER BY run, kind");
    select.bind(1, scenario);
    select.bind(2, method);
    std::optional<HistoryRun> open;
    std::vector<HistoryFigure> figures;
    while (select.executeStep()) {
      HistoryRun run = run_of(select);
      if (open && open->id != run.id) {
        each(*open, figures);
        figures.clear();
      }
      open = std::move(run);
      append_figures(scenario, method, stored_text(*file_->sql, select.getColumn(15).getString()), figures);
    }
    if (open) each(*open, figures);
  });
}

std::vector<HistoryReport> RunHistory::reports() const {
  std::vector<HistoryReport> all;
  if (!file_->sql) return all;
  guarded(*file_, [&] {
    SQLite::Statement select(*file_->sql,
                             "SELECT file, study, selection, title, verdict, cells, written_ns, shown FROM reports "
                             "ORDER BY written_ns DESC, file");
    while (select.executeStep()) {
      const auto text = [&](int i) { return select.getColumn(i).getString(); };
      all.push_back({text(0), text(1), text(2), text(3), text(4), select.getColumn(5).getInt64(),
                     select.getColumn(6).getInt64(), select.getColumn(7).getInt() != 0});
    }
  });
  return all;
}

void RunHistory::put_report(const HistoryReport& report) {
  guarded(*file_, [&] {
    SQLite::Transaction transaction(*file_->sql, SQLite::TransactionBehavior::IMMEDIATE);
    if (report.shown) file_->sql->exec("UPDATE reports SET shown=0");
    SQLite::Statement insert(*file_->sql, "INSERT OR REPLACE INTO reports VALUES(?, ?, ?, ?, ?, ?, ?, ?)");
    insert.bind(1, report.file);
    insert.bind(2, report.study);
    insert.bind(3, report.selection);
    insert.bind(4, report.title);
    insert.bind(5, report.verdict);
    insert.bind(6, report.cells);
    insert.bind(7, report.written_ns);
    insert.bind(8, report.shown ? 1 : 0);
    insert.exec();
    transaction.commit();
  });
}

}  // namespace atwood
