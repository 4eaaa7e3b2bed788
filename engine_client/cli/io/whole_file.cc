#include "engine_client/cli/io/whole_file.h"

#include <string>
#include <system_error>
#include <utility>

#include "engine_client/text/csv.h"

namespace sweepstake::cli {

WholeFile::WholeFile(std::filesystem::path path)
    : path_(std::move(path)),
      temporary_path_(path_.string() + ".partial"),
      file_(temporary_path_, std::ios::binary | std::ios::trunc) {}

WholeFile::~WholeFile() {
  file_.close();
  std::error_code ignored;
  std::filesystem::remove(temporary_path_, ignored);
}

Result<std::unique_ptr<WholeFile>> WholeFile::Create(std::filesystem::path path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (path.filename().empty() ||
      (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))) {
    return Status(StatusCode::kInvalidArgument,
                  "'" + path.string() +
                      "' cannot be written: it is not a regular file; give the path of a file");
  }
  std::unique_ptr<WholeFile> file(new WholeFile(std::move(path)));
  if (!file->file_) {
    return Status(
        StatusCode::kInvalidArgument,
        file->path_.string() + " cannot be written; check that its folder exists and is writable");
  }
  return file;
}

void WholeFile::Write(std::string_view bytes) {
  file_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

void WholeFile::WriteRow(std::initializer_list<std::string_view> cells) {
  std::string line;
  text::AppendCsvLine(line, cells);
  Write(line + "\r\n");
}

Status WholeFile::Commit() {
  file_.close();
  std::error_code error;
  if (file_) std::filesystem::rename(temporary_path_, path_, error);
  if (!file_ || error) {
    return {StatusCode::kInvalidArgument,
            path_.string() + " cannot be written; check that its disk is not full"};
  }
  return {};
}

Status WriteWhole(const std::filesystem::path& path, std::string_view bytes) {
  const auto file = WholeFile::Create(path);
  if (!file.ok()) return file.status();
  (*file)->Write(bytes);
  return (*file)->Commit();
}

}  // namespace sweepstake::cli
