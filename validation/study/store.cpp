#include "validation/study/store.hpp"

#include <SQLiteCpp/SQLiteCpp.h>
#include <fcntl.h>
#include <sqlite3.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "validation/study/recording_blob.hpp"

namespace atwood {
namespace {

constexpr int kApplication = 0x41747764;  // "Atwd", in the file's header
constexpr int kSchema = 2;

// commit is a keyword of SQL.
constexpr const char* kTables = R"(
CREATE TABLE provenances(id INTEGER PRIMARY KEY, engine_version TEXT, commit_id TEXT, compiler TEXT, flags TEXT, cpu TEXT,
  run_id TEXT, UNIQUE(engine_version, commit_id, compiler, flags, cpu, run_id));
CREATE TABLE cells(hash TEXT PRIMARY KEY, status TEXT NOT NULL, reason TEXT NOT NULL, steps_taken INTEGER,
  rate_evaluations INTEGER, wall_ns INTEGER, limit_s REAL, killed_from_outside INTEGER, provenance INTEGER NOT NULL);
CREATE TABLE series(hash TEXT PRIMARY KEY, samples BLOB NOT NULL, events BLOB NOT NULL);
CREATE TABLE measured(key TEXT PRIMARY KEY, basis TEXT NOT NULL, errors BLOB NOT NULL);
CREATE TABLE rows(key TEXT, ordinal INTEGER, body TEXT, t_s REAL, metric TEXT, unit TEXT, value REAL, truth_bar REAL,
  status TEXT, reason TEXT, PRIMARY KEY(key, ordinal)) WITHOUT ROWID;
CREATE TABLE timings(hash TEXT PRIMARY KEY, status TEXT NOT NULL, reason TEXT NOT NULL, steps_taken INTEGER,
  rate_evaluations INTEGER, busy_ns BLOB NOT NULL, provenance INTEGER NOT NULL);
CREATE TABLE truths(hash TEXT PRIMARY KEY, status TEXT NOT NULL, reason TEXT NOT NULL, source TEXT, note TEXT,
  condition REAL, samples BLOB NOT NULL, bars BLOB NOT NULL, events BLOB NOT NULL, event_bars BLOB NOT NULL);
)";

// SQLite keeps NaN as NULL.
double real_or_nan(const SQLite::Column& column) {
  return column.isNull() ? std::numeric_limits<double>::quiet_NaN() : column.getDouble();
}

std::string blob(const SQLite::Column& column) {
  const void* bytes = column.getBlob();
  return bytes ? std::string(static_cast<const char*>(bytes), static_cast<std::size_t>(column.getBytes()))
               : std::string();
}

void bind_blob(SQLite::Statement& statement, int index, const std::string& bytes) {
  statement.bind(index, bytes.data(), static_cast<int>(bytes.size()));
}

}  // namespace

struct Store::Database {
  std::string path;
  int lock = -1;      // held as long as the database is open, and closed after it: closing any descriptor of a file
                      // drops the locks that SQLite holds on it
  bool made = false;
  std::unique_ptr<SQLite::Database> sql;
  std::mutex mutex;
  std::map<std::string, std::unique_ptr<SQLite::Statement>> statements;

  ~Database() {
    statements.clear();
    sql.reset();
    if (lock >= 0) close(lock);
  }

  [[noreturn]] void fail(const std::string& what) const { throw std::runtime_error("store " + path + ": " + what); }

  // The rollback after a failed write may have overwritten the system's word for it: then look for the cause.
  std::string why_not_written(int system, const std::string& otherwise) const {
    struct statvfs disk {};
    struct rlimit limit {};
    const bool no_space = statvfs(path.c_str(), &disk) == 0 && disk.f_bavail == 0;
    const bool limited = getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY;
    if (system == ENOSPC || system == EDQUOT || (system == 0 && no_space)) return "the disk is full";
    if (system == EFBIG || (system == 0 && limited)) return "the file size limit (ulimit -f) is reached";
    return "input/output error: " + (system != 0 ? std::string(std::strerror(system)) : otherwise);
  }

  [[noreturn]] void fail(const SQLite::Exception& error) const {
    const int system = sql ? sqlite3_system_errno(sql->getHandle()) : 0;
    const std::string kept = "; what was stored before is kept, and the same command goes on from there";
    switch (error.getErrorCode()) {
      case SQLITE_FULL: fail("the disk is full" + kept);
      case SQLITE_IOERR: fail(why_not_written(system, error.what()) + kept);
      case SQLITE_READONLY:
      case SQLITE_PERM: fail("cannot be written: it or its folder is read-only");
      case SQLITE_CANTOPEN:
        fail(std::string("cannot be opened: ") + (system != 0 ? std::strerror(system) : error.what()));
      case SQLITE_CORRUPT:
        fail(std::string("is damaged (") + error.what() + "); move it away, and the next run starts afresh");
      case SQLITE_NOTADB:
        fail("is not a store: it is no SQLite database; move it away or choose another output folder");
      case SQLITE_BUSY:
      case SQLITE_LOCKED: fail("is in use by another program");
      case SQLITE_NOMEM: fail("out of memory");
      default: fail(error.what());
    }
  }

  // `work` under the lock, its failures in words.
  template <class Work>
  auto guarded(Work work) {
    const std::lock_guard<std::mutex> held(mutex);
    // A statement stepped halfway holds its snapshot, and the log could not shrink.
    struct Resetter {
      Database& database;
      ~Resetter() {
        for (auto& [text, statement] : database.statements) statement->tryReset();
      }
    } resetter{*this};
    try {
      return work();
    } catch (const SQLite::Exception& error) {
      fail(error);
    } catch (const BadBlob& error) {
      fail(std::string("is damaged (") + error.what() + "); move it away, and the next run starts afresh");
    } catch (const std::invalid_argument& error) {
      fail(std::string("is damaged (") + error.what() + "); move it away, and the next run starts afresh");
    }
  }

  // A prepared statement, ready to bind.
  SQLite::Statement& prepared(const char* text) {
    auto& statement = statements[text];
    if (!statement) statement = std::make_unique<SQLite::Statement>(*sql, text);
    statement->reset();
    statement->clearBindings();
    return *statement;
  }

  void take_lock() {
    made = access(path.c_str(), F_OK) != 0;
    lock = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (lock < 0) fail(std::string("cannot be written: ") + std::strerror(errno));
    if (flock(lock, LOCK_EX | LOCK_NB) != 0) {
      if (errno == EWOULDBLOCK) fail("is in use by another run; wait for it, or choose another output folder");
      fail(std::string("cannot be locked: ") + std::strerror(errno));
    }
  }

  void open_for_writing() {
    take_lock();
    sql = std::make_unique<SQLite::Database>(path, SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE, 10000);
    check_identity();
    // WAL and NORMAL: a killed program loses nothing that was committed, a power cut at most the last cells.
    sql->exec("PRAGMA journal_mode=WAL");
    sql->exec("PRAGMA synchronous=NORMAL");
    if (version() == kSchema) return;
    SQLite::Transaction transaction(*sql);
    sql->exec(kTables);
    sql->exec("PRAGMA application_id=" + std::to_string(kApplication));
    sql->exec("PRAGMA user_version=" + std::to_string(kSchema));
    transaction.commit();
  }

  // SQLite makes files beside a log-keeping database even to read it. Where it may not, and no log is left, the
  // database cannot change either: it is read as it lies.
  void open_for_reading() {
    const std::size_t slash = path.rfind('/');
    const std::string folder = slash == std::string::npos ? "." : path.substr(0, slash + 1);
    if (access(folder.c_str(), W_OK) == 0 && access(path.c_str(), W_OK) == 0) {
      sql = std::make_unique<SQLite::Database>(path, SQLite::OPEN_READWRITE, 10000);
    } else if (access((path + "-wal").c_str(), F_OK) == 0) {
      sql = std::make_unique<SQLite::Database>(path, SQLite::OPEN_READONLY, 10000);
    } else {
      std::string address = "file:";
      for (const char c : path) {  // RFC 3986: what would end the path
        if (c == '%' || c == '?' || c == '#') {
          char escaped[4];
          std::snprintf(escaped, sizeof escaped, "%%%02X", static_cast<unsigned>(static_cast<unsigned char>(c)));
          address += escaped;
        } else {
          address += c;
        }
      }
      sql = std::make_unique<SQLite::Database>(address + "?immutable=1", SQLite::OPEN_READONLY | SQLite::OPEN_URI);
    }
  }

  int version() { return sql->execAndGet("PRAGMA user_version").getInt(); }

  void check_identity() {
    const int application = sql->execAndGet("PRAGMA application_id").getInt();
    const int tables = sql->execAndGet("SELECT count(*) FROM sqlite_master").getInt();
    if (tables == 0 && application == 0) return;
    if (application != kApplication) fail("is an SQLite database of another program; choose another output folder");
    if (version() != kSchema) {
      fail("has schema " + std::to_string(version()) + "; this program reads schema " + std::to_string(kSchema) +
           "; move it away, and the next run starts afresh");
    }
  }

  void remove_what_was_made() {
    statements.clear();
    sql.reset();
    if (!made) return;
    for (const char* suffix : {"", "-wal", "-shm", "-journal"}) unlink((path + suffix).c_str());
  }

  std::int64_t provenance_id(const Provenance& p) {
    const auto bind = [&](SQLite::Statement& statement) {
      int i = 0;
      for (const auto* text : {&p.engine_version, &p.commit, &p.compiler, &p.flags, &p.cpu, &p.run_id}) {
        statement.bind(++i, *text);
      }
    };
    auto& insert = prepared(
        "INSERT OR IGNORE INTO provenances(engine_version, commit_id, compiler, flags, cpu, run_id) "
        "VALUES(?,?,?,?,?,?)");
    bind(insert);
    insert.exec();
    auto& select = prepared(
        "SELECT id FROM provenances WHERE engine_version=? AND commit_id=? AND compiler=? AND flags=? AND cpu=? AND "
        "run_id=?");
    bind(select);
    select.executeStep();
    return select.getColumn(0).getInt64();
  }

  Provenance provenance(std::int64_t id) {
    auto& select =
        prepared("SELECT engine_version, commit_id, compiler, flags, cpu, run_id FROM provenances WHERE id=?");
    select.bind(1, id);
    if (!select.executeStep()) return {};
    const auto text = [&](int i) { return select.getColumn(i).getString(); };
    return {text(0), text(1), text(2), text(3), text(4), text(5)};
  }

  void insert_measured(const std::string& key, const MeasuredRecord& record) {
    auto& clear = prepared("DELETE FROM rows WHERE key=?");
    clear.bind(1, key);
    clear.exec();
    auto& head = prepared("INSERT OR REPLACE INTO measured VALUES(?,?,?)");
    head.bind(1, key);
    head.bind(2, record.basis);
    bind_blob(head, 3, pack_series(record.series));
    head.exec();
    int ordinal = 0;
    for (const Row& row : record.rows) {
      auto& insert = prepared("INSERT INTO rows VALUES(?,?,?,?,?,?,?,?,?,?)");
      insert.bind(1, key);
      insert.bind(2, ordinal++);
      insert.bind(3, row.body);
      if (row.t_s) insert.bind(4, *row.t_s);
      insert.bind(5, row.metric);
      insert.bind(6, row.unit);
      insert.bind(7, row.value);
      insert.bind(8, row.truth_bar);
      insert.bind(9, to_string(row.status));
      insert.bind(10, row.reason);
      insert.exec();
    }
  }

  std::vector<Row> select_rows(const std::string& key) {
    auto& select = prepared(
        "SELECT body, t_s, metric, unit, value, truth_bar, status, reason FROM rows WHERE key=? ORDER BY ordinal");
    select.bind(1, key);
    std::vector<Row> rows;
    while (select.executeStep()) {
      Row& row = rows.emplace_back();
      row.body = select.getColumn(0).getString();
      if (!select.getColumn(1).isNull()) row.t_s = select.getColumn(1).getDouble();
      row.metric = select.getColumn(2).getString();
      row.unit = select.getColumn(3).getString();
      row.value = real_or_nan(select.getColumn(4));
      row.truth_bar = real_or_nan(select.getColumn(5));
      row.status = status_from_string(select.getColumn(6).getString());
      row.reason = select.getColumn(7).getString();
    }
    return rows;
  }

  bool exists(const char* query, const std::string& key) {
    auto& select = prepared(query);
    select.bind(1, key);
    return select.executeStep();
  }
};

Store::Store(const std::string& path, Mode mode) : database_(std::make_unique<Database>()) {
  database_->path = path;
  try {
    if (mode == Mode::write) {
      database_->open_for_writing();
    } else {
      database_->open_for_reading();
      database_->check_identity();
    }
  } catch (const SQLite::Exception& error) {
    try {
      database_->fail(error);
    } catch (const std::runtime_error&) {
      database_->remove_what_was_made();
      throw;
    }
  }
}

Store::~Store() = default;

std::optional<RunRecord> Store::run(const std::string& cell_hash) {
  return database_->guarded([&]() -> std::optional<RunRecord> {
    auto& select = database_->prepared(
        "SELECT status, reason, steps_taken, rate_evaluations, wall_ns, limit_s, killed_from_outside, provenance FROM "
        "cells "
        "WHERE hash=?");
    select.bind(1, cell_hash);
    if (!select.executeStep()) return std::nullopt;
    RunRecord record;
    record.outcome.status = status_from_string(select.getColumn(0).getString());
    record.outcome.reason = select.getColumn(1).getString();
    record.outcome.steps_taken = select.getColumn(2).getInt64();
    record.outcome.rate_evaluations = select.getColumn(3).getInt64();
    record.wall_ns = select.getColumn(4).getInt64();
    record.limit_s = select.getColumn(5).getDouble();
    record.killed_from_outside = select.getColumn(6).getInt() != 0;
    record.provenance = database_->provenance(select.getColumn(7).getInt64());
    return record;
  });
}

Recording Store::recording(const std::string& cell_hash, const Outcome& outcome) {
  return database_->guarded([&] {
    Recording recording;
    recording.outcome = outcome;
    auto& select = database_->prepared("SELECT samples, events FROM series WHERE hash=?");
    select.bind(1, cell_hash);
    if (select.executeStep()) {
      recording.values = unpack_samples(blob(select.getColumn(0)));
      recording.events = unpack_events(blob(select.getColumn(1)));
    }
    return recording;
  });
}

std::string Store::measured_basis(const std::string& key) {
  return database_->guarded([&]() -> std::string {
    auto& select = database_->prepared("SELECT basis FROM measured WHERE key=?");
    select.bind(1, key);
    return select.executeStep() ? select.getColumn(0).getString() : "";
  });
}

std::optional<MeasuredRecord> Store::measured(const std::string& key, bool rows, bool series) {
  return database_->guarded([&]() -> std::optional<MeasuredRecord> {
    auto& select = database_->prepared("SELECT basis, errors FROM measured WHERE key=?");
    select.bind(1, key);
    if (!select.executeStep()) return std::nullopt;
    MeasuredRecord record;
    record.basis = select.getColumn(0).getString();
    if (series) record.series = unpack_series(blob(select.getColumn(1)));
    if (rows) record.rows = database_->select_rows(key);
    return record;
  });
}

std::optional<TimingRecord> Store::timing(const std::string& timing_hash) {
  return database_->guarded([&]() -> std::optional<TimingRecord> {
    auto& select = database_->prepared(
        "SELECT status, reason, steps_taken, rate_evaluations, busy_ns, provenance FROM timings WHERE hash=?");
    select.bind(1, timing_hash);
    if (!select.executeStep()) return std::nullopt;
    TimingRecord record;
    record.outcome.status = status_from_string(select.getColumn(0).getString());
    record.outcome.reason = select.getColumn(1).getString();
    record.outcome.steps_taken = select.getColumn(2).getInt64();
    record.outcome.rate_evaluations = select.getColumn(3).getInt64();
    for (const double ns : unpack_reals(blob(select.getColumn(4)))) {
      record.outcome.busy_ns.push_back(static_cast<std::int64_t>(ns));
    }
    record.provenance = database_->provenance(select.getColumn(5).getInt64());
    return record;
  });
}

bool Store::has_truth(const std::string& truth_hash) {
  return database_->guarded([&] { return database_->exists("SELECT 1 FROM truths WHERE hash=?", truth_hash); });
}

std::optional<Truth> Store::truth(const std::string& truth_hash) {
  return database_->guarded([&]() -> std::optional<Truth> {
    auto& select = database_->prepared(
        "SELECT status, reason, source, note, condition, samples, bars, events, event_bars FROM truths WHERE hash=?");
    select.bind(1, truth_hash);
    if (!select.executeStep()) return std::nullopt;
    Truth truth;
    truth.outcome.status = status_from_string(select.getColumn(0).getString());
    truth.outcome.reason = select.getColumn(1).getString();
    truth.source = select.getColumn(2).getString();
    truth.note = select.getColumn(3).getString();
    truth.condition = real_or_nan(select.getColumn(4));
    truth.values = unpack_samples(blob(select.getColumn(5)));
    truth.bars = unpack_samples(blob(select.getColumn(6)));
    truth.events = unpack_events(blob(select.getColumn(7)));
    truth.event_bar_s = unpack_reals(blob(select.getColumn(8)));
    return truth;
  });
}

void Store::put_run(const std::string& cell_hash, const RunRecord& run, const Recording& recording,
                    const std::string& key, const MeasuredRecord& measured) {
  database_->guarded([&] {
    SQLite::Transaction transaction(*database_->sql);
    const std::int64_t provenance = database_->provenance_id(run.provenance);
    auto& cell = database_->prepared("INSERT OR REPLACE INTO cells VALUES(?,?,?,?,?,?,?,?,?)");
    cell.bind(1, cell_hash);
    cell.bind(2, to_string(run.outcome.status));
    cell.bind(3, run.outcome.reason);
    cell.bind(4, run.outcome.steps_taken);
    cell.bind(5, run.outcome.rate_evaluations);
    cell.bind(6, run.wall_ns);
    cell.bind(7, run.limit_s);
    cell.bind(8, run.killed_from_outside ? 1 : 0);
    cell.bind(9, provenance);
    cell.exec();
    auto& series = database_->prepared("INSERT OR REPLACE INTO series VALUES(?,?,?)");
    series.bind(1, cell_hash);
    bind_blob(series, 2, pack_samples(recording.values));
    bind_blob(series, 3, pack_events(recording.events));
    series.exec();
    database_->insert_measured(key, measured);
    transaction.commit();
  });
}

void Store::put_measured(const std::string& key, const MeasuredRecord& measured) {
  database_->guarded([&] {
    SQLite::Transaction transaction(*database_->sql);
    database_->insert_measured(key, measured);
    transaction.commit();
  });
}

void Store::put_timing(const std::string& timing_hash, const TimingRecord& timing) {
  database_->guarded([&] {
    SQLite::Transaction transaction(*database_->sql);
    const std::int64_t provenance = database_->provenance_id(timing.provenance);
    auto& insert = database_->prepared("INSERT OR REPLACE INTO timings VALUES(?,?,?,?,?,?,?)");
    insert.bind(1, timing_hash);
    insert.bind(2, to_string(timing.outcome.status));
    insert.bind(3, timing.outcome.reason);
    insert.bind(4, timing.outcome.steps_taken);
    insert.bind(5, timing.outcome.rate_evaluations);
    bind_blob(insert, 6, pack_reals({timing.outcome.busy_ns.begin(), timing.outcome.busy_ns.end()}));
    insert.bind(7, provenance);
    insert.exec();
    transaction.commit();
  });
}

void Store::put_truth(const std::string& truth_hash, const Truth& truth) {
  database_->guarded([&] {
    SQLite::Transaction transaction(*database_->sql);
    auto& insert = database_->prepared("INSERT OR REPLACE INTO truths VALUES(?,?,?,?,?,?,?,?,?,?)");
    insert.bind(1, truth_hash);
    insert.bind(2, to_string(truth.outcome.status));
    insert.bind(3, truth.outcome.reason);
    insert.bind(4, truth.source);
    insert.bind(5, truth.note);
    insert.bind(6, truth.condition);
    bind_blob(insert, 7, pack_samples(truth.values));
    bind_blob(insert, 8, pack_samples(truth.bars));
    bind_blob(insert, 9, pack_events(truth.events));
    bind_blob(insert, 10, pack_reals(truth.event_bar_s));
    insert.exec();
    transaction.commit();
  });
}

bool store_exists(const std::string& path) { return access(path.c_str(), F_OK) == 0; }

}  // namespace atwood
