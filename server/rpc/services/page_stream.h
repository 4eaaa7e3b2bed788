// A response stream whose pages are read from the store, as fast as the client reads them. While
// one page is written to the client, the next one is read from the store. Every streaming export
// uses it.
#pragma once

#include <google/protobuf/message.h>

#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "absl/status/statusor.h"
#include "server/rpc/common/error_reasons.h"
#include "server/rpc/services/end_call.h"
#include "server/rpc/services/stall_sweep.h"
#include "server/sessions/prior_store.h"

namespace sweepstake::rpc {

struct StreamPage {
  // Null: nothing is sent, and the stream ends.
  std::shared_ptr<const google::protobuf::Message> response;
  bool last = false;  // the stream ends after this response
};
// Reads the next page. The function object keeps the position between calls. It runs on the store's
// reading thread.
using LoadPage = std::function<absl::StatusOr<StreamPage>(priors::PriorReader&)>;

// The transport of a stream: a gRPC call, or an HTTP request. Used on the decision loop.
class PageSink {
 public:
  virtual ~PageSink() = default;
  // Each call leads to one PageStream::OnWritten. At most one write is pending.
  virtual void Write(const std::shared_ptr<const google::protobuf::Message>& response) = 0;
  // Ends the stream. REQUIRES: no write is pending.
  virtual void Finish(const absl::Status& status) = 0;
  // Ends the stream at once, so that a pending write fails.
  virtual void Cancel(const absl::Status& status) = 0;
};

// Used on the decision loop. The sink owns the stream until the stream's last call. Results of the
// store refer to the stream by a weak pointer.
class PageStream final : public Transfer, public std::enable_shared_from_this<PageStream> {
 public:
  PageStream(ServiceContext& context, Caller caller, LoadPage load, PageSink& sink)
      : Transfer(context, std::move(caller)),
        load_(std::make_shared<const LoadPage>(std::move(load))),
        sink_(sink) {}

  // Called first. The stream ends when the caller's token is revoked or expires.
  void Begin();
  void OnWritten(bool ok);
  void OnStalled() override;

 private:
  // Reads the next page. At most one page is being read, or waits to be written.
  void LoadNext();
  void OnPage(absl::StatusOr<StreamPage> page);
  void WriteNext();
  void End(const absl::Status& status);

  const std::shared_ptr<const LoadPage> load_;
  PageSink& sink_;
  StreamPage page_;  // the page that is being written, or was written last
  std::optional<absl::StatusOr<StreamPage>>
      ahead_;  // the page after page_; absent until it was read
  bool writes_ = false;
  bool ended_ = false;
};

}  // namespace sweepstake::rpc
