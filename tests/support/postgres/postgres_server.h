// A real PostgreSQL server for a test, with its own directory and a socket in it.
//
// PostgreSQL refuses to run as root; the server then runs as "nobody".
#pragma once

#include <memory>
#include <string>

#include "tests/support/child_process.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::test_support {

class PostgresServer {
 public:
  // Creates the server's files and starts it. Aborts the test program if that fails. With `synced`
  // it has Debian's default settings. Without `synced`, commits are not synced to the disk: they
  // survive a killed process, but not a crash of the machine. It also uses little memory and runs
  // no background work.
  explicit PostgresServer(bool synced = false);
  ~PostgresServer();
  PostgresServer(const PostgresServer&) = delete;
  PostgresServer& operator=(const PostgresServer&) = delete;

  // Creates an empty database and returns its URL.
  std::string NewDatabase();
  // Sends SIGKILL to the server's main process and to its children, which serve connections.
  void Kill();
  // Starts the server again after Kill, and waits until it answers.
  void Start();

 private:
  void Make();

  const bool synced_;
  TemporaryDirectory directory_;
  int database_count_ = 0;
  std::unique_ptr<ChildProcess> process_;
};

}  // namespace sweepstake::test_support
