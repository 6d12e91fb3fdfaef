// What a worker leaves behind: its children, theirs, and those of them that made themselves independent. Linux.
//
// A worker leads a session of its own, so its descendants are found by their session. One that left the session
// (setsid after a double fork) has lost its parent and was adopted by this program, a subreaper; it is told by the
// environment variable that its worker was started with.
#pragma once

#include <sys/types.h>

#include <mutex>
#include <string>

namespace atwood {

// "ATWOOD_WORKER=<pid of this program>.<number>": one a worker, inherited by all that it starts.
std::string next_worker_mark();

// Workers that live. Held while one is forked and entered, so that nobody takes a worker that is not entered yet for an
// orphan.
std::unique_lock<std::mutex> lock_workers();
void enter_worker(pid_t pid);  // under lock_workers()

// Orphans come to this program from now on.
void adopt_orphans();

// Kills and buries what the worker left behind and takes it off the list. The worker itself has ended and was not waited
// for: as long as it is a zombie, no other process gets its number. Descendants with an environment of their own are
// found when the last worker leaves.
void kill_descendants(pid_t worker, const std::string& mark);

}  // namespace atwood
