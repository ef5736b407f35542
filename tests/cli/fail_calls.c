/* Preloaded into the program under test: fails one call of one kind on a file below a folder.
 *
 * FAULT_KIND    write fsync close rename open mkdir unlink symlink; any: all of them, but opening to read
 * FAULT_NUMBER  the number that call returns in errno; 0: write half of what was asked; -1: the program is killed
 *               before the call
 * FAULT_AT      which of these calls fails, from 1; 0: none, and all are counted
 * FAULT_FOLDER  only files below it count
 * FAULT_PROGRAM only in the program of this name
 * FAULT_COUNT   file that receives the number of calls at exit
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static long calls;

static const char *setting(const char *name) {
  const char *value = getenv(name);
  return value ? value : "";
}

static int below(const char *path) {
  const char *folder = setting("FAULT_FOLDER");
  size_t length = strlen(folder);
  return length > 0 && strncmp(path, folder, length) == 0;
}

static int fd_path(int fd, char *path, size_t room) {
  char link[64];
  snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
  ssize_t length = readlink(link, path, room - 1);
  if (length < 0) return 0;
  path[length] = 0;
  return 1;
}

/* Of a file that is open: folders hold nothing that closing them could lose. */
static int fd_below(int fd) {
  char path[4096];
  struct stat facts;
  return fstat(fd, &facts) == 0 && !S_ISDIR(facts.st_mode) && fd_path(fd, path, sizeof path) && below(path);
}

/* Of a name in a folder that is open. */
static int at_below(int folder, const char *name) {
  char path[8192];
  if (*name == '/' || folder == AT_FDCWD) return below(name);
  if (!fd_path(folder, path, 4096)) return 0;
  strcat(path, "/");
  strncat(path, name, 4000);
  return below(path);
}

/* Whether this call is the one to fail. */
static int fails(const char *kind) {
  const char *wanted = setting("FAULT_KIND");
  if (strcmp(wanted, kind) != 0 && strcmp(wanted, "any") != 0) return 0;
  const char *program = setting("FAULT_PROGRAM");
  if (*program && strcmp(program, program_invocation_short_name) != 0) return 0;
  pthread_mutex_lock(&lock);
  long number = ++calls;
  pthread_mutex_unlock(&lock);
  if (number != atol(setting("FAULT_AT"))) return 0;
  if (atoi(setting("FAULT_NUMBER")) == -1) kill(getpid(), SIGKILL);
  return 1;
}

static int error_number(void) { return atoi(setting("FAULT_NUMBER")); }

__attribute__((destructor)) static void tell(void) {
  const char *file = setting("FAULT_COUNT");
  if (!*file || calls == 0) return;
  FILE *out = fopen(file, "w");
  if (!out) return;
  fprintf(out, "%ld\n", calls);
  fclose(out);
}

#define NEXT(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

ssize_t write(int fd, const void *bytes, size_t count) {
  if (fd_below(fd) && fails("write")) {
    if (error_number() == 0) return NEXT(write)(fd, bytes, count > 1 ? count / 2 : count);
    errno = error_number();
    return -1;
  }
  return NEXT(write)(fd, bytes, count);
}

int fsync(int fd) {
  char path[4096];
  if (fd_path(fd, path, sizeof path) && below(path) && fails("fsync")) {
    errno = error_number();
    return -1;
  }
  return NEXT(fsync)(fd);
}

int close(int fd) {
  if (fd_below(fd) && fails("close")) {
    NEXT(close)(fd);
    errno = error_number();
    return -1;
  }
  return NEXT(close)(fd);
}

int renameat(int from_folder, const char *from, int to_folder, const char *to) {
  if (at_below(to_folder, to) && fails("rename")) {
    errno = error_number();
    return -1;
  }
  return NEXT(renameat)(from_folder, from, to_folder, to);
}

int rename(const char *from, const char *to) {
  if (below(to) && fails("rename")) {
    errno = error_number();
    return -1;
  }
  return NEXT(rename)(from, to);
}

int mkdir(const char *path, mode_t mode) {
  if (below(path) && fails("mkdir")) {
    errno = error_number();
    return -1;
  }
  return NEXT(mkdir)(path, mode);
}

int mkdirat(int folder, const char *name, mode_t mode) {
  if (at_below(folder, name) && fails("mkdir")) {
    errno = error_number();
    return -1;
  }
  return NEXT(mkdirat)(folder, name, mode);
}

/* Declares `mode`: the argument that follows `flags` where a file may be made. */
#define TAKE_MODE(flags)                      \
  mode_t mode = 0;                            \
  if ((flags) & (O_CREAT | __O_TMPFILE)) {    \
    va_list more;                             \
    va_start(more, flags);                    \
    mode = va_arg(more, mode_t);              \
    va_end(more);                             \
  }

int openat(int folder, const char *name, int flags, ...) {
  TAKE_MODE(flags)
  const int reads = (flags & O_ACCMODE) == O_RDONLY && !(flags & O_CREAT);
  if (at_below(folder, name) && !(reads && strcmp(setting("FAULT_KIND"), "any") == 0) && fails("open")) {
    errno = error_number();
    return -1;
  }
  return NEXT(openat)(folder, name, flags, mode);
}

int open(const char *path, int flags, ...) {
  TAKE_MODE(flags)
  return openat(AT_FDCWD, path, flags, mode);
}

int open64(const char *path, int flags, ...) __attribute__((alias("open")));
int openat64(int folder, const char *name, int flags, ...) __attribute__((alias("openat")));

int unlink(const char *path) {
  if (below(path) && fails("unlink")) {
    errno = error_number();
    return -1;
  }
  return NEXT(unlink)(path);
}

int unlinkat(int folder, const char *name, int flags) {
  if (at_below(folder, name) && fails("unlink")) {
    errno = error_number();
    return -1;
  }
  return NEXT(unlinkat)(folder, name, flags);
}

int remove(const char *path) {
  if (below(path) && fails("unlink")) {
    errno = error_number();
    return -1;
  }
  return NEXT(remove)(path);
}

int symlink(const char *target, const char *path) {
  if (below(path) && fails("symlink")) {
    errno = error_number();
    return -1;
  }
  return NEXT(symlink)(target, path);
}
