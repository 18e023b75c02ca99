#pragma once

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <sstream>
#include <string>

namespace battery_sof::test {

/**
 * @brief What a command says on standard error in a process that may write files of so many bytes
 * at most; it must exit with 2.
 * @param command int(err).
 */
template <typename Command>
std::string limitedTo(rlim_t bytes, Command&& command) {
  int ends[2];
  EXPECT_EQ(::pipe(ends), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    const rlimit limit{bytes, bytes};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    std::ostringstream err;
    const int code = command(err);
    const std::string said = err.str();
    ::_exit(::write(ends[1], said.data(), said.size()) < 0 ? 99 : code);
  }
  ::close(ends[1]);
  std::string said;
  char block[4096];
  for (ssize_t count = 0; (count = ::read(ends[0], block, sizeof block)) > 0;)
    said.append(block, static_cast<std::size_t>(count));
  ::close(ends[0]);
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status)) << "ended by signal " << WTERMSIG(status);
  EXPECT_EQ(WEXITSTATUS(status), 2);
  return said;
}

}  // namespace battery_sof::test
