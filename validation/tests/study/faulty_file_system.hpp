// SQLite's file system with faults: the n-th call of chosen kinds fails, or every call from the n-th on.
#pragma once

namespace atwood {

struct FileFaults {
  enum Kind {
    reading = 1,
    writing = 2,
    syncing = 4,
    opening = 8,
    removing = 16,
    mapping = 32,
    locking = 64,
    memory = 128
  };
  int kinds = 0;
  long at = 0;             // which call fails, from 1; 0: none
  bool and_later = false;  // those after it too, as on a full disk
  bool disk_full = false;  // how a write fails; else by an input/output error
  long count = 0;          // calls of these kinds so far
};

// What fails from now on in every database that is opened with SQLite's usual file system.
extern FileFaults g_file_faults;

// Puts the faults before SQLite's usual file system and its allocator, while it exists. No database is open then.
class FaultyFileSystem {
 public:
  FaultyFileSystem();
  FaultyFileSystem(const FaultyFileSystem&) = delete;
  FaultyFileSystem& operator=(const FaultyFileSystem&) = delete;
  ~FaultyFileSystem();
};

}  // namespace atwood
