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

// Returns the lists that the page needs to draw the document of `command`.
std::vector<std::string> ListsOf(const std::string& command) {
  if (command == "bench") return {"rows", "ratios"};
  if (command == "replay") return {"rows"};
  if (command == "experiment") {
    return {"arms", "sittings", "cells", "rows", "runs", "truths", "over_cells", "over_live"};
  }
  return {};
}

// Returns what is wrong with a document; empty if it can be drawn.
std::string ErrorOf(const nlohmann::json& document) {
  const bool named = document.is_object() && document.contains("command");
  const auto lists = named && document["command"].is_string()
                         ? ListsOf(document["command"].get<std::string>())
                         : std::vector<std::string>();
  if (lists.empty()) return "is not a document of `sweepstake-lab bench|experiment|replay --json`";
  for (const std::string& list : lists) {
    if (!document.contains(list) || !document[list].is_array()) return "has no list '" + list + "'";
  }
  return document["rows"].empty() ? "has no rows, so there is nothing to draw" : "";
}

Result<std::string> ReadDocument(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return Status(StatusCode::kNotFound, path + " cannot be read");
  std::string text{std::istreambuf_iterator<char>(file), {}};
  const std::string error = ErrorOf(nlohmann::json::parse(text, nullptr, false));
  if (error.empty()) return text;
  return Status(StatusCode::kInvalidArgument, path + ' ' + error);
}

Status WriteReport(const ReportOptions& options, Terminal& terminal) {
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
  auto file = ReportFile::Create(options.out);
  return file.ok() ? (*file)->Commit(documents, terminal) : file.status();
}

void Declare(CLI::App& command, ReportOptions& options) {
  command
      .add_option("documents", options.documents,
                  "JSON files printed by bench, experiment or replay with --json")
      ->required();
  command.add_option("--out", options.out, "The HTML file")->required();
}

}  // namespace

void AddReportCommand(CLI::App& app, Terminal& terminal, int& exit_code) {
  AddCommand<ReportOptions>(
      app, "report", "Charts and tables of JSON results as one HTML file that needs no network",
      "  sweepstake-lab bench --scene suite-b --json > bench.json\n"
      "  sweepstake-lab report bench.json --out bench.html\n"
      "  sweepstake-lab report results/experiment.json bench.json --out all.html\n",
      exit_code, Declare, [&terminal](const ReportOptions& options) {
        const Status status = WriteReport(options, terminal);
        return status.ok() ? kDone : Fail(terminal, status);
      });
}

}  // namespace sweepstake::cli
