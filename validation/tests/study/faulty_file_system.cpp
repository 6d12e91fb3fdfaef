#include "validation/tests/study/faulty_file_system.hpp"

#include <sqlite3.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace atwood {

FileFaults g_file_faults;

namespace {

sqlite3_vfs* g_usual = nullptr;  // SQLite's own
sqlite3_mem_methods g_usual_memory;

bool fails(FileFaults::Kind kind) {
  FileFaults& faults = g_file_faults;
  if ((faults.kinds & kind) == 0) return false;
  ++faults.count;
  return faults.at > 0 && (faults.count == faults.at || (faults.and_later && faults.count > faults.at));
}

// A file of SQLite's own lies behind it.
struct File {
  sqlite3_file base;
  sqlite3_file* own() { return reinterpret_cast<sqlite3_file*>(this + 1); }
};
sqlite3_file* own(sqlite3_file* file) { return reinterpret_cast<File*>(file)->own(); }

int close_file(sqlite3_file* file) { return own(file)->pMethods->xClose(own(file)); }
int read_file(sqlite3_file* file, void* bytes, int size, sqlite3_int64 at) {
  if (fails(FileFaults::reading)) return SQLITE_IOERR_READ;
  return own(file)->pMethods->xRead(own(file), bytes, size, at);
}
int write_file(sqlite3_file* file, const void* bytes, int size, sqlite3_int64 at) {
  if (fails(FileFaults::writing)) return g_file_faults.disk_full ? SQLITE_FULL : SQLITE_IOERR_WRITE;
  return own(file)->pMethods->xWrite(own(file), bytes, size, at);
}
int truncate_file(sqlite3_file* file, sqlite3_int64 size) {
  if (fails(FileFaults::writing)) return SQLITE_IOERR_TRUNCATE;
  return own(file)->pMethods->xTruncate(own(file), size);
}
int sync_file(sqlite3_file*, int) { return fails(FileFaults::syncing) ? SQLITE_IOERR_FSYNC : SQLITE_OK; }
int size_of_file(sqlite3_file* file, sqlite3_int64* size) {
  if (fails(FileFaults::reading)) return SQLITE_IOERR_FSTAT;
  return own(file)->pMethods->xFileSize(own(file), size);
}
int lock_file(sqlite3_file* file, int level) {
  if (fails(FileFaults::locking)) return SQLITE_IOERR_LOCK;
  return own(file)->pMethods->xLock(own(file), level);
}
int unlock_file(sqlite3_file* file, int level) { return own(file)->pMethods->xUnlock(own(file), level); }
int check_lock(sqlite3_file* file, int* locked) {
  if (fails(FileFaults::locking)) return SQLITE_IOERR_CHECKRESERVEDLOCK;
  return own(file)->pMethods->xCheckReservedLock(own(file), locked);
}
int control_file(sqlite3_file* file, int what, void* more) {
  return own(file)->pMethods->xFileControl(own(file), what, more);
}
int sector_size(sqlite3_file* file) { return own(file)->pMethods->xSectorSize(own(file)); }
int characteristics(sqlite3_file* file) { return own(file)->pMethods->xDeviceCharacteristics(own(file)); }
int map_shared(sqlite3_file* file, int page, int size, int extend, void volatile** memory) {
  if (fails(FileFaults::mapping)) return SQLITE_IOERR_SHMMAP;
  return own(file)->pMethods->xShmMap(own(file), page, size, extend, memory);
}
int lock_shared(sqlite3_file* file, int offset, int count, int flags) {
  if ((flags & SQLITE_SHM_LOCK) != 0 && fails(FileFaults::locking)) return SQLITE_IOERR_SHMLOCK;
  return own(file)->pMethods->xShmLock(own(file), offset, count, flags);
}
void barrier(sqlite3_file* file) { own(file)->pMethods->xShmBarrier(own(file)); }
int unmap_shared(sqlite3_file* file, int remove) { return own(file)->pMethods->xShmUnmap(own(file), remove); }

const sqlite3_io_methods kMethods{
    2,           close_file,  read_file,    write_file,   truncate_file, sync_file,       size_of_file,
    lock_file,   unlock_file, check_lock,   control_file, sector_size,   characteristics, map_shared,
    lock_shared, barrier,     unmap_shared, nullptr,      nullptr};

int open_file(sqlite3_vfs*, const char* path, sqlite3_file* file, int flags, int* out_flags) {
  file->pMethods = nullptr;
  if (fails(FileFaults::opening)) return SQLITE_CANTOPEN;
  std::memset(own(file), 0, static_cast<std::size_t>(g_usual->szOsFile));
  const int code = g_usual->xOpen(g_usual, path, own(file), flags, out_flags);
  if (own(file)->pMethods != nullptr) file->pMethods = &kMethods;
  return code;
}
int remove_file(sqlite3_vfs*, const char* path, int sync) {
  if (fails(FileFaults::removing)) return SQLITE_IOERR_DELETE;
  return g_usual->xDelete(g_usual, path, sync);
}
int access_file(sqlite3_vfs*, const char* path, int flags, int* out) {
  if (fails(FileFaults::opening)) return SQLITE_IOERR_ACCESS;
  return g_usual->xAccess(g_usual, path, flags, out);
}

sqlite3_vfs g_faulty;

void* allocate(int size) { return fails(FileFaults::memory) ? nullptr : g_usual_memory.xMalloc(size); }
void* allocate_again(void* old, int size) {
  return fails(FileFaults::memory) ? nullptr : g_usual_memory.xRealloc(old, size);
}

void require(int code, const char* what) {
  if (code != SQLITE_OK) throw std::runtime_error(what);
}

}  // namespace

FaultyFileSystem::FaultyFileSystem() {
  g_file_faults = {};
  sqlite3_shutdown();  // an allocator is chosen before SQLite begins
  require(sqlite3_config(SQLITE_CONFIG_GETMALLOC, &g_usual_memory), "SQLite's allocator");
  sqlite3_mem_methods faulty = g_usual_memory;
  faulty.xMalloc = allocate, faulty.xRealloc = allocate_again;
  require(sqlite3_config(SQLITE_CONFIG_MALLOC, &faulty), "an allocator for SQLite");
  require(sqlite3_initialize(), "SQLite's beginning");
  g_usual = sqlite3_vfs_find(nullptr);
  g_faulty = *g_usual;  // what is not replaced is SQLite's own
  g_faulty.zName = "faulty";
  g_faulty.szOsFile = static_cast<int>(sizeof(File)) + g_usual->szOsFile;
  g_faulty.xOpen = open_file, g_faulty.xDelete = remove_file, g_faulty.xAccess = access_file;
  require(sqlite3_vfs_register(&g_faulty, 1), "a file system for SQLite");
}

FaultyFileSystem::~FaultyFileSystem() {
  g_file_faults = {};
  sqlite3_vfs_unregister(&g_faulty);
  sqlite3_vfs_register(g_usual, 1);
  sqlite3_shutdown();
  sqlite3_config(SQLITE_CONFIG_MALLOC, &g_usual_memory);
  sqlite3_initialize();
}

}  // namespace atwood
