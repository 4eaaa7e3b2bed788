// Fuzzes imports, promotions, commits and revocations: the messages of a client, their checks, and
// a store, whose sums must equal the sums of its records.
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "server/rpc/common/message_validation.h"
#include "server/rpc/common/proto_conversion.h"
#include "server/storage/record_limits.h"
#include "server/storage/sqlite_prior_store.h"
#include "sweepstake/v1/priors.pb.h"
#include "tests/fuzz/input.h"

namespace sweepstake::storage {
namespace {

using fuzz::Input;
using fuzz::Require;
using priors::PriorRecord;
using priors::PriorStore;

constexpr uint32_t kAll = 1'000'000;
constexpr uint64_t kMaxWaiting = 50;

// A store, and the conditions that must hold after every operation.
class Subject {
 public:
  void Import(const std::vector<PriorRecord>& records, bool waits) {
    const auto once = Take(records, waits);
    if (!once.ok()) return;
    Require(once->applied_count + once->unchanged_count == records.size(), "each record counts");
    const auto again = Take(records, waits);
    Require(again.ok() && again->applied_count == 0, "a second import changes nothing");
  }
  void Promote(const std::string& source_id, bool preview) {
    const auto expected = store_->Promote({.id = source_id}, /*preview=*/true);
    const auto promoted = store_->Promote({.id = source_id}, preview);
    Require(expected.ok() && promoted.ok() && *expected == *promoted,
            "a preview equals the promotion");
  }
  void Commit(const PriorRecord& record) {
    priors::SourceUpdate update;
    update.progress.source_id = record.source_id;
    update.progress.commit_sequence = record.source_sequence;
    update.increments.push_back({record.key, record.evidence});
    (void)store_->Commit({&update, 1});
  }
  void Revoke(const std::string& source_id) {
    const auto expected = store_->Revoke({.id = source_id}, /*preview=*/true);
    const auto revoked = store_->Revoke({.id = source_id}, /*preview=*/false);
    Require(expected.ok() == revoked.ok(), "a preview fails if the revocation fails");
    Require(!revoked.ok() || *expected == *revoked, "a preview equals the revocation");
  }
  // Compares the sums of the scenes with the sums of the records.
  void Check() {
    const auto exported = store_->Export({}, {}, kAll);
    Require(exported.ok() && CheckRecords(exported->records).ok(), "stored evidence is valid");
    const auto waiting = store_->ExportQuarantined({}, {}, kAll);
    Require(waiting.ok() && CheckRecords(waiting->records).ok(), "quarantined evidence is valid");
    std::map<priors::SceneKey, SceneSum> sums;
    for (const PriorRecord& record : exported->records) {
      const priors::EvidenceKey& key = record.key;
      SceneSum& sum = sums[{key.project, key.scene, key.machine_class, key.reward_version}];
      sum.sources.insert(record.source_id);
      sum.Add(key, record.evidence);
    }
    const auto scenes = store_->List({}, std::nullopt, kAll);
    Require(scenes.ok() && scenes->size() == sums.size(), "each scene has records");
    for (const priors::SceneEvidence& scene : *scenes) Compare(scene, sums[scene.key]);
  }

 private:
  struct SceneSum {
    std::set<std::string> sources;
    priors::SceneEvidence evidence;

    // Adds evidence. As in the store, counts do not rise above kMaxCount.
    void Add(const priors::EvidenceKey& key, const priors::Evidence& more) {
      priors::Evidence& sum =
          evidence.ArmOf(key.arm, key.backend_version).regimes[key.regime].of(key.measured_by);
      sum += more;
      sum.window_count = std::min(sum.window_count, kMaxCount);
      sum.bail_out_count = std::min(sum.bail_out_count, kMaxCount);
    }
  };

  absl::StatusOr<priors::ImportResult> Take(const std::vector<PriorRecord>& records, bool waits) {
    return waits ? store_->Quarantine(records, kMaxWaiting) : store_->Import(records);
  }
  // SQLite adds in another order, and sums counts beyond 2^53 as floating-point numbers.
  static bool IsNear(double a, double b) {
    return std::isfinite(a) && a >= 0 && std::abs(a - b) <= 1e-9 * (1 + std::abs(b));
  }
  static bool IsNear(uint64_t a, uint64_t b) {
    return IsNear(static_cast<double>(a), static_cast<double>(b));
  }
  static void Compare(const priors::SceneEvidence& scene, const SceneSum& sum) {
    Require(scene.source_count == sum.sources.size(), "sources are counted");
    Require(scene.arms.size() == sum.evidence.arms.size(), "arms are the same");
    for (size_t arm = 0; arm < scene.arms.size(); ++arm) {
      const auto& regimes = scene.arms[arm].regimes;
      auto expected = sum.evidence.arms[arm].regimes.begin();
      Require(regimes.size() == sum.evidence.arms[arm].regimes.size(), "regimes are the same");
      for (const auto& [regime, measured] : regimes) {
        Require(regime == expected->first, "regimes are the same");
        Compare(measured.live, expected->second.live);
        Compare((expected++)->second.lane, measured.lane);
      }
    }
  }
  static void Compare(const priors::Evidence& a, const priors::Evidence& b) {
    Require(IsNear(a.alpha, b.alpha) && IsNear(a.beta, b.beta), "sums are the same");
    Require(IsNear(a.window_count, b.window_count) && IsNear(a.bail_out_count, b.bail_out_count),
            "counts are the same");
  }

  const std::unique_ptr<PriorStore> store_ = *OpenMemoryPriorStore();
};

// Returns the records of one import, or nullopt if the daemon refuses it.
std::optional<std::vector<PriorRecord>> Read(std::string_view bytes) {
  v1::ImportPriorsRequest request;
  if (!request.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return std::nullopt;
  std::vector<PriorRecord> records;
  for (const v1::PriorRecord& record : request.records()) {
    if (!rpc::CheckPriorRecord(record).ok()) return std::nullopt;
    records.push_back(FromProto(record));
  }
  return records;
}

void Run(Input input) {
  Subject store;
  while (!input.empty()) {
    const uint8_t step = input.Byte();
    const auto records = Read(input.Piece());
    if (!records) continue;
    if (step % 4 != 1 && step % 4 != 2) store.Import(*records, /*waits=*/step % 8 == 3);
    for (const PriorRecord& record : *records) {
      if (step % 8 == 7) store.Promote(record.source_id, /*preview=*/step % 16 == 7);
      if (step % 4 == 1) store.Commit(record);
      if (step % 4 == 2) store.Revoke(record.source_id);
    }
  }
  store.Check();
}

}  // namespace
}  // namespace sweepstake::storage

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  sweepstake::storage::Run({data, size});
  return 0;
}
