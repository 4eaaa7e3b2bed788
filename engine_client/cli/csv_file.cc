#include "engine_client/cli/csv_file.h"

#include <system_error>
#include <utility>

namespace sweepstake::cli {

std::string QuoteCsv(std::string_view cell) {
  if (cell.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(cell);
  std::string quoted = "\"";
  for (const char character : cell) {
    if (character == '"') quoted += '"';
    quoted += character;
  }
  return quoted + '"';
}

CsvFile::CsvFile(std::filesystem::path path)
    : path_(std::move(path)),
      temporary_path_(path_.string() + ".partial"),
      file_(temporary_path_, std::ios::binary | std::ios::trunc) {}

CsvFile::~CsvFile() {
  file_.close();
  std::error_code ignored;
  std::filesystem::remove(temporary_path_, ignored);
}

Result<std::unique_ptr<CsvFile>> CsvFile::Create(std::filesystem::path path,
                                                 std::initializer_list<std::string_view> header) {
  std::unique_ptr<CsvFile> csv(new CsvFile(std::move(path)));
  csv->Row(header);
  if (!csv->file_) {
    return Status(StatusCode::kInvalidArgument, csv->path_.string() + " cannot be written");
  }
  return csv;
}

void CsvFile::Row(std::initializer_list<std::string_view> cells) {
  bool first = true;
  for (const std::string_view cell : cells) {
    if (!first) file_ << ',';
    file_ << QuoteCsv(cell);
    first = false;
  }
  file_ << "\r\n";
}

Status CsvFile::Commit() {
  file_.close();
  std::error_code error;
  if (file_) std::filesystem::rename(temporary_path_, path_, error);
  if (!file_ || error) {
    return {StatusCode::kInvalidArgument, path_.string() + " could not be written"};
  }
  return {};
}

}  // namespace sweepstake::cli
