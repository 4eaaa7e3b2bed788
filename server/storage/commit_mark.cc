#include "server/storage/commit_mark.h"

#include <fstream>
#include <system_error>

#include "server/storage/private_file.h"

namespace sweepstake::storage {

uint64_t CommitMark::Read() const {
  uint64_t count = 0;
  std::ifstream(file_) >> count;
  return count;
}

void CommitMark::Write(uint64_t count) {
  if (written_ == count) return;
  const std::filesystem::path unfinished = file_.string() + ".new";
  if (!CreatePrivateFile(unfinished).ok()) return;
  if (!(std::ofstream(unfinished) << count << '\n' << std::flush)) return;
  std::error_code error;
  std::filesystem::rename(unfinished, file_, error);
  if (!error) written_ = count;
}

}  // namespace sweepstake::storage
