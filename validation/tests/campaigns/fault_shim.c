/* Lets the n-th call of one kind fail, in the program under test alone: not in what it forks. Loaded by LD_PRELOAD.
 *
 *   FAULT_PROGRAM=NAME  the last part of the program's path
 *   FAULT_CALLS=write,sync,rename,open,map,memory   the kinds that are counted together
 *   FAULT_AT=N          which of them fails; 0: none
 *   FAULT_ERRNO=N       how (not of memory)
 *   FAULT_TOLD=FILE     gets the number of calls that were counted, and 1 where one of them failed
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

enum { writing = 1, syncing = 2, renaming = 4, opening = 8, mapping = 16, memory = 32 };

static pid_t g_process;
static int g_kinds, g_errno = EIO, g_told = -1;
static long g_at;
static atomic_long g_count, g_failed;

extern void* __libc_malloc(size_t);
extern void* __libc_calloc(size_t, size_t);
extern void* __libc_realloc(void*, size_t);
extern void* __libc_memalign(size_t, size_t);

static int fails(int kind) {
  if (!(g_kinds & kind) || getpid() != g_process) return 0;
  if (atomic_fetch_add(&g_count, 1) + 1 != g_at) return 0;
  atomic_fetch_add(&g_failed, 1);
  errno = kind == memory ? ENOMEM : g_errno;
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
  if (getenv("FAULT_AT")) g_at = atol(getenv("FAULT_AT"));
  if (getenv("FAULT_ERRNO")) g_errno = atoi(getenv("FAULT_ERRNO"));
  if (told) g_told = (int)syscall(SYS_openat, AT_FDCWD, told, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (g_told >= 0) {
    const int high = (int)syscall(SYS_fcntl, g_told, F_DUPFD_CLOEXEC, 500);
    syscall(SYS_close, g_told);
    g_told = high;
  }
  g_process = getpid();
  g_kinds = (strstr(kinds, "write") ? writing : 0) | (strstr(kinds, "sync") ? syncing : 0) |
            (strstr(kinds, "rename") ? renaming : 0) | (strstr(kinds, "open") ? opening : 0) |
            (strstr(kinds, "map") ? mapping : 0) | (strstr(kinds, "memory") ? memory : 0);
}

__attribute__((destructor)) static void end(void) {
  char text[64];
  if (g_told < 0 || getpid() != g_process) return;
  const int size = snprintf(text, sizeof text, "%ld %ld\n", (long)g_count, (long)g_failed);
  syscall(SYS_write, g_told, text, (size_t)size);
}

static void* next(const char* name) { return dlsym(RTLD_NEXT, name); }

/* Standard output and error carry the message about the failure. */
ssize_t write(int file, const void* bytes, size_t size) {
  if (file > 2 && fails(writing)) return -1;
  static ssize_t (*real)(int, const void*, size_t);
  if (!real) *(void**)&real = next("write");
  return real(file, bytes, size);
}
#define OF_PWRITE(NAME)                                                       \
  ssize_t NAME(int file, const void* bytes, size_t size, off_t at) {          \
    if (fails(writing)) return -1;                                            \
    static ssize_t (*real)(int, const void*, size_t, off_t);                  \
    if (!real) *(void**)&real = next(#NAME);                                  \
    return real(file, bytes, size, at);                                       \
  }
OF_PWRITE(pwrite)
OF_PWRITE(pwrite64)
#define OF_FILE(NAME, KIND)             \
  int NAME(int file) {                  \
    if (fails(KIND)) return -1;         \
    static int (*real)(int);            \
    if (!real) *(void**)&real = next(#NAME); \
    return real(file);                  \
  }
OF_FILE(fsync, syncing)
OF_FILE(fdatasync, syncing)
#define OF_TRUNCATE(NAME)                       \
  int NAME(int file, off_t size) {              \
    if (fails(writing)) return -1;              \
    static int (*real)(int, off_t);             \
    if (!real) *(void**)&real = next(#NAME);    \
    return real(file, size);                    \
  }
OF_TRUNCATE(ftruncate)
OF_TRUNCATE(ftruncate64)
int rename(const char* from, const char* to) {
  if (fails(renaming)) return -1;
  static int (*real)(const char*, const char*);
  if (!real) *(void**)&real = next("rename");
  return real(from, to);
}
int linkat(int a, const char* from, int b, const char* to, int flags) {
  if (fails(renaming)) return -1;
  static int (*real)(int, const char*, int, const char*, int);
  if (!real) *(void**)&real = next("linkat");
  return real(a, from, b, to, flags);
}
#define OF_OPEN(NAME)                                              \
  int NAME(const char* path, int flags, ...) {                     \
    va_list more;                                                  \
    va_start(more, flags);                                         \
    const int mode = va_arg(more, int);                            \
    va_end(more);                                                  \
    if (fails(opening)) return -1;                                 \
    static int (*real)(const char*, int, int);                     \
    if (!real) *(void**)&real = next(#NAME);                       \
    return real(path, flags, mode);                                \
  }
OF_OPEN(open)
OF_OPEN(open64)
void* mmap(void* at, size_t size, int use, int flags, int file, off_t from) {
  if (fails(mapping)) return MAP_FAILED;
  return (void*)syscall(SYS_mmap, at, size, use, flags, file, from);
}
void* mmap64(void* at, size_t size, int use, int flags, int file, off_t from) {
  if (fails(mapping)) return MAP_FAILED;
  return (void*)syscall(SYS_mmap, at, size, use, flags, file, from);
}
void* malloc(size_t size) { return fails(memory) ? NULL : __libc_malloc(size); }
void* calloc(size_t count, size_t size) { return fails(memory) ? NULL : __libc_calloc(count, size); }
void* realloc(void* old, size_t size) { return fails(memory) ? NULL : __libc_realloc(old, size); }
void* aligned_alloc(size_t align, size_t size) { return fails(memory) ? NULL : __libc_memalign(align, size); }
