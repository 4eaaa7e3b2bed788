// Fuzzes imports, promotions, commits and revocations: the messages of a client, their checks, and
// both stores, which must agree.
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "server/rpc/common/message_validation.h"
#include "server/rpc/common/proto_conversion.h"
#include "server/storage/memory/memory_prior_store.h"
#include "server/storage/record_limits.h"
#include "server/storage/sqlite_prior_store.h"
#include "sweepstake/v1/priors.pb.h"
#include "tests/fuzz/input.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::storage {
namespace {

namespace fs = std::filesystem;
using fuzz::Input;
using fuzz::Require;
using priors::PriorRecord;
using priors::PriorStore;

constexpr uint32_t kAll = 1'000'000;
constexpr uint64_t kMaxWaiting = 50;

std::unique_ptr<PriorStore> Open(const fs::path& path) {
  auto store = OpenSqlitePriorStore(path);
  Require(store.ok(), "a store can be opened");
  return *std::move(store);
}

// Opens a new, empty store and removes the former one. It copies an empty file, which is faster
// than creating a store.
std::unique_ptr<PriorStore> OpenEmpty() {
  static const test_support::TemporaryDirectory kFolder;
  const fs::path empty = kFolder.path() / "empty.db";
  const fs::path path = kFolder.path() / "priors.db";
  if (!fs::exists(empty)) {
    Open(path).reset();
    fs::rename(path, empty);
  }
  for (const fs::path& file :
       {path, fs::path(path.string() + "-wal"), fs::path(path.string() + "-shm")})
    fs::remove(file);
  fs::copy_file(empty, path);
  return Open(path);
}

// Applies each operation to both stores.
class Stores {
 public:
  void Import(const std::vector<PriorRecord>& records, bool waits) {
    const auto by_file =
        waits ? sqlite_->Quarantine(records, kMaxWaiting) : sqlite_->Import(records);
    const auto by_memory =
        waits ? memory_.Quarantine(records, kMaxWaiting) : memory_.Import(records);
    Require(by_file.status().code() == by_memory.status().code(), "imports have equal results");
    if (!by_file.ok()) return;
    Require(by_file->applied_count == by_memory->applied_count,
            "imports apply equally many records");
    Require(by_file->unchanged_count == by_memory->unchanged_count,
            "imports ignore equally many records");
  }
  void Promote(const std::string& source_id, bool preview) {
    const auto by_file = sqlite_->Promote({.id = source_id}, preview);
    const auto by_memory = memory_.Promote({.id = source_id}, preview);
    Require(by_file.ok() && *by_file == *by_memory, "promotions have equal effects");
  }
  void Commit(const PriorRecord& record) {
    priors::SourceUpdate update;
    update.progress.source_id = record.source_id;
    update.progress.commit_sequence = record.source_sequence;
    update.increments.push_back({record.key, record.evidence});
    const absl::Status by_file = sqlite_->Commit({&update, 1});
    Require(by_file.code() == memory_.Commit({&update, 1}).code(), "commits have equal results");
  }
  void Revoke(const std::string& source_id) {
    const auto by_file = sqlite_->Revoke({.id = source_id}, false);
    const auto by_memory = memory_.Revoke({.id = source_id}, false);
    Require(by_file.status().code() == by_memory.status().code(), "revocations have equal results");
    Require(!by_file.ok() || *by_file == *by_memory, "revocations remove equally many records");
  }
  void Compare() {
    const auto by_file = sqlite_->Export({}, {}, kAll);
    const auto by_memory = memory_.Export({}, {}, kAll);
    Require(by_file.ok() && by_memory.ok() && by_file->records == by_memory->records,
            "records are the same");
    const auto waiting = sqlite_->ExportQuarantined({}, {}, kAll);
    Require(waiting.ok() && waiting->records == memory_.ExportQuarantined({}, {}, kAll)->records,
            "records that wait are the same");
    Require(CheckRecords(by_file->records).ok(), "stored records are valid");
    CompareSums(*sqlite_->List({}, std::nullopt, kAll), *memory_.List({}, std::nullopt, kAll));
  }

 private:
  // SQLite adds in another order, and counts above 2^53 as floating-point numbers.
  static bool IsNear(double a, double b) {
    return std::isfinite(a) && a >= 0 && std::abs(a - b) <= 1e-9 * (1 + std::abs(b));
  }
  static bool IsNear(uint64_t a, uint64_t b) {
    return IsNear(static_cast<double>(a), static_cast<double>(b));
  }
  static void CompareSums(const std::vector<priors::SceneEvidence>& by_file,
                          const std::vector<priors::SceneEvidence>& by_memory) {
    Require(by_file.size() == by_memory.size(), "scenes are the same");
    for (size_t scene = 0; scene < by_file.size(); ++scene) {
      Require(by_file[scene].key == by_memory[scene].key, "keys are the same");
      Require(by_file[scene].source_count == by_memory[scene].source_count,
              "source counts are the same");
      Require(by_file[scene].arms.size() == by_memory[scene].arms.size(), "arms are the same");
      for (size_t arm = 0; arm < by_file[scene].arms.size(); ++arm) {
        CompareSums(by_file[scene].arms[arm].live, by_memory[scene].arms[arm].live);
        CompareSums(by_file[scene].arms[arm].lane, by_memory[scene].arms[arm].lane);
      }
    }
  }
  static void CompareSums(const priors::Evidence& a, const priors::Evidence& b) {
    Require(IsNear(a.alpha, b.alpha) && IsNear(a.beta, b.beta), "sums are the same");
    Require(IsNear(a.window_count, b.window_count) && IsNear(a.bail_out_count, b.bail_out_count),
            "counts are the same");
  }

  std::unique_ptr<PriorStore> sqlite_ = OpenEmpty();
  MemoryPriorStore memory_;
};

// Returns the records of one import, or nullopt if the daemon refuses it.
std::optional<std::vector<PriorRecord>> Read(std::string_view bytes) {
  v1::ImportPriorsRequest request;
  if (!request.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return std::nullopt;
  std::vector<PriorRecord> records;
  for (const v1::PriorRecord& record : request.records()) {
    if (!rpc::CheckPriorRecord(record).ok()) return std::nullopt;
    records.push_back(rpc::FromProto(record));
  }
  return records;
}

void Run(Input input) {
  Stores stores;
  while (!input.empty()) {
    const uint8_t step = input.Byte();
    const auto records = Read(input.Piece());
    if (!records) continue;
    if (step % 4 != 1 && step % 4 != 2) stores.Import(*records, /*waits=*/step % 8 == 3);
    for (const PriorRecord& record : *records) {
      if (step % 8 == 7) stores.Promote(record.source_id, /*preview=*/step % 16 == 7);
      if (step % 4 == 1) stores.Commit(record);
      if (step % 4 == 2) stores.Revoke(record.source_id);
    }
  }
  stores.Compare();
}

}  // namespace
}  // namespace sweepstake::storage

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  sweepstake::storage::Run({data, size});
  return 0;
}
