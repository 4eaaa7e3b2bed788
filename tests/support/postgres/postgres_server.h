// A real PostgreSQL server for a test, in a directory of its own and on a socket there.
//
// The server refuses to run as root: then it runs as "nobody".
#pragma once

#include <memory>
#include <string>

#include "tests/support/child_process.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::test_support {

class PostgresServer {
 public:
  // Makes the server's files and starts it. Aborts the test program if that fails. With `synced` it
  // has the settings that Debian gives it. Without, a commit is not synced to the disk, which a
  // killed process does not lose, only a machine that stops would; and it takes little memory, and
  // does nothing by itself.
  explicit PostgresServer(bool synced = false);
  ~PostgresServer();
  PostgresServer(const PostgresServer&) = delete;
  PostgresServer& operator=(const PostgresServer&) = delete;

  // Makes an empty database, and returns its URL.
  std::string NewDatabase();
  // kill -9 of its first process; those that serve connections find that out, and end.
  void Kill();
  // Starts it again after Kill, and waits until it answers.
  void Start();

 private:
  void Make();

  const bool synced_;
  TemporaryDirectory directory_;
  int database_count_ = 0;
  std::unique_ptr<ChildProcess> process_;
};

}  // namespace sweepstake::test_support
