// Ends the processes that a worker leaves behind: its descendants, also those in a session of their own. Linux only.
//
// A worker leads a session of its own, so its descendants are found by their session. One that left the session
// (setsid after a double fork) has lost its parent and was adopted by this program, a subreaper; it is recognised by
// the environment variable that its worker was started with. An adopted orphan that names no running worker is killed
// as soon as it is seen: at the next look at the memory of any worker, or at the next end of one.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <mutex>
#include <string>

namespace atwood {

// "ATWOOD_WORKER=<pid of this program>.<number>": one per worker, inherited by all that it starts.
std::string next_worker_mark();

// Locks the list of running workers. Held while a worker is forked and entered in the list, so that no other thread
// takes a worker that is not entered yet for an orphan.
std::unique_lock<std::mutex> lock_workers();
void enter_worker(pid_t pid, const std::string& mark);  // under lock_workers()

// Makes this program a subreaper: it adopts orphans from now on.
void adopt_orphans();

// Kills the descendants of the worker, waits for them and removes the worker from the list. The worker itself has ended
// and was not waited for: as long as it is a zombie, no other process gets its number.
void kill_descendants(pid_t worker, const std::string& mark);

// Resident memory of one process, with what it shares; 0: it has ended.
std::int64_t resident_bytes(pid_t process);
// Memory of the worker and its descendants, as far as they are known, a tenth of a second ago at most, with the files
// in memory that they hold open and that have no name (memfd_create(2), deleted files in a tmpfs). What several of them
// share, and files that they have mapped, are taken out where the sum is above `most`.
std::int64_t family_bytes(pid_t worker, const std::string& mark, std::int64_t most);
// Kills the worker and its descendants, and leaves them to be waited for.
void kill_family(pid_t worker, const std::string& mark);

}  // namespace atwood
