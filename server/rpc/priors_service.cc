#include "server/rpc/priors_service.h"

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/rpc/message_validation.h"
#include "server/rpc/proto_conversion.h"
#include "server/rpc/watch_hub.h"

namespace sweepstake::rpc {
namespace {

using priors::PriorRecord;
using RecordPage = absl::StatusOr<std::vector<PriorRecord>>;

// One export. On the decision loop but for gRPC's reactions, which only post. Owns itself until
// gRPC is done with it; what the store reads for it finds it through a weak pointer.
class PriorExport final : public grpc::ServerWriteReactor<v1::ExportPriorsResponse>,
                          public std::enable_shared_from_this<PriorExport> {
 public:
  static PriorExport* Start(ServiceContext& context, priors::SceneFilter filter) {
    std::shared_ptr<PriorExport> exporter(new PriorExport(context, std::move(filter)));
    PriorExport* raw = exporter.get();
    raw->self_ = std::move(exporter);
    context.loop.Post([raw] { raw->LoadPage(); });
    return raw;
  }

  void OnWriteDone(bool ok) override {
    context_.loop.Post(
        [this, ok] { ok ? LoadPage() : End(absl::CancelledError("the connection was lost")); });
  }
  // A write under way fails and a page under way is written to nobody: both end here soon.
  void OnCancel() override {}
  void OnDone() override {
    context_.loop.Post([this] { self_.reset(); });
  }

 private:
  PriorExport(ServiceContext& context, priors::SceneFilter filter)
      : context_(context), filter_(std::move(filter)) {}

  void LoadPage() {
    if (complete_) return End(absl::OkStatus());
    const bool submitted =
        context_.store.Submit([weak = weak_from_this(), &loop = context_.loop, filter = filter_,
                               after = last_](priors::PriorStore& store) {
          loop.Post([weak, page = store.Export(filter, after, kRecordsPerMessage)] {
            if (const auto self = weak.lock()) self->OnPage(page);
          });
        });
    if (!submitted)
      End(absl::UnavailableError("the prior store has too much to do; export again later"));
  }

  void OnPage(const RecordPage& page) {
    if (!page.ok()) return End(page.status());
    if (page->empty()) return End(absl::OkStatus());
    response_.clear_records();
    for (const PriorRecord& record : *page) FillRecord(record, *response_.add_records());
    last_ = page->back();
    complete_ = page->size() < kRecordsPerMessage;
    StartWrite(&response_);
  }

  void End(const absl::Status& status) { Finish(ToGrpc(status)); }

  ServiceContext& context_;
  const priors::SceneFilter filter_;
  std::shared_ptr<PriorExport> self_;  // until OnDone
  std::optional<PriorRecord> last_;    // the next page follows it
  bool complete_ = false;              // there is no next page
  v1::ExportPriorsResponse response_;
};

// One import. Reading is all on gRPC's reactions, one at a time; the store's job ends the call.
class PriorImport final : public grpc::ServerReadReactor<grpc::ByteBuffer> {
 public:
  // `collected_count` is of all imports together.
  PriorImport(ServiceContext& context, std::atomic<size_t>& collected_count,
              grpc::CallbackServerContext& call, grpc::ByteBuffer& response)
      : context_(context), collected_count_(collected_count), call_(call), response_(response) {
    StartRead(&bytes_);
  }
  ~PriorImport() override { collected_count_ -= records_.size(); }

  void OnReadDone(bool ok) override {
    if (ok) {
      const absl::Status status = Take();
      if (!status.ok()) return Finish(ToGrpc(status));
      return StartRead(&bytes_);
    }
    // A lost connection must not pass for the end of the file.
    if (call_.IsCancelled())
      return Finish(ToGrpc(absl::CancelledError("the stream broke off; nothing was imported")));
    if (!context_.store.Submit([this](priors::PriorStore& store) { Apply(store); })) {
      Finish(
          ToGrpc(absl::UnavailableError("the prior store has too much to do; import again later")));
    }
  }

  void OnDone() override { delete this; }

 private:
  absl::Status Take() {
    if (!Parse(bytes_, request_)) {
      ++context_.counters.malformed_message_count;
      return absl::InvalidArgumentError(
          "a message does not parse as sweepstake.v1.ImportPriorsRequest");
    }
    if (request_.records_size() > static_cast<int>(kRecordsPerMessage)) {
      return absl::InvalidArgumentError(
          absl::StrCat("a message may hold ", kRecordsPerMessage, " records"));
    }
    for (const v1::PriorRecord& record : request_.records()) {
      if (records_.size() == kMaxImportRecords) {
        return absl::ResourceExhaustedError(
            absl::StrCat("an import may hold ", kMaxImportRecords, " records; split it"));
      }
      if (collected_count_ >= 2 * size_t{kMaxImportRecords}) {
        return absl::ResourceExhaustedError("other imports are under way; import again later");
      }
      if (const absl::Status status = CheckPriorRecord(record); !status.ok()) {
        return absl::InvalidArgumentError(
            absl::StrCat("record ", records_.size(), ": ", status.message()));
      }
      records_.push_back(RecordOf(record));
      ++collected_count_;
    }
    return absl::OkStatus();
  }

  void Apply(priors::PriorStore& store) {
    const auto result = store.Import(records_);
    if (!result.ok()) return Finish(ToGrpc(result.status()));
    v1::ImportPriorsResponse answer;
    answer.set_applied_count(result->applied_count);
    answer.set_unchanged_count(result->unchanged_count);
    response_ = Serialize(answer);
    context_.loop.Post([&watchers = context_.watchers] { watchers.OnImport(); });
    Finish(grpc::Status::OK);
  }

  ServiceContext& context_;
  std::atomic<size_t>& collected_count_;
  grpc::CallbackServerContext& call_;
  grpc::ByteBuffer& response_;
  grpc::ByteBuffer bytes_;
  v1::ImportPriorsRequest request_;
  std::vector<PriorRecord> records_;
};

}  // namespace

grpc::ServerWriteReactor<v1::ExportPriorsResponse>* PriorsService::ExportPriors(
    grpc::CallbackServerContext* /*call*/, const v1::ExportPriorsRequest* request) {
  return PriorExport::Start(context_, {request->project(), request->scene()});
}

grpc::ServerReadReactor<grpc::ByteBuffer>* PriorsService::ImportPriors(
    grpc::CallbackServerContext* call, grpc::ByteBuffer* response) {
  return new PriorImport(context_, collected_count_, *call, *response);
}

}  // namespace sweepstake::rpc
