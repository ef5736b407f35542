#pragma once
#include <sys/types.h>

#include <string>
#include <vector>

namespace backbend::validate {

/// A pipe whose ends no other child inherits. Throws ReadError.
struct Pipe {
  int read_end = -1, write_end = -1;
  Pipe();
  ~Pipe();
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  void close_read();
  void close_write();
};

/// Starts a program found on PATH, without a shell and in a process group of its own, on these
/// descriptors; -1 is /dev/null. Throws ReadError.
pid_t spawn_child(const std::vector<std::string>& argv, int input, int output, int complaints);

/// Waits for its end: its exit code, 128 + signal where a signal ended it.
int wait_for_child(pid_t child);
/// The same of what waitpid() has given.
int exit_code_of(int status);

}  // namespace backbend::validate
