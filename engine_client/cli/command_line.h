// The words that a program was started with as one line that a POSIX shell reads back as the same
// words. Pure function, safe from any thread.
#pragma once

#include <span>
#include <string>

namespace sweepstake::cli {

// Words of harmless characters stand as they are, the others in single quotes.
std::string CommandLine(std::span<char* const> words);

}  // namespace sweepstake::cli
