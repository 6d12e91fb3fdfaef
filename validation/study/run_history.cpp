#include "validation/study/run_history.hpp"

#include <sqlite3.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <map>
#include <sstream>
#include <stdexcept>
#include <tuple>

#include <SQLiteCpp/SQLiteCpp.h>
#include <SQLiteCpp/VariadicBind.h>

#include "validation/gates/times.hpp"
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

// Calls `each` with every row of the answer; a file that is not there has none.
template <class Each, class... Values>
void query(const HistoryFile& file, const std::string& text, Each each, const Values&... values) {
  if (!file.sql) return;
  guarded(file, [&] {
    SQLite::Statement select(*file.sql, text);
    SQLite::bind(select, values...);
    while (select.executeStep()) each(select);
  });
}

// How many rows it changed.
template <class... Values> int execute(SQLite::Database& sql, const std::string& text, const Values&... values) {
  SQLite::Statement statement(sql, text);
  SQLite::bind(statement, values...);
  return statement.exec();
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
  if (error != std::errc() || end != text.data() + text.size()) throw BadBlob("`" + text + "` is not a number");
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
    if (cells.size() != 5 && cells.size() != 6) throw BadBlob("a figure has neither five nor six parts");
    figures.push_back({scenario, method, cells[1], cells[4], number_of<std::int64_t>(cells[0]),
                       number_of<double>(cells[2]), number_of<double>(cells[3]),
                       cells.size() == 6 ? number_of<int>(cells[5]) : 1});
  }
}

// `times`: the kind under which times are stored.
void store_figures(SQLite::Database& sql, std::int64_t run, const std::string& baseline, const char* times) {
  std::string scenario, method;
  std::map<std::string, std::string> texts;  // by kind
  const auto flush = [&] {
    for (const auto& [kind, text] : texts)
      execute(sql, "INSERT INTO figures VALUES(?, ?, ?, ?, ?)", run, scenario, method, kind, store_text(sql, text));
    texts.clear();
  };
  std::map<std::string, std::string> definitions;  // by metric, those that are not the first
  std::istringstream lines(baseline);
  for (std::string line; std::getline(lines, line);) {
    const std::vector<std::string> cells = cells_of(line);
    if (cells.size() == 3 && cells[0] == "# definition") definitions[cells[1]] = "\t" + cells[2];
    if (line.empty() || line[0] == '#') continue;
    if (cells.size() != 7) throw BadBlob("a figure of a baseline has not seven columns");
    if (cells[0] != scenario || cells[1] != method) {
      flush();
      scenario = cells[0], method = cells[1];
    }
    texts[is_time(cells[3]) ? times : "errors"] += cells[2] + "\t" + cells[3] + "\t" + cells[4] + "\t" + cells[5] +
                                                   "\t" + cells[6] +
                                                   definitions[cells[3].substr(0, cells[3].find('['))] + "\n";
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
    execute(*file_->sql, "INSERT INTO runs VALUES(NULL, ?, 0, ?, ?, ?, ?, ?, ?, ?, '', 0, 0, 0, 0, '')", run.begun_ns,
            run.study, run.selection, run.cells, run.command, run.commit, run.host, run.cpu);
    return static_cast<std::int64_t>(file_->sql->getLastInsertRowid());
  });
}

void RunHistory::finish(const HistoryRun& run, const std::string& figures, const std::string& old_times,
                        const std::string& environment) {
  guarded(*file_, [&] {
    SQLite::Database& sql = *file_->sql;
    SQLite::Transaction transaction(sql, SQLite::TransactionBehavior::IMMEDIATE);
    if (execute(sql,
                "UPDATE runs SET ended_ns=?, selection=?, verdict=?, passed=?, failed=?, unverifiable=?, not_run=?, "
                "environment=? WHERE id=?",
                run.ended_ns, run.selection, run.verdict, run.passed, run.failed, run.unverifiable, run.not_run,
                environment.empty() ? std::string() : store_text(sql, environment), run.id) != 1)
      throw std::runtime_error(file_->path + ": run " + std::to_string(run.id) + " was removed from the history");
    store_figures(sql, run.id, figures, "times");
    store_figures(sql, run.id, old_times, "times, older");
    transaction.commit();
  });
}

std::int64_t RunHistory::prune(const std::string& study, std::int64_t keep, std::int64_t before_ns, bool dry) {
  // A run that goes on is not removed: it would end without an entry. After a day it counts as killed.
  constexpr const char* where_removed =
      " FROM runs WHERE (?1='' OR study=?1) AND (ended_ns>0 OR begun_ns<?2) AND ((?3>0 AND ?3<=(SELECT count(*) FROM "
      "runs AS later WHERE later.study=runs.study AND later.selection=runs.selection AND later.id>runs.id AND "
      "later.verdict IN ('pass', 'fail', 'no gates'))) OR begun_ns<?4)";
  return guarded(*file_, [&] {
    if (!file_->sql) return std::int64_t{0};
    SQLite::Database& sql = *file_->sql;
    SQLite::Transaction transaction(sql, SQLite::TransactionBehavior::IMMEDIATE);
    using namespace std::chrono;
    const std::int64_t a_day_ago = nanoseconds(system_clock::now().time_since_epoch() - hours(24)).count();
    std::vector<std::int64_t> removed;
    SQLite::Statement select(sql, std::string("SELECT id") + where_removed);
    SQLite::bind(select, study, a_day_ago, keep, before_ns);
    while (select.executeStep()) removed.push_back(select.getColumn(0).getInt64());
    if (dry) return static_cast<std::int64_t>(removed.size());
    for (const std::int64_t run : removed) {
      execute(sql, "DELETE FROM figures WHERE run=?", run);
      execute(sql, "DELETE FROM runs WHERE id=?", run);
    }
    execute(sql,
            "DELETE FROM contents WHERE hash NOT IN (SELECT content FROM figures) AND hash NOT IN (SELECT environment "
            "FROM runs)");
    transaction.commit();
    if (!removed.empty()) sql.exec("VACUUM");
    return static_cast<std::int64_t>(removed.size());
  });
}

std::vector<HistoryRun> RunHistory::runs(const std::string& study, std::int64_t most) const {
  std::vector<HistoryRun> all;
  query(
      *file_, std::string("SELECT ") + kRunColumns + " FROM runs WHERE ?1='' OR study=?1 ORDER BY id DESC LIMIT ?2",
      [&](SQLite::Statement& row) { all.push_back(run_of(row)); }, study, most);
  return all;
}

std::optional<HistoryRun> RunHistory::run(std::int64_t id) const {
  std::optional<HistoryRun> found;
  query(
      *file_, std::string("SELECT ") + kRunColumns + " FROM runs WHERE id=?",
      [&](SQLite::Statement& row) { found = run_of(row); }, id);
  return found;
}

std::vector<HistoryFigure> RunHistory::figures(std::int64_t run) const {
  std::vector<HistoryFigure> all;
  query(
      *file_, "SELECT scenario, method, content FROM figures WHERE run=?",
      [&](SQLite::Statement& row) {
        append_figures(row.getColumn(0).getString(), row.getColumn(1).getString(),
                       stored_text(*file_->sql, row.getColumn(2).getString()), all);
      },
      run);
  std::sort(all.begin(), all.end(), [](const HistoryFigure& a, const HistoryFigure& b) {
    return std::tie(a.scenario, a.method, a.steps, a.metric) < std::tie(b.scenario, b.method, b.steps, b.metric);
  });
  return all;
}

std::string RunHistory::environment(std::int64_t run) const {
  std::string text;
  query(
      *file_, "SELECT environment FROM runs WHERE id=? AND environment<>''",
      [&](SQLite::Statement& row) { text = stored_text(*file_->sql, row.getColumn(0).getString()); }, run);
  return text;
}

std::vector<std::pair<std::string, std::string>> RunHistory::measured() const {
  std::vector<std::pair<std::string, std::string>> all;
  query(*file_, "SELECT DISTINCT scenario, method FROM figures ORDER BY scenario, method",
        [&](SQLite::Statement& row) { all.emplace_back(row.getColumn(0).getString(), row.getColumn(1).getString()); });
  return all;
}

void RunHistory::each_run(const std::string& scenario, const std::string& method, std::int64_t from,
                          const std::function<void(const HistoryRun&, const std::vector<HistoryFigure>&)>& each) const {
  std::optional<HistoryRun> open;
  std::vector<HistoryFigure> figures;
  query(
      *file_,
      std::string("SELECT ") + kRunColumns +
          ", content FROM figures JOIN runs ON runs.id=figures.run WHERE scenario=? AND method=? AND run>=? AND kind IN "
          "('errors', 'times') ORDER BY run, kind",
      [&](SQLite::Statement& row) {
        HistoryRun run = run_of(row);
        if (open && open->id != run.id) {
          each(*open, figures);
          figures.clear();
        }
        open = std::move(run);
        append_figures(scenario, method, stored_text(*file_->sql, row.getColumn(15).getString()), figures);
      },
      scenario, method, from);
  if (open) each(*open, figures);
}

std::vector<HistoryReport> RunHistory::reports() const {
  std::vector<HistoryReport> all;
  query(*file_,
        "SELECT file, study, selection, title, verdict, cells, written_ns, shown FROM reports ORDER BY written_ns "
        "DESC, file",
        [&](SQLite::Statement& row) {
          const auto text = [&](int i) { return row.getColumn(i).getString(); };
          all.push_back({text(0), text(1), text(2), text(3), text(4), row.getColumn(5).getInt64(),
                         row.getColumn(6).getInt64(), row.getColumn(7).getInt() != 0});
        });
  return all;
}

void RunHistory::put_report(const HistoryReport& report) {
  guarded(*file_, [&] {
    SQLite::Database& sql = *file_->sql;
    SQLite::Transaction transaction(sql, SQLite::TransactionBehavior::IMMEDIATE);
    if (report.shown) sql.exec("UPDATE reports SET shown=0");
    execute(sql, "INSERT OR REPLACE INTO reports VALUES(?, ?, ?, ?, ?, ?, ?, ?)", report.file, report.study,
            report.selection, report.title, report.verdict, report.cells, report.written_ns, report.shown ? 1 : 0);
    transaction.commit();
  });
}

}  // namespace atwood
