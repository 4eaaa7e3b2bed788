#include "engine_client/cli/replay/decision_log.h"

#include "server/decision/audit_log.h"

namespace sweepstake::cli {

Result<std::unique_ptr<DecisionLog>> DecisionLog::Create(const std::filesystem::path& path) {
  auto log = CreateEmpty(path);
  if (log.ok()) (*log)->WriteLine(decision::AuditHeader());
  return log;
}

Result<std::unique_ptr<DecisionLog>> DecisionLog::CreateEmpty(const std::filesystem::path& path) {
  auto file = WholeFile::Create(path);
  if (!file.ok()) return file.status();
  return std::unique_ptr<DecisionLog>(new DecisionLog(std::move(*file)));
}

void DecisionLog::WriteLine(std::string_view line) {
  file_->Write(line);
  file_->Write("\n");
}

}  // namespace sweepstake::cli
