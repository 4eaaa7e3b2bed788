#include "tests/engine_client/cli/command_run.h"

#include <sstream>
#include <vector>

namespace sweepstake::cli {

CommandRun RunCommand(const std::string& arguments, int (*run)(std::span<char* const>, Terminal&)) {
  std::istringstream text("sweepstake " + arguments);
  std::vector<std::string> words;
  for (std::string word; std::getline(text, word, ' ');) words.push_back(word);
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  std::ostringstream out;
  std::ostringstream err;
  Terminal terminal{.out = out, .err = err};
  const int exit_code = run(pointers, terminal);
  return {exit_code, out.str(), err.str()};
}

}  // namespace sweepstake::cli
