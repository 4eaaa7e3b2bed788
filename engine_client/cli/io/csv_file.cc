#include "engine_client/cli/io/csv_file.h"

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

Result<std::unique_ptr<CsvFile>> CsvFile::Create(std::filesystem::path path,
                                                 std::initializer_list<std::string_view> header) {
  auto file = WholeFile::Create(std::move(path));
  if (!file.ok()) return file.status();
  std::unique_ptr<CsvFile> csv(new CsvFile(std::move(*file)));
  csv->Row(header);
  return csv;
}

void CsvFile::Row(std::initializer_list<std::string_view> cells) {
  std::string line;
  const char* separator = "";
  for (const std::string_view cell : cells) {
    line += separator + QuoteCsv(cell);
    separator = ",";
  }
  file_->Write(line + "\r\n");
}

}  // namespace sweepstake::cli
