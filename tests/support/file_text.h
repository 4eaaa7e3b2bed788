// Returns the content of a file for tests; an empty text if the file does not exist.
#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace sweepstake::test_support {

inline std::string FileText(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace sweepstake::test_support
