// The store's file: opening, locking, reading and writing with checksums, and the messages of its failures.
#include "validation/study/store_database.hpp"

#include <fcntl.h>
#include <sqlite3.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/vfs.h>
#include <unistd.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <set>
#include <stdexcept>

#include "validation/study/content_hash.hpp"
#include "validation/study/process.hpp"

namespace atwood {

// `guarded` lets one thread at a time use a connection; SQLite's own locks would be taken a dozen times an entry.
constexpr int kOwnLock = SQLITE_OPEN_NOMUTEX;

// ---- checksums ----------------------------------------------------------------------------------------------------
struct ValueChecksum::State {
  alignas(64) XXH3_state_t hash;
};

// A short text is hashed several times quicker at once than in parts; the hash is the same.
constexpr std::size_t kHashedAtOnce = 16'384;

ValueChecksum::ValueChecksum() = default;
ValueChecksum::~ValueChecksum() = default;

void ValueChecksum::restart() {
  few_.clear();
  state_.reset();
}

void ValueChecksum::add(char kind, std::string_view bytes) {
  char head[9] = {kind};
  const std::uint64_t size = bytes.size();
  std::memcpy(head + 1, &size, sizeof size);
  if (!state_ && few_.size() + sizeof head + size <= kHashedAtOnce) {
    few_.append(head, sizeof head).append(bytes);
    return;
  }
  if (!state_) {
    state_ = std::make_unique<State>();
    XXH3_64bits_reset(&state_->hash);
    XXH3_64bits_update(&state_->hash, few_.data(), few_.size());
  }
  XXH3_64bits_update(&state_->hash, head, sizeof head);
  if (size > 0) XXH3_64bits_update(&state_->hash, bytes.data(), bytes.size());
}

void ValueChecksum::add_real(double value) {
  if (value != value) return add('0', {});
  if (value == 0) value = 0;  // SQLite does not store the sign of zero
  add('r', {reinterpret_cast<const char*>(&value), sizeof value});
}

void ValueChecksum::add(const StoreValue& value) {
  if (const auto* whole = std::get_if<std::int64_t>(&value)) {
    add('i', {reinterpret_cast<const char*>(whole), sizeof *whole});
  } else if (const auto* real = std::get_if<double>(&value)) {
    add_real(*real);
  } else if (const auto* text = std::get_if<std::string>(&value)) {
    add('t', *text);
  } else if (const auto* blob = std::get_if<Blob>(&value)) {
    add('b', blob->bytes);
  } else {
    add('0', {});
  }
}

void ValueChecksum::add(const SQLite::Column& column) {
  switch (column.getType()) {
    case SQLITE_INTEGER: return add(StoreValue(std::int64_t{column.getInt64()}));
    case SQLITE_FLOAT: return add_real(column.getDouble());
    case SQLITE_TEXT:
    case SQLITE_BLOB: {
      const void* bytes = column.getBlob();  // called first: it may convert the value to bytes
      return add(column.getType() == SQLITE_TEXT ? 't' : 'b',
                 {static_cast<const char*>(bytes), bytes ? static_cast<std::size_t>(column.getBytes()) : 0});
    }
    default: return add('0', {});
  }
}

std::int64_t ValueChecksum::value() const {
  return static_cast<std::int64_t>(state_ ? XXH3_64bits_digest(&state_->hash) : checksum(few_));
}

// SQLite stores NaN as NULL.
double real_or_nan(const SQLite::Column& column) {
  return column.isNull() ? std::numeric_limits<double>::quiet_NaN() : column.getDouble();
}

std::string blob_of(const SQLite::Column& column) {
  const void* bytes = column.getBlob();
  return bytes ? std::string(static_cast<const char*>(bytes), static_cast<std::size_t>(column.getBytes()))
               : std::string();
}

// ---- failures -----------------------------------------------------------------------------------------------------
StoreDatabase::~StoreDatabase() {
  forget_statements();
  sql.reset();
  if (lock >= 0) close(lock);
}

std::uint64_t StoreDatabase::bytes() {
  const auto pages = sql->execAndGet("PRAGMA page_count").getInt64(),
             page = sql->execAndGet("PRAGMA page_size").getInt64();
  return static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page);
}

void StoreDatabase::fail(const std::string& what) const { throw std::runtime_error("store " + path + ": " + what); }

void StoreDatabase::damaged(const std::string& what) const {
  fail("is damaged (" + what + "); move it away, and the next run starts afresh");
}

// The cause of a failed write. The rollback may have overwritten the system's error code; then the disk is examined.
std::string StoreDatabase::why_not_written(int system, const std::string& otherwise) const {
  struct statvfs disk {};
  struct rlimit limit {};
  const bool no_space = statvfs(path.c_str(), &disk) == 0 && disk.f_bavail == 0;
  const bool limited = getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY;
  if (system == ENOSPC || system == EDQUOT || (system == 0 && no_space)) return "the disk is full";
  if (system == EFBIG || (system == 0 && limited)) return "the file size limit (ulimit -f) is reached";
  return "input/output error: " + (system != 0 ? std::string(std::strerror(system)) : otherwise);
}

void StoreDatabase::fail(const SQLite::Exception& error) const {
  const int system = sql ? sqlite3_system_errno(sql->getHandle()) : 0;
  const std::string kept = "; what was stored before is kept, and the same command goes on from there";
  const std::string what = printable(error.what());  // it may repeat bytes of a damaged file
  switch (error.getErrorCode()) {
    case SQLITE_FULL: fail("the disk is full" + kept);
    case SQLITE_IOERR: fail(why_not_written(system, what) + kept);
    case SQLITE_READONLY:
    case SQLITE_PERM: fail("cannot be written: it or its folder is read-only");
    case SQLITE_CANTOPEN: fail("cannot be opened: " + (system != 0 ? std::string(std::strerror(system)) : what));
    case SQLITE_CORRUPT: damaged("the database's own structure cannot be read");
    case SQLITE_NOTADB: fail("is not a store (no SQLite database); move it away or choose another output folder");
    case SQLITE_BUSY:
    case SQLITE_LOCKED: fail("is in use by another program");
    case SQLITE_NOMEM: fail("out of memory");
    case SQLITE_TOOBIG: fail("a recording is larger than the store can keep (1 GB)" + kept);
    case SQLITE_ERROR:  // statements are correct, so the tables are not those of the schema
    case SQLITE_SCHEMA:
    case SQLITE_CONSTRAINT:
    case SQLITE_MISMATCH: damaged("its tables do not match the schema");
    default: fail(what);
  }
}

// ---- network file systems -----------------------------------------------------------------------------------------
std::string network_file_system_of(const std::string& path) {
  if (const char* forced = std::getenv("ATWOOD_STORE_JOURNAL"); forced && std::string_view(forced) == "rollback")
    return "a file system named by ATWOOD_STORE_JOURNAL";
  struct statfs about {};
  const std::size_t slash = path.rfind('/');
  const std::string folder = slash == std::string::npos ? "." : path.substr(0, slash + 1);
  if (statfs(folder.c_str(), &about) != 0) return "";
  return network_file_system_name(static_cast<std::uint32_t>(about.f_type));
}

std::string network_file_system_name(std::uint32_t magic) {
  switch (magic) {  // statfs(2), linux/magic.h, and the file systems' own sources
    case 0x6969: return "NFS";
    case 0x517B: return "SMB";
    case 0xFF534D42: return "CIFS";
    case 0xFE534D42: return "SMB2";
    case 0x5346414F: return "AFS";
    case 0x73757245: return "Coda";
    case 0x00C36400: return "Ceph";
    case 0x0BD00BD0: return "Lustre";
    case 0x47504653: return "GPFS";
    case 0x19830326: return "BeeGFS";
    case 0x7461636F: return "OCFS2";
    case 0x01161970: return "GFS2";
    case 0x01021997: return "9P";
    case 0x65735546: return "FUSE";  // among them SSHFS and GlusterFS
    default: return "";
  }
}

// ---- opening ------------------------------------------------------------------------------------------------------
void StoreDatabase::take_lock() {
  struct stat info {};
  if (stat(path.c_str(), &info) == 0 && !S_ISREG(info.st_mode))
    fail(std::string("is ") + (S_ISDIR(info.st_mode) ? "a folder" : "not a regular file") + "; expected a file");
  made = access(path.c_str(), F_OK) != 0;
  lock = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (lock >= 0 && lock <= STDERR_FILENO) {  // else text for standard error would be written into the database
    const int higher = fcntl(lock, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
    close(lock);
    lock = higher;
  }
  if (lock < 0) fail(std::string("cannot be written: ") + std::strerror(errno));
  if (!network_file_system.empty()) return;  // NFS maps flock to the locks of ranges, which SQLite takes itself
  if (flock(lock, LOCK_EX | LOCK_NB) != 0) {
    if (errno == EWOULDBLOCK) fail("is in use by another run; wait for it, or choose another output folder");
    fail(std::string("cannot be locked: ") + std::strerror(errno));
  }
}

void StoreDatabase::open_for_writing() {
  network_file_system = network_file_system_of(path);
  take_lock();
  sql = std::make_unique<SQLite::Database>(path, SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE | kOwnLock, 10000);
  // Before anything is read: without shared memory a WAL database can be opened in exclusive mode only.
  if (!network_file_system.empty()) sql->exec("PRAGMA locking_mode=EXCLUSIVE");
  check_identity();
  if (network_file_system.empty()) {
    // WAL and NORMAL: a killed program loses nothing that was committed, a power cut at most the last cells.
    sql->exec("PRAGMA journal_mode=WAL");
    sql->exec("PRAGMA synchronous=NORMAL");
  } else {
    // A write-ahead log is memory that processes share, which those of two hosts cannot (sqlite.org/wal.html).
    sql->exec("PRAGMA journal_mode=DELETE");
    sql->exec("PRAGMA synchronous=FULL");
    sql->exec("BEGIN EXCLUSIVE; COMMIT");  // held until the store is closed
  }
  sql->exec("PRAGMA cache_size=-65536");  // 64 MB: keys are hashes, so that entries are written all over the file
  if (version() != kStoreSchema) {
    SQLite::Transaction transaction(*sql);
    if (version() == 0) sql->exec(kStoreTablesSql);
    else migrate_store(*this);
    sql->exec("PRAGMA application_id=" + std::to_string(kStoreApplication));
    sql->exec("PRAGMA user_version=" + std::to_string(kStoreSchema));
    write_totals();
    forget_statements();  // some may refer to the old tables
    transaction.commit();
    changes.clear();
  }
  check_tables();
  for (const StoreTable* table : kStoreTables) {
    if (!table->counted || read_keys(*table).empty()) continue;
    SQLite::Transaction transaction(*sql);
    sql->exec(std::string("REINDEX ") + table->name);  // keys are read from the index, which may be what is damaged
    if (const std::string wrong = read_keys(*table); !wrong.empty()) damaged(wrong);
    transaction.commit();
  }
}

void StoreDatabase::open_new() {
  network_file_system = network_file_system_of(path);
  take_lock();
  struct stat info {};
  if (fstat(lock, &info) == 0 && info.st_nlink > 1) {  // a killed program left it as a second name of a whole store
    unlink(path.c_str());
    close(lock);
    take_lock();
  }
  // On a network file system take_lock leaves locking to SQLite, which cannot lock what is truncated under it. A lock
  // of the open file, of a byte that SQLite does not lock, holds until the file is closed.
  struct flock first_byte {};
  first_byte.l_type = F_WRLCK, first_byte.l_whence = SEEK_SET, first_byte.l_len = 1;
  if (!network_file_system.empty() && fcntl(lock, F_OFD_SETLK, &first_byte) != 0) {
    if (errno == EAGAIN || errno == EACCES) fail("is in use by another merge; wait for it, or choose another file");
    fail(std::string("cannot be locked: ") + std::strerror(errno));
  }
  if (ftruncate(lock, 0) != 0) fail(std::strerror(errno));  // what a killed program left
  sql = std::make_unique<SQLite::Database>(path, SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE | kOwnLock, 10000);
  sql->exec("PRAGMA journal_mode=OFF");  // nobody reads it before it is complete
  sql->exec("PRAGMA synchronous=OFF");
  sql->exec("PRAGMA cache_size=-65536");
  sql->exec(kStoreTablesSql);
  sql->exec("PRAGMA application_id=" + std::to_string(kStoreApplication));
  sql->exec("PRAGMA user_version=" + std::to_string(kStoreSchema));
}

// Even to read a database in WAL mode, SQLite makes files beside it. Where it may not make them and there is no log,
// the database cannot change either and is opened as immutable.
void StoreDatabase::open_for_reading(bool count_keys) {
  struct stat info {};
  if (stat(path.c_str(), &info) == 0 && !S_ISREG(info.st_mode))
    fail(std::string("is ") + (S_ISDIR(info.st_mode) ? "a folder" : "not a regular file") + "; expected a file");
  const std::size_t slash = path.rfind('/');
  const std::string folder = slash == std::string::npos ? "." : path.substr(0, slash + 1);
  if (access(folder.c_str(), W_OK) == 0 && access(path.c_str(), W_OK) == 0) {
    sql = std::make_unique<SQLite::Database>(path, SQLite::OPEN_READWRITE | kOwnLock, 10000);
  } else if (access((path + "-wal").c_str(), F_OK) == 0) {
    sql = std::make_unique<SQLite::Database>(path, SQLite::OPEN_READONLY | kOwnLock, 10000);
  } else {
    std::string address = "file:";
    for (const char c : path) {  // RFC 3986: characters that would end the path
      if (c == '%' || c == '?' || c == '#') {
        char escaped[4];
        std::snprintf(escaped, sizeof escaped, "%%%02X", static_cast<unsigned>(static_cast<unsigned char>(c)));
        address += escaped;
      } else {
        address += c;
      }
    }
    sql = std::make_unique<SQLite::Database>(address + "?immutable=1",
                                             SQLite::OPEN_READONLY | SQLite::OPEN_URI | kOwnLock);
  }
  check_identity();
  empty = version() == 0;
  if (empty || version() != kStoreSchema) return;
  sql->exec("PRAGMA cache_size=-65536");
  // One snapshot until the store is closed: writes by other programs are not seen.
  sql->exec("BEGIN");
  check_tables();
  for (const StoreTable* table : kStoreTables) {
    if (!table->counted) continue;
    if (!count_keys) keys[table];  // no entry is missed
    // The keys of a million cells are 70 MB: they are kept only when `find` misses an entry.
    else if (const std::string wrong = read_keys(*table, table == &kCampaigns); !wrong.empty())
      fail("is damaged (" + wrong + "); `atwood run` builds a damaged index again, or says to move the file away");
  }
}

int StoreDatabase::version() { return sql->execAndGet("PRAGMA user_version").getInt(); }

void StoreDatabase::check_identity() {
  const int application = sql->execAndGet("PRAGMA application_id").getInt();
  const int tables = sql->execAndGet("SELECT count(*) FROM sqlite_master").getInt();
  if (tables == 0 && application == 0 && version() == 0) return;
  const auto refuse = [&](const std::string& what) { throw StoreOfAnother("store " + path + ": " + what); };
  if (application != kStoreApplication)
    refuse("is an SQLite database of another program; choose another output folder");
  if (version() > kStoreSchema) {
    refuse("a newer atwood wrote it (schema " + std::to_string(version()) + "; this one reads up to schema " +
           std::to_string(kStoreSchema) + "); use that one, or choose another output folder");
  }
  if (version() < kStoreSchema - 1) {
    refuse("has schema " + std::to_string(version()) + "; this program reads schemas " +
           std::to_string(kStoreSchema - 1) + " and " + std::to_string(kStoreSchema) +
           "; move it away, and the next run starts afresh");
  }
}

void StoreDatabase::check_tables() {
  std::set<std::string> there;
  SQLite::Statement select(*sql, "SELECT name FROM sqlite_master WHERE type='table'");
  while (select.executeStep()) there.insert(select.getColumn(0).getString());
  std::vector<std::string> expected{"totals"};
  for (const StoreTable* table : kStoreTables) expected.emplace_back(table->name);
  for (const std::string& name : expected)
    if (!there.contains(name)) damaged("it has no table `" + name + "`");
}

void StoreDatabase::remove_new_store() {
  forget_statements();
  sql.reset();
  if (!made) return;
  for (const char* suffix : {"", "-wal", "-shm", "-journal"}) unlink((path + suffix).c_str());
}

}  // namespace atwood
