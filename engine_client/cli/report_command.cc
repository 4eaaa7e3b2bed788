#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string_view>

#include "engine_client/cli/commands.h"
#include "engine_client/cli/io/report_file.h"

namespace sweepstake::cli {
namespace {

struct ReportOptions {
  std::vector<std::string> documents;
  std::string out;
};

bool IsShown(const nlohmann::json& document) {
  if (!document.is_object() || !document.contains("command")) return false;
  const auto& command = document["command"];
  return command == "bench" || command == "experiment" || command == "replay";
}

Result<std::string> ReadDocument(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return Status(StatusCode::kNotFound, path + " cannot be read");
  std::string text{std::istreambuf_iterator<char>(file), {}};
  if (!IsShown(nlohmann::json::parse(text, nullptr, false))) {
    return Status(StatusCode::kInvalidArgument,
                  path + " is not what `sweepstake bench|experiment|replay --json` prints");
  }
  return text;
}

Status WriteReport(const ReportOptions& options, Terminal& terminal) {
  std::vector<std::string> documents;
  for (const std::string& path : options.documents) {
    auto document = ReadDocument(path);
    if (!document.ok()) return document.status();
    documents.push_back(std::move(*document));
  }
  auto file = ReportFile::Create(options.out);
  return file.ok() ? (*file)->Commit(documents, terminal) : file.status();
}

void Declare(CLI::App& command, ReportOptions& options) {
  command
      .add_option("documents", options.documents,
                  "Files with what bench, experiment or replay printed with --json")
      ->required();
  command.add_option("--out", options.out, "The HTML file")->required();
}

}  // namespace

void AddReportCommand(CLI::App& app, Terminal& terminal, int& exit_code) {
  AddCommand<ReportOptions>(
      app, "report", "Charts and tables of JSON results as one HTML file that needs no network",
      "  sweepstake bench --scene suite-b --json > bench.json\n"
      "  sweepstake report bench.json --out bench.html\n"
      "  sweepstake report results/experiment.json bench.json --out all.html\n",
      exit_code, Declare, [&terminal](const ReportOptions& options) {
        const Status status = WriteReport(options, terminal);
        return status.ok() ? kDone : Fail(terminal, status);
      });
}

}  // namespace sweepstake::cli
