// Where a command writes: results on `out`, everything else on `err`. Streams are borrowed.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <ostream>
#include <string>

#include "sweepstake/status.h"

namespace sweepstake::cli {

// The exit codes of the contract.
enum ExitCode : int { kDone = 0, kCheckFailed = 1, kBadUsage = 2, kUnreachable = 3 };

struct Terminal {
  std::ostream& out;
  std::ostream& err;
  bool err_is_tty = false;
  size_t err_columns = 0;  // 0: no terminal
};

// Prints "sweepstake: MESSAGE" and gives the exit code that fits: kUnreachable for kUnavailable,
// kCheckFailed for kInternal, else kBadUsage.
int Fail(Terminal& terminal, const Status& status);

// The start of `text` (UTF-8) that fits into `columns`, a character in each.
std::string CutToColumns(const std::string& text, size_t columns);

// How far long work has come, on `err`: a bar redrawn ten times a second at most and cut to the
// terminal's width, or, where `err` is no terminal, a line per ten seconds. Not thread-safe.
class Progress {
 public:
  // `total` 0 shows no bar, only the text.
  Progress(Terminal& terminal, std::string label, uint64_t total);
  // Ends the redrawn line.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // Cheap between redraws.
  void Show(uint64_t done, const std::string& text = {});
  // Whether Show would draw now; saves composing a text that nobody sees.
  bool due() const;
  // A line of its own above the bar.
  void Line(const std::string& text);
  // Takes the bar away, so that another stream may write to the same terminal.
  void ClearBar();

 private:
  using Time = std::chrono::steady_clock::time_point;

  void Draw(uint64_t done, const std::string& text);

  Terminal& terminal_;
  std::string label_;
  uint64_t total_;
  Time drawn_at_;
  bool drawn_ = false;
};

}  // namespace sweepstake::cli
