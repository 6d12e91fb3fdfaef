/* Lets the n-th call of one kind fail, in the program under test alone: not in what it forks. Loaded by LD_PRELOAD.
 *
 *   FAULT_PROGRAM=NAME  the last part of the program's path
 *   FAULT_CALLS=read,write,sync,rename,remove,open,map,memory   the kinds that are counted together
 *   FAULT_FILES=TEXT    only calls on files whose path contains the text (not of memory)
 *   FAULT_AT=N          which of them fails; 0: none
 *   FAULT_ERRNO=N       how (not of memory)
 *   FAULT_TOLD=FILE     gets a line "failed CALL PATH" where a call failed, and at the end the number of calls that were counted
 *   FAULT_STACKS=1      FAULT_TOLD gets a line "stack HASH" for each call stack that allocates, once
 *   FAULT_STACK=HASH    in place of FAULT_AT: the first allocation with this call stack fails
 *
 * A call stack is the three innermost return addresses, each relative to its library: the same in every run.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <execinfo.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

enum { writing = 1, syncing = 2, renaming = 4, opening = 8, mapping = 16, memory = 32, reading = 64, removing = 128 };

static pid_t g_process;
static int g_kinds, g_errno = EIO, g_told = -1;
static long g_at;
static const char* g_files;
static atomic_long g_count;
static int g_stacks;
static uint64_t g_stack;

extern void* __libc_malloc(size_t);
extern void* __libc_calloc(size_t, size_t);
extern void* __libc_realloc(void*, size_t);
extern void* __libc_memalign(size_t, size_t);

static void tell(const char* call, const char* path) {
  char text[4400];
  if (g_told < 0) return;
  const int size = snprintf(text, sizeof text, "failed %s %s\n", call, path);
  syscall(SYS_write, g_told, text, (size_t)size);
}

static int is_counted(int kind) { return (g_kinds & kind) && getpid() == g_process; }

/* /proc/PID/stat: the search for a worker's descendants reads as many as there are processes. */
static int is_search(const char* path) {
  const size_t size = strlen(path);
  return strncmp(path, "/proc/", 6) == 0 && path[6] >= '0' && path[6] <= '9' && size > 5 && strcmp(path + size - 5, "/stat") == 0;
}

static int is_chosen(int kind, const char* call, const char* path) {
  if (g_files && kind != memory && !strstr(path, g_files)) return 0;
  if (is_search(path)) return 0;
  if (atomic_fetch_add(&g_count, 1) + 1 != g_at) return 0;
  if (kind != memory) tell(call, path);
  errno = kind == memory ? ENOMEM : g_errno;
  return 1;
}

static int fails_path(int kind, const char* call, const char* path) {
  return is_counted(kind) && is_chosen(kind, call, path);
}

static int fails_file(int kind, const char* call, int file) {
  char link[64], path[4096] = "";
  if (!is_counted(kind)) return 0;
  snprintf(link, sizeof link, "/proc/self/fd/%d", file);
  const ssize_t size = syscall(SYS_readlinkat, AT_FDCWD, link, path, sizeof path - 1);
  path[size > 0 ? size : 0] = '\0';
  return is_chosen(kind, call, path);
}

enum { deepest = 3, own_frames = 3, most_stacks = 1 << 16 };

static uint64_t stack_hash(void) {
  void* at[deepest + own_frames];
  const int count = backtrace(at, deepest + own_frames);
  uint64_t hash = 14695981039346656037u; /* FNV-1a */
  for (int i = own_frames; i < count; ++i) {
    Dl_info place;
    const uintptr_t base = dladdr(at[i], &place) ? (uintptr_t)place.dli_fbase : 0;
    hash = (hash ^ ((uintptr_t)at[i] - base)) * 1099511628211u;
  }
  return hash ? hash : 1;
}

/* Whether this allocation is the first of its call stack, which is told or fails. */
static int is_chosen_stack(void) {
  static _Thread_local int inside;
  static atomic_flag busy = ATOMIC_FLAG_INIT;
  static uint64_t known[most_stacks];
  if (inside) return 0;
  inside = 1;
  const uint64_t hash = stack_hash();
  inside = 0;
  if (g_stack) {
    static atomic_int done;
    return hash == g_stack && atomic_exchange(&done, 1) == 0;
  }
  while (atomic_flag_test_and_set(&busy)) {}
  size_t i = hash % most_stacks, steps = 0;
  while (known[i] && known[i] != hash && ++steps < most_stacks) i = (i + 1) % most_stacks;
  const int is_new = known[i] == 0;
  known[i] = hash;
  atomic_flag_clear(&busy);
  if (!is_new || g_told < 0) return 0;
  char text[64];
  const int size = snprintf(text, sizeof text, "stack %llx\n", (unsigned long long)hash);
  syscall(SYS_write, g_told, text, (size_t)size);
  return 0;
}

static int fails_memory(void) {
  if (g_stack || g_stacks) {
    if (!is_counted(memory) || !is_chosen_stack()) return 0;
    errno = ENOMEM;
    if (g_told >= 0) syscall(SYS_write, g_told, "failed malloc \n", (size_t)15);
    return 1;
  }
  if (!is_counted(memory) || !is_chosen(memory, "malloc", "")) return 0;
  if (g_told >= 0) syscall(SYS_write, g_told, "failed malloc \n", (size_t)15);
  return 1;
}

__attribute__((constructor)) static void begin(void) {
  static char path[4096];
  const char* wanted = getenv("FAULT_PROGRAM");
  const char* kinds = getenv("FAULT_CALLS");
  const char* told = getenv("FAULT_TOLD");
  const ssize_t size = readlink("/proc/self/exe", path, sizeof path - 1);
  if (!wanted || !kinds || size <= 0) return;
  path[size] = '\0';
  const char* name = strrchr(path, '/') + 1;
  if (strcmp(name, wanted) != 0) return;
  g_files = getenv("FAULT_FILES");
  if (getenv("FAULT_AT")) g_at = atol(getenv("FAULT_AT"));
  if (getenv("FAULT_ERRNO")) g_errno = atoi(getenv("FAULT_ERRNO"));
  if (told) g_told = (int)syscall(SYS_openat, AT_FDCWD, told, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (g_told >= 0) {
    const int high = (int)syscall(SYS_fcntl, g_told, F_DUPFD_CLOEXEC, 500);
    syscall(SYS_close, g_told);
    g_told = high;
  }
  g_stacks = getenv("FAULT_STACKS") != NULL;
  if (getenv("FAULT_STACK")) g_stack = strtoull(getenv("FAULT_STACK"), NULL, 16);
  if (g_stacks || g_stack) stack_hash(); /* its first call loads a library */
  g_process = getpid();
  g_kinds = (strstr(kinds, "write") ? writing : 0) | (strstr(kinds, "sync") ? syncing : 0) |
            (strstr(kinds, "rename") ? renaming : 0) | (strstr(kinds, "open") ? opening : 0) |
            (strstr(kinds, "map") ? mapping : 0) | (strstr(kinds, "memory") ? memory : 0) |
            (strstr(kinds, "read") ? reading : 0) | (strstr(kinds, "remove") ? removing : 0);
}

__attribute__((destructor)) static void end(void) {
  char text[64];
  if (g_told < 0 || getpid() != g_process) return;
  const int size = snprintf(text, sizeof text, "counted %ld\n", (long)g_count);
  syscall(SYS_write, g_told, text, (size_t)size);
}

static void* next(const char* name) { return dlsym(RTLD_NEXT, name); }

/* Standard output and error carry the message about the failure. */
ssize_t write(int file, const void* bytes, size_t size) {
  if (file > 2 && fails_file(writing, "write", file)) return -1;
  static ssize_t (*real)(int, const void*, size_t);
  if (!real) *(void**)&real = next("write");
  return real(file, bytes, size);
}
#define OF_PWRITE(NAME)                                                       \
  ssize_t NAME(int file, const void* bytes, size_t size, off_t at) {          \
    if (fails_file(writing, #NAME, file)) return -1;                          \
    static ssize_t (*real)(int, const void*, size_t, off_t);                  \
    if (!real) *(void**)&real = next(#NAME);                                  \
    return real(file, bytes, size, at);                                       \
  }
ssize_t writev(int file, const struct iovec* parts, int count) {
  if (file > 2 && fails_file(writing, "writev", file)) return -1;
  static ssize_t (*real)(int, const struct iovec*, int);
  if (!real) *(void**)&real = next("writev");
  return real(file, parts, count);
}
#define OF_PREAD(NAME)                                                        \
  ssize_t NAME(int file, void* bytes, size_t size, off_t at) {                \
    if (fails_file(reading, #NAME, file)) return -1;                          \
    static ssize_t (*real)(int, void*, size_t, off_t);                        \
    if (!real) *(void**)&real = next(#NAME);                                  \
    return real(file, bytes, size, at);                                       \
  }
OF_PREAD(pread)
OF_PREAD(pread64)
ssize_t read(int file, void* bytes, size_t size) {
  if (fails_file(reading, "read", file)) return -1;
  static ssize_t (*real)(int, void*, size_t);
  if (!real) *(void**)&real = next("read");
  return real(file, bytes, size);
}
OF_PWRITE(pwrite)
OF_PWRITE(pwrite64)
#define OF_FILE(NAME, KIND)             \
  int NAME(int file) {                  \
    if (fails_file(KIND, #NAME, file)) return -1; \
    static int (*real)(int);            \
    if (!real) *(void**)&real = next(#NAME); \
    return real(file);                  \
  }
OF_FILE(fsync, syncing)
OF_FILE(fdatasync, syncing)
#define OF_TRUNCATE(NAME)                       \
  int NAME(int file, off_t size) {              \
    if (fails_file(writing, #NAME, file)) return -1; \
    static int (*real)(int, off_t);             \
    if (!real) *(void**)&real = next(#NAME);    \
    return real(file, size);                    \
  }
OF_TRUNCATE(ftruncate)
OF_TRUNCATE(ftruncate64)
int rename(const char* from, const char* to) {
  if (fails_path(renaming, "rename", to)) return -1;
  static int (*real)(const char*, const char*);
  if (!real) *(void**)&real = next("rename");
  return real(from, to);
}
int linkat(int a, const char* from, int b, const char* to, int flags) {
  if (fails_path(renaming, "linkat", to)) return -1;
  static int (*real)(int, const char*, int, const char*, int);
  if (!real) *(void**)&real = next("linkat");
  return real(a, from, b, to, flags);
}
int unlink(const char* path) {
  if (fails_path(removing, "unlink", path)) return -1;
  static int (*real)(const char*);
  if (!real) *(void**)&real = next("unlink");
  return real(path);
}
#define OF_OPEN(NAME)                                              \
  int NAME(const char* path, int flags, ...) {                     \
    va_list more;                                                  \
    va_start(more, flags);                                         \
    const int mode = va_arg(more, int);                            \
    va_end(more);                                                  \
    if (fails_path(opening, #NAME, path)) return -1;                                 \
    static int (*real)(const char*, int, int);                     \
    if (!real) *(void**)&real = next(#NAME);                       \
    return real(path, flags, mode);                                \
  }
OF_OPEN(open)
OF_OPEN(open64)
#define OF_STREAM(NAME)                                           \
  FILE* NAME(const char* path, const char* how) {                 \
    if (fails_path(opening, #NAME, path)) return NULL;             \
    static FILE* (*real)(const char*, const char*);                \
    if (!real) *(void**)&real = next(#NAME);                       \
    return real(path, how);                                        \
  }
OF_STREAM(fopen)
OF_STREAM(fopen64)
void* mmap(void* at, size_t size, int use, int flags, int file, off_t from) {
  if (fails_file(mapping, "mmap", file)) return MAP_FAILED;
  return (void*)syscall(SYS_mmap, at, size, use, flags, file, from);
}
void* mmap64(void* at, size_t size, int use, int flags, int file, off_t from) {
  if (fails_file(mapping, "mmap", file)) return MAP_FAILED;
  return (void*)syscall(SYS_mmap, at, size, use, flags, file, from);
}
void* malloc(size_t size) { return fails_memory() ? NULL : __libc_malloc(size); }
void* calloc(size_t count, size_t size) { return fails_memory() ? NULL : __libc_calloc(count, size); }
void* realloc(void* old, size_t size) { return fails_memory() ? NULL : __libc_realloc(old, size); }
void* aligned_alloc(size_t align, size_t size) { return fails_memory() ? NULL : __libc_memalign(align, size); }
