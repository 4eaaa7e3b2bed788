#include "engine_client/cli/io/csv_file.h"

#include <string>
#include <utility>

#include "engine_client/decider/audit/csv.h"

namespace sweepstake::cli {

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
    line += separator;
    decision::AppendCsv(line, cell);
    separator = ",";
  }
  file_->Write(line + "\r\n");
}

}  // namespace sweepstake::cli
