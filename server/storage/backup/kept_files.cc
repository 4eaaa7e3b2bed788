#include "server/storage/backup/kept_files.h"

#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <system_error>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/storage/data_directory.h"
#include "server/storage/private_file.h"

namespace sweepstake::storage {
namespace {

namespace fs = std::filesystem;

constexpr const char* kNames[] = {DataDirectory::kTokensName, DataDirectory::kTokensMadeName,
                                  DataDirectory::kResumeKeyName};

constexpr const char* kAdd =
    "INSERT INTO kept_file (name, content, hash) VALUES (?1, ?2, row_hash(?1, ?2))";
constexpr const char* kList = "SELECT name, content FROM kept_file";

absl::StatusOr<std::string> Content(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string bytes(std::istreambuf_iterator<char>(in), {});
  if (in.bad() || !in.is_open())
    return absl::UnavailableError(absl::StrCat(file.string(), " cannot be read"));
  return bytes;
}

// Returns the content of a copy of the database `file`, which the daemon may be using.
absl::StatusOr<std::string> ContentOfDatabase(const fs::path& file, const fs::path& scratch) {
  auto database = SqliteDatabase::Open(file.string(), SqliteDatabase::OpenMode::kReadOnly);
  absl::Status status = database.status();
  if (status.ok()) status = database->Execute("PRAGMA busy_timeout = 2000");
  if (status.ok()) status = database->CopyTo(scratch.string());
  if (!status.ok()) return Explain(file, status);
  auto bytes = Content(scratch);
  std::error_code ignored;
  fs::remove(scratch, ignored);
  return bytes;
}

absl::Status Write(const fs::path& file, const std::string& bytes) {
  const fs::path unfinished = file.string() + ".new";
  if (absl::Status status = CreatePrivateFile(unfinished); !status.ok()) return status;
  if (!std::ofstream(unfinished, std::ios::binary).write(bytes.data(), std::ssize(bytes)).flush())
    return absl::UnavailableError(absl::StrCat("cannot write ", unfinished.string()));
  return PublishFile(unfinished, file);
}

}  // namespace

absl::Status AddKeptFiles(const fs::path& directory, const fs::path& scratch,
                          SqliteDatabase& copy) {
  for (const std::string name : kNames) {
    const fs::path file = directory / name;
    std::error_code unknown;  // a file that cannot be examined cannot be read either
    if (!fs::exists(file, unknown) && !unknown) continue;
    const auto bytes =
        name == DataDirectory::kTokensName ? ContentOfDatabase(file, scratch) : Content(file);
    if (!bytes.ok()) return bytes.status();
    if (absl::Status status = copy.Run(kAdd, name, SqlBytes{*bytes}); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status TakeKeptFiles(SqliteDatabase& copy, const fs::path& directory) {
  const auto files = copy.Collect<std::map<std::string, std::string>>(
      kList, [](const SqlRow& row, auto& all) { all[row.Text(0)] = row.Bytes(1); });
  if (!files.ok()) return files.status();
  absl::Status status = DropKeptFiles(copy);
  std::vector<fs::path> written;
  for (const char* name : kNames) {
    const auto kept = files->find(name);
    std::error_code unknown;
    if (!status.ok() || kept == files->end() || fs::exists(directory / name, unknown)) continue;
    status = Write(directory / name, kept->second);
    written.push_back(directory / name);
  }
  // A later restore would keep these files.
  std::error_code ignored;
  for (const fs::path& file : written) {
    if (!status.ok()) fs::remove(file, ignored);
  }
  return status;
}

absl::Status DropKeptFiles(SqliteDatabase& copy) { return copy.Execute("DELETE FROM kept_file"); }

}  // namespace sweepstake::storage
