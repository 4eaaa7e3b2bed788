#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string_view>

#include "tests/laboratory/io/report_file.h"
#include "tests/laboratory/laboratory.h"

namespace sweepstake::cli {
namespace {

struct ReportOptions {
  std::vector<std::string> documents;
  std::string out;
};

// Returns what is wrong with a document; empty if the page can draw it.
std::string ErrorOf(const nlohmann::json& document) {
  const nlohmann::json command =
      document.is_object() ? document.value("command", nlohmann::json()) : nlohmann::json();
  if (command != "bench" && command != "experiment" && command != "replay") {
    return "is not a document of `sweepstake-lab bench|experiment|replay --json`";
  }
  const bool has_rows = document.contains("rows") && document["rows"].is_array();
  return has_rows && !document["rows"].empty() ? "" : "has no rows, so there is nothing to draw";
}

Result<std::string> ReadDocument(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    return Status(StatusCode::kNotFound,
                  path + " cannot be read; check the path and the permissions");
  }
  std::string text{std::istreambuf_iterator<char>(file), {}};
  const std::string error = ErrorOf(nlohmann::json::parse(text, nullptr, false));
  if (error.empty()) return text;
  return Status(StatusCode::kInvalidArgument, path + ' ' + error);
}

Status Report(const ReportOptions& options, Terminal& terminal) {
  std::vector<std::string> documents;
  for (const std::string& path : options.documents) {
    std::error_code none_there;
    if (std::filesystem::equivalent(path, options.out, none_there)) {
      return {StatusCode::kInvalidArgument,
              "--out " + options.out +
                  " would overwrite a document; choose another name for the report"};
    }
    auto document = ReadDocument(path);
    if (!document.ok()) return document.status();
    documents.push_back(std::move(*document));
  }
  return WriteReport(options.out, documents, terminal);
}

void Declare(CLI::App& command, ReportOptions& options) {
  command
      .add_option("documents", options.documents,
                  "JSON files printed by bench, experiment or replay with --json")
      ->required();
  command.add_option("--out", options.out, "HTML file to write")->required();
}

}  // namespace

void AddReportCommand(const CommandContext& context) {
  AddCommand<ReportOptions>(
      context, "report", "Charts and tables of JSON results as one HTML file that needs no network",
      "  sweepstake-lab bench --scene suite-b --json > bench.json\n"
      "  sweepstake-lab report bench.json --out bench.html\n"
      "  sweepstake-lab report results/experiment.json bench.json --out all.html\n",
      Declare, [](const ReportOptions& options, Terminal& terminal) {
        const Status status = Report(options, terminal);
        return status.ok() ? kDone : Fail(terminal, status);
      });
}

}  // namespace sweepstake::cli
