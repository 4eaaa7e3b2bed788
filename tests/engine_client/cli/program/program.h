// Runs the real programs and keeps what they wrote.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace sweepstake::cli {

struct ProgramRun {
  int exit_code = -1;
  std::string out;
  std::string err;
};

// Runs `sweepstake`; `arguments` is a line for the shell.
ProgramRun RunProgram(const std::string& arguments);

// Runs `sweepstake-lab`; `arguments` is a line for the shell.
ProgramRun RunLab(const std::string& arguments);

// Runs the program that has the command: `sweepstake-lab` for `load` and `replay`, else
// `sweepstake`.
ProgramRun RunEither(const std::string& arguments);

// Runs `sweepstaked`; `arguments` is a line for the shell.
ProgramRun RunDaemonProgram(const std::string& arguments);

// Returns one command line, without the daemon's address, of each kind that connects to a daemon.
// They write to files in `folder` and read them.
std::vector<std::string> ConnectingCommands(const std::string& folder);

// Arguments of a program, and a part of the error that they must cause.
struct BadUsage {
  std::string arguments;
  std::string error;
};
// Expects that `run`, such as RunProgram, writes each error, exits with 2 and writes no result.
void ExpectBadUsage(ProgramRun (*run)(const std::string& arguments),
                    const std::vector<BadUsage>& cases);

// Returns a path that only this test process uses.
std::string TemporaryPath(const std::string& name);

// The path of a file that is removed at the end of the test.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& name) : path_(TemporaryPath(name)) {}
  ~TemporaryFile() { std::filesystem::remove(path_); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace sweepstake::cli
